"""pymavlink prepares a boat, `helmlink bridge` drives it through a relay, and every frame is looked at.

    bridge_drives.py finish|takeover|interrupt|killed|orphaned udp|tcp|pty STATION BOAT PLAN NEAR

STATION and BOAT are addresses of the boat, NEAR is how near to each waypoint it has to come in metres: it rounds the
corners. Prints `connect URL` when the bridge may be started, and `now` when it shall be ended.
"""

import sys
import time

import boat
from boat import mavlink
from relay import Relay, is_neutral, is_release, is_steering

STOPPED_S = 4.0
"""Seconds of the boat's time after the last command within which its outputs are at rest: RC_OVERRIDE_TIME is 3 s."""
REST = 1500
"""Pulse width of an output at rest, microseconds."""
LATER = 3
"""Heartbeats of the bridge during which it may not send anything more."""
GLANCE = 0.05
SEEN = ["GLOBAL_POSITION_INT", "MISSION_CURRENT", "SERVO_OUTPUT_RAW", "PARAM_VALUE"]


class Drive:
    """What the bridge sends while it drives, and where the boat goes."""

    def __init__(self, kind, station, boat_address, plan, near):
        self.station = boat.connect(station)
        self.waypoints = [boat.as_int(item, index) for index, item in enumerate(boat.plan(plan))][1:]
        self.near_m = float(near)
        self.nearest_m = [float("inf")] * len(self.waypoints)
        self.item = 0
        self.steering = []
        self.outputs = []
        self.beats = {"boat": 0, "bridge": 0}
        self.mode = None
        boat.upload(self.station, boat.plan(plan))
        boat.arm(self.station)
        self.relay = Relay(kind, boat_address)
        print(f"connect {self.relay.url}")
        self.relay.accept()

    def look(self):
        """Lets one moment pass; returns what went through the relay, in order."""
        passed = self.relay.carry(GLANCE)
        for side, message in passed:
            if side == "bridge" and is_steering(message):
                self.steering.append(message)
            elif message.get_type() == "HEARTBEAT":
                self.beats[side] += 1
                if side == "boat":
                    self.mode = message.custom_mode
        while message := self.station.recv_match(type=SEEN, blocking=False):
            if message.get_type() == "MISSION_CURRENT":
                self.item = message.seq
            elif message.get_type() == "SERVO_OUTPUT_RAW":
                self.outputs.append(message)
            elif message.get_type() == "GLOBAL_POSITION_INT":
                for index, waypoint in enumerate(self.waypoints):
                    off_m = boat.distance_m(waypoint.x, waypoint.y, message.lat, message.lon)
                    self.nearest_m[index] = min(self.nearest_m[index], off_m)
        return passed

    def until(self, condition, what):
        """Lets time pass until this is so."""
        deadline = time.monotonic() + boat.PATIENCE
        while not condition():
            assert time.monotonic() < deadline, f"waited in vain for {what}; item {self.item}, {self.steering[-3:]}"
            self.look()


def finish(drive):
    """The whole mission: every waypoint is passed, then the boat is let go in HOLD."""
    hold = drive.station.mode_mapping()["HOLD"]
    drive.until(lambda: drive.mode == hold and drive.steering, "HOLD at the end")
    drive.until(lambda: is_release(drive.steering[-1]), "the release")
    print("nearest to the waypoints: " + ", ".join(f"{off_m:.2f} m" for off_m in drive.nearest_m))
    assert max(drive.nearest_m) < drive.near_m, drive.nearest_m
    assert drive.item == len(drive.waypoints), f"the ground station saw item {drive.item} last"
    assert all(message.get_srcSystem() == 255 for message in drive.steering), "overrides need SYSID_MYGCS"
    neutral = [message for message in drive.steering[-50:] if is_neutral(message)]
    assert neutral, "not stopped before it was let go"


def takeover(drive):
    """The pilot changes the mode under way: the bridge lets go, and sends nothing more."""
    drive.until(lambda: drive.item >= 2, "being under way to item 2")
    boat.set_mode(drive.station, "STEERING")
    drive.until(lambda: is_release(drive.steering[-1]), "the release")
    sent = len(drive.steering)
    wanted = drive.beats["bridge"] + LATER
    drive.until(lambda: drive.beats["bridge"] >= wanted, "heartbeats of the bridge")
    late = [message for message in drive.steering[sent:] if not is_release(message)]
    assert not late, f"steered after letting go: {late}"


def interrupt(drive):
    """Ctrl-C under way: motors neutral, then released, then nothing: the bridge ends."""
    drive.until(lambda: drive.item >= 2, "being under way to item 2")
    print("now")
    drive.until(lambda: is_release(drive.steering[-1]), "the release")
    *before, last = [message for message in drive.steering if not is_release(message)]
    assert is_neutral(last), f"let go while driving: {last}"
    assert not all(is_neutral(message) for message in before[-200:]), "the boat was not driving"


def killed(drive):
    """The bridge vanishes under way: the flight controller forgets its overrides and the receiver's sticks count."""
    drive.until(lambda: drive.item >= 2, "being under way to item 2")
    print(f"outputs at rest {rest_after_s(drive):.2f} s after the last command")
    assert drive.mode == drive.station.mode_mapping()["MANUAL"], f"mode {drive.mode}"


def orphaned(drive):
    """The same without a receiver: the flight controller's radio failsafe stops the boat in HOLD."""
    drive.until(lambda: drive.item >= 2, "being under way to item 2")
    drive.station.param_set_send("SIM_RC_FAIL", 1)
    drive.until(lambda: drive.station.params.get("SIM_RC_FAIL") == 1, "the receiver being gone")
    print(f"outputs at rest {rest_after_s(drive):.2f} s after the last command")
    hold = drive.station.mode_mapping()["HOLD"]
    drive.until(lambda: drive.mode == hold, "the radio failsafe")


def rest_after_s(drive):
    """Has the bridge ended; returns how long after its last command the outputs came to rest, in the boat's time."""
    outputs = drive.outputs
    print("now")
    drive.until(lambda: drive.relay.hung_up, "the bridge being gone")
    last_us = outputs[-1].time_usec if outputs else 0
    drive.until(lambda: outputs and at_rest(outputs[-1]) and outputs[-1].time_usec > last_us, "outputs at rest")
    took_s = (outputs[-1].time_usec - last_us) / 1e6
    assert took_s <= STOPPED_S, f"{took_s:.2f} s until the outputs were at rest"
    return took_s


def at_rest(output):
    """Steering and throttle of the boat's outputs are at rest."""
    return output.servo1_raw == REST and output.servo3_raw == REST


SCENES = {
    "finish": finish,
    "takeover": takeover,
    "interrupt": interrupt,
    "killed": killed,
    "orphaned": orphaned,
}


def main():
    what, *scene = sys.argv[1:]
    SCENES[what](Drive(*scene))
    print("as it should be")


main()
