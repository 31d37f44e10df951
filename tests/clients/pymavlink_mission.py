"""pymavlink: health, position, parameters, a mission up and down, armed, paused, run to the end in AUTO, RTL.

    pymavlink_mission.py ADDRESS PLAN [watch]

With `watch` it only looks on while another ground station drives.
"""

import sys

import boat
from boat import mavlink

HEALTHY = (
    mavlink.MAV_SYS_STATUS_SENSOR_3D_GYRO | mavlink.MAV_SYS_STATUS_SENSOR_3D_ACCEL
    | mavlink.MAV_SYS_STATUS_SENSOR_3D_MAG | mavlink.MAV_SYS_STATUS_SENSOR_GPS | mavlink.MAV_SYS_STATUS_PREARM_CHECK
)


def parameters(connection):
    """All of them."""
    found = {}
    connection.param_fetch_all()
    value = boat.wait(connection, "PARAM_VALUE", what="the first parameter")
    while True:
        found[value.param_id] = value.param_value
        if len(found) == value.param_count:
            break
        value = boat.wait(connection, "PARAM_VALUE", what=f"parameter {len(found)} of {value.param_count}")
    assert found["SYSID_MYGCS"] == 255, found["SYSID_MYGCS"]
    return len(found)


def change_parameters(connection):
    """One of each kind; pymavlink sends integers as type 9 (REAL32) too."""
    for name, wanted in (("WP_RADIUS", 1.5), ("FS_ACTION", 1)):
        def send(name=name, wanted=wanted):
            connection.param_set_send(name, wanted)

        boat.ask(connection, send, "PARAM_VALUE", lambda value: value.param_id == name and value.param_value == wanted)


def pause(connection):
    """Holds until the boat lies still, then goes on."""
    boat.set_mode(connection, "HOLD")
    boat.wait(connection, "VFR_HUD", lambda hud: hud.groundspeed < 0.2, "the boat lying still")
    boat.set_mode(connection, "AUTO")


def run(connection, last):
    """Runs the mission with a pause in it; every waypoint is reported once, in order."""
    boat.arm(connection)
    boat.set_mode(connection, "AUTO")
    reached, ended = [], False
    while not ended:
        message = boat.wait(connection, ["MISSION_ITEM_REACHED", "MISSION_CURRENT"])
        if message.get_type() == "MISSION_CURRENT":
            ended = message.mission_state == mavlink.MISSION_STATE_COMPLETE
            continue
        reached.append(message.seq)
        if message.seq == 1:
            pause(connection)
    assert reached == list(range(1, last + 1)), reached


def go_home(connection, home):
    """RTL, then disarmed."""
    def is_home(position):
        return boat.distance_m(home.x, home.y, position.lat, position.lon) < 3.0

    boat.set_mode(connection, "RTL")
    boat.wait(connection, "GLOBAL_POSITION_INT", is_home, "the boat being at home")
    boat.must(connection, mavlink.MAV_CMD_COMPONENT_ARM_DISARM, 0)


def drive(connection, plan, position):
    """Runs the mission, then goes home."""
    change_parameters(connection)
    mission = boat.plan(plan)
    home = boat.as_int(mission[0], 0)
    off_m = boat.distance_m(home.x, home.y, position.lat, position.lon)
    assert off_m < 5.0, f"the boat lies {off_m:.1f} m from the mission's home"
    boat.upload(connection, mission)
    boat.compare(mission, boat.download(connection))
    run(connection, len(mission) - 1)
    go_home(connection, home)
    print("reached every waypoint, back home")


def watch(connection):
    """Sees another ground station's mission end, and reads it."""
    boat.wait(connection, "MISSION_CURRENT", lambda m: m.mission_state == mavlink.MISSION_STATE_COMPLETE, "the end")
    print(f"saw the mission end, {len(boat.download(connection))} items on board")


def main():
    address, plan, *role = sys.argv[1:]
    connection = boat.connect(address)
    assert connection.WIRE_PROTOCOL_VERSION == "2.0"
    boat.wait(connection, "SYS_STATUS", lambda s: s.onboard_control_sensors_health & HEALTHY == HEALTHY, "health")
    position = boat.wait(connection, "GLOBAL_POSITION_INT", lambda p: p.lat != 0, "a position")
    print(f"{parameters(connection)} parameters")
    if role == ["watch"]:
        watch(connection)
    else:
        drive(connection, plan, position)
    assert boat.lost(connection) == 0, f"{boat.lost(connection)} frames of the boat's lost"


main()
