"""pymavlink: health, position, parameters, a mission up and down, armed, run to the end in AUTO."""

import sys

import boat
from boat import mavlink

HEALTHY = (
    mavlink.MAV_SYS_STATUS_SENSOR_3D_GYRO | mavlink.MAV_SYS_STATUS_SENSOR_3D_ACCEL
    | mavlink.MAV_SYS_STATUS_SENSOR_3D_MAG | mavlink.MAV_SYS_STATUS_SENSOR_GPS | mavlink.MAV_SYS_STATUS_PREARM_CHECK
)


def parameters(connection):
    """All of them, one of them by name, and one changed."""
    found = {}
    connection.param_fetch_all()
    value = boat.wait(connection, "PARAM_VALUE", what="the first parameter")
    while True:
        found[value.param_id] = value.param_value
        if len(found) == value.param_count:
            break
        value = boat.wait(connection, "PARAM_VALUE", what=f"parameter {len(found)} of {value.param_count}")
    assert found["SYSID_MYGCS"] == 255, found["SYSID_MYGCS"]
    # Type 9 (REAL32) for an integer, as pymavlink does it.
    for name, wanted in (("WP_RADIUS", 1.5), ("FS_ACTION", 1)):
        def send(name=name, wanted=wanted):
            connection.param_set_send(name, wanted)

        boat.ask(connection, send, "PARAM_VALUE", lambda value: value.param_id == name and value.param_value == wanted)
    return len(found)


def main():
    connection = boat.connect(sys.argv[1])
    assert connection.WIRE_PROTOCOL_VERSION == "2.0"
    boat.wait(connection, "SYS_STATUS", lambda s: s.onboard_control_sensors_health & HEALTHY == HEALTHY, "health")
    position = boat.wait(connection, "GLOBAL_POSITION_INT", lambda p: p.lat != 0, "a position")
    print(f"{parameters(connection)} parameters")

    mission = boat.plan("harbour-survey.waypoints")
    home = boat.as_int(mission[0], 0)
    off_m = boat.distance_m(home.x, home.y, position.lat, position.lon)
    assert off_m < 5.0, f"the boat lies {off_m:.1f} m from the mission's home"
    boat.upload(connection, mission)
    boat.compare(mission, boat.download(connection))

    boat.arm(connection)
    boat.set_mode(connection, "AUTO")
    reached, ended = [], False
    while not ended:
        message = boat.wait(connection, ["MISSION_ITEM_REACHED", "MISSION_CURRENT"])
        if message.get_type() == "MISSION_ITEM_REACHED":
            reached.append(message.seq)
        else:
            ended = message.mission_state == mavlink.MISSION_STATE_COMPLETE
    assert reached == list(range(1, len(mission))), reached
    lost = connection.mav_loss
    assert lost == 0, f"{lost} frames lost"
    print("reached every waypoint, no frame lost")


main()
