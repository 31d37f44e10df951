"""pymavlink prepares a boat, `helmlink bridge` drives it through a relay, and every frame is looked at.

    bridge_drives.py finish|takeover|interrupt udp|tcp|pty STATION-ADDRESS BOAT-ADDRESS PLAN

Prints `connect URL` when the bridge may be started, and `interrupt` when it shall be stopped by Ctrl-C.
"""

import sys
import time

import boat
from boat import mavlink
from relay import Relay, is_neutral, is_release, is_steering

NEAR_M = 2.0
"""How near to each waypoint the boat has to come: it rounds the corners."""
LATER = 3
"""Heartbeats of the bridge during which it may not send anything more."""
ONE_STEP = 1
"""Frames that may have been under way when the news arrived: what is sent in one control period."""
GLANCE = 0.05


class Drive:
    """What the bridge sends while it drives, and where the boat goes."""

    def __init__(self, kind, station, boat_address, plan):
        self.station = boat.connect(station)
        self.waypoints = [boat.as_int(item, index) for index, item in enumerate(boat.plan(plan))][1:]
        self.nearest_m = [float("inf")] * len(self.waypoints)
        self.item = 0
        self.steering = []
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
        while message := self.station.recv_match(type=["GLOBAL_POSITION_INT", "MISSION_CURRENT"], blocking=False):
            if message.get_type() == "MISSION_CURRENT":
                self.item = message.seq
            else:
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

    def heartbeats_later(self):
        """Lets some heartbeats of the bridge pass."""
        wanted = self.beats["bridge"] + LATER
        self.until(lambda: self.beats["bridge"] >= wanted, "heartbeats of the bridge")


def finish(drive):
    """The whole mission: every waypoint is passed, then the boat is let go in HOLD."""
    hold = drive.station.mode_mapping()["HOLD"]
    drive.until(lambda: drive.mode == hold and drive.steering, "HOLD at the end")
    drive.until(lambda: is_release(drive.steering[-1]), "the release")
    print("nearest to the waypoints: " + ", ".join(f"{off_m:.2f} m" for off_m in drive.nearest_m))
    assert max(drive.nearest_m) < NEAR_M, drive.nearest_m
    assert drive.item == len(drive.waypoints), f"the ground station saw item {drive.item} last"
    assert all(message.get_srcSystem() == 255 for message in drive.steering), "overrides need SYSID_MYGCS"
    neutral = [message for message in drive.steering[-50:] if is_neutral(message)]
    assert neutral, "not stopped before it was let go"


def takeover(drive):
    """The pilot changes the mode under way: with the next heartbeat the bridge lets go, within one control period."""
    drive.until(lambda: drive.item >= 2, "being under way to item 2")
    mode = drive.station.mode_mapping()["STEERING"]
    drive.station.mav.command_long_send(1, 1, mavlink.MAV_CMD_DO_SET_MODE, 0, 1, mode, 0, 0, 0, 0, 0)
    def tells_the_mode(message):
        return message.get_type() == "HEARTBEAT" and boat.of_boat(message) and message.custom_mode == mode

    drive.relay.hold = tells_the_mode
    after, deadline = None, time.monotonic() + boat.PATIENCE
    while after is None or not any(is_release(message) for message in after):
        assert time.monotonic() < deadline, f"not let go; after the heartbeat came {after}"
        for side, message in drive.look():
            if after is not None and side == "bridge" and is_steering(message):
                after.append(message)
            elif after is None and side == "boat" and tells_the_mode(message):
                after, told = [], time.monotonic()
    released_ms = (time.monotonic() - told) * 1000
    drive.relay.hold = lambda message: False
    driving = [message for message in after if not is_release(message)]
    print(f"let go {released_ms:.1f} ms after the heartbeat, {len(driving)} steering frames in between")
    assert len(driving) <= ONE_STEP, driving
    assert_silence(drive)


def interrupt(drive):
    """Ctrl-C under way: motors neutral, then released, then nothing: the bridge ends."""
    drive.until(lambda: drive.item >= 2, "being under way to item 2")
    print("interrupt")
    drive.until(lambda: is_release(drive.steering[-1]), "the release")
    *before, last = [message for message in drive.steering if not is_release(message)]
    assert is_neutral(last), f"let go while driving: {last}"
    assert not all(is_neutral(message) for message in before[-200:]), "the boat was not driving"


def assert_silence(drive):
    """Nothing but releases comes after a release."""
    sent = len(drive.steering)
    drive.heartbeats_later()
    late = [message for message in drive.steering[sent:] if not is_release(message)]
    assert not late, f"steered after letting go: {late}"


def main():
    what, kind, station, boat_address, plan = sys.argv[1:]
    {"finish": finish, "takeover": takeover, "interrupt": interrupt}[what](Drive(kind, station, boat_address, plan))
    print("as it should be")


main()
