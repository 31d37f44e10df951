"""A boat as a pymavlink ground station sees it: helpers for the scripts beside this file.

Everything waits for a condition. PATIENCE only decides how long a hopeless wait takes.
"""

import math
import time

from pymavlink import mavutil, mavwp

mavlink = mavutil.mavlink

PATIENCE = 90.0
"""Seconds of real time after which a wait is hopeless."""
ANSWER = 1.0
"""Seconds of real time after which a question is asked again."""
EARTH_M = 6_371_000.0


def connect(address, rate_hz=4):
    """A connection to the boat at `address`, in pymavlink's words (tcp:HOST:PORT, udpout:HOST:PORT, ...)."""
    system, component = 255, mavlink.MAV_COMP_ID_MISSIONPLANNER
    connection = mavutil.mavlink_connection(address, source_system=system, source_component=component)
    # A UDP listener hears nobody who has not spoken.
    deadline = time.monotonic() + PATIENCE
    while connection.target_system == 0:
        say_hello(connection)
        connection.wait_heartbeat(timeout=ANSWER)
        assert time.monotonic() < deadline, f"no heartbeat on {address}"
    connection.message_hooks.append(LossCounter())
    connection.mav.request_data_stream_send(1, 1, mavlink.MAV_DATA_STREAM_ALL, rate_hz, 1)
    return connection


class LossCounter:
    """Counts the boat's frames that are missing: pymavlink's own count takes in those of other stations, of which
    only some come along."""

    def __init__(self):
        self.last, self.lost = None, 0

    def __call__(self, connection, message):
        if (message.get_srcSystem(), message.get_srcComponent()) == (1, 1):
            if self.last is not None:
                self.lost += (message.get_seq() - self.last - 1) % 256
            self.last = message.get_seq()


def lost(connection):
    """Frames of the boat's that are missing since the connection was made."""
    return sum(hook.lost for hook in connection.message_hooks if isinstance(hook, LossCounter))


def say_hello(connection):
    """This ground station's heartbeat."""
    connection.mav.heartbeat_send(mavlink.MAV_TYPE_GCS, mavlink.MAV_AUTOPILOT_INVALID, 0, 0, 0)


def wait(connection, kinds, condition=lambda message: True, what=None):
    """The next message of one of these kinds for which the condition holds."""
    deadline = time.monotonic() + PATIENCE
    last = None
    while time.monotonic() < deadline:
        message = connection.recv_match(type=kinds, blocking=True, timeout=ANSWER)
        if message is not None:
            if condition(message):
                return message
            last = message
    raise AssertionError(f"waited in vain for {what or kinds}; the last was {last}")


def ask(connection, send, kinds, condition=lambda message: True, what=None):
    """Sends a question, again and again, until the answer comes."""
    deadline = time.monotonic() + PATIENCE
    while time.monotonic() < deadline:
        send()
        until = time.monotonic() + ANSWER
        while (left := until - time.monotonic()) > 0:
            message = connection.recv_match(type=kinds, blocking=True, timeout=left)
            if message is not None and condition(message):
                return message
    raise AssertionError(f"no answer: {what or kinds}")


def command(connection, number, *parameters, component=1):
    """Sends a command until it is answered; returns its MAV_RESULT."""
    parameters = (list(parameters) + [0] * 7)[:7]

    def send():
        connection.mav.command_long_send(1, component, number, 0, *parameters)

    return ask(connection, send, "COMMAND_ACK", lambda ack: ack.command == number, f"command {number}").result


def must(connection, number, *parameters, component=1):
    """A command that has to be accepted."""
    result = command(connection, number, *parameters, component=component)
    assert result == mavlink.MAV_RESULT_ACCEPTED, f"command {number} {parameters}: result {result}"


def set_mode(connection, name):
    """Changes the mode and waits until the heartbeat shows it."""
    number = connection.mode_mapping()[name]
    must(connection, mavlink.MAV_CMD_DO_SET_MODE, mavlink.MAV_MODE_FLAG_CUSTOM_MODE_ENABLED, number)
    wait(connection, "HEARTBEAT", lambda beat: of_boat(beat) and beat.custom_mode == number, f"mode {name}")


def arm(connection):
    """Waits until the boat can be armed, arms it, and sees that it is."""
    healthy = mavlink.MAV_SYS_STATUS_PREARM_CHECK
    wait(connection, "SYS_STATUS", lambda status: status.onboard_control_sensors_health & healthy, "pre-arm checks")
    must(connection, mavlink.MAV_CMD_COMPONENT_ARM_DISARM, 1)
    wait(connection, "HEARTBEAT", lambda beat: of_boat(beat) and is_armed(beat), "the boat being armed")


def of_boat(heartbeat):
    """The heartbeat is the flight controller's, not a companion's or a ground station's."""
    return heartbeat.get_srcComponent() == 1 and heartbeat.autopilot == mavlink.MAV_AUTOPILOT_ARDUPILOTMEGA


def is_armed(heartbeat):
    """The heartbeat says that the motors may turn."""
    return bool(heartbeat.base_mode & mavlink.MAV_MODE_FLAG_SAFETY_ARMED)


def plan(path):
    """The items of a mission file, home included."""
    loader = mavwp.MAVWPLoader(1, 1)
    loader.load(path)
    return [loader.wp(index) for index in range(loader.count())]


def as_int(item, sequence):
    """A MISSION_ITEM of a plan file as MISSION_ITEM_INT."""
    return mavlink.MAVLink_mission_item_int_message(
        1, 1, sequence, item.frame, item.command, item.current, item.autocontinue,
        item.param1, item.param2, item.param3, item.param4, round(item.x * 1e7), round(item.y * 1e7), item.z)


def upload(connection, items):
    """Uploads a mission, home included, as the protocol wants it."""
    items = [as_int(item, index) for index, item in enumerate(items)]

    def count():
        connection.mav.mission_count_send(1, 1, len(items), mavlink.MAV_MISSION_TYPE_MISSION)

    answers = ["MISSION_REQUEST", "MISSION_REQUEST_INT", "MISSION_ACK"]
    answer = ask(connection, count, answers, what="the first item being asked for")
    while answer.get_type() != "MISSION_ACK":
        connection.mav.send(items[answer.seq])
        answer = wait(connection, answers, what=f"an answer to item {answer.seq}")
    assert answer.type == mavlink.MAV_MISSION_ACCEPTED, f"upload: {answer}"


def download(connection):
    """The mission on board, home included."""
    def ask_for_list():
        connection.mav.mission_request_list_send(1, 1, mavlink.MAV_MISSION_TYPE_MISSION)

    count = ask(connection, ask_for_list, "MISSION_COUNT", what="MISSION_COUNT").count
    items = []
    for index in range(count):
        def ask_for_item(index=index):
            connection.mav.mission_request_int_send(1, 1, index, mavlink.MAV_MISSION_TYPE_MISSION)

        items.append(ask(connection, ask_for_item, "MISSION_ITEM_INT", lambda item, index=index: item.seq == index))
    connection.mav.mission_ack_send(1, 1, mavlink.MAV_MISSION_ACCEPTED, mavlink.MAV_MISSION_TYPE_MISSION)
    return items


def compare(sent, stored):
    """The mission on board is the one that was sent; item 0 is home, which the flight controller decides."""
    assert len(stored) == len(sent), f"{len(stored)} items on board, {len(sent)} sent"
    for index, (wanted, got) in enumerate(zip(sent, stored)):
        wanted = as_int(wanted, index)
        if index == 0:
            assert got.command == mavlink.MAV_CMD_NAV_WAYPOINT
            continue
        for field in ("seq", "frame", "command", "param1", "param2", "x", "y"):
            assert getattr(got, field) == getattr(wanted, field), f"item {index} {field}: {got} for {wanted}"


def distance_m(latitude_e7, longitude_e7, other_latitude_e7, other_longitude_e7):
    """Distance between two places in degrees times 1e7, good for a harbour."""
    north = math.radians((other_latitude_e7 - latitude_e7) / 1e7) * EARTH_M
    east = math.radians((other_longitude_e7 - longitude_e7) / 1e7) * EARTH_M * math.cos(math.radians(latitude_e7 / 1e7))
    return math.hypot(north, east)
