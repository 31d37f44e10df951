"""MAVProxy, by its command line: parameters, a mission loaded and listed, armed, paused, run to the end, RTL.

    mavproxy_mission.py MASTER PLAN [watch]

With `watch` it only looks on while another ground station drives.
"""

import os
import re
import subprocess
import sys
import tempfile
import threading
import time

from quiet import Stopwatch

PATIENCE = 90.0
"""Seconds of real time after which a wait is hopeless."""
ANSWER = 1.0
"""Seconds of real time after which a question is asked again."""
PARAMETERS_WITHIN = 3.0
"""Seconds of real time within which a quiet machine has all parameters. MAVProxy itself waits for one of them."""
# `terrain` and `adsb` draw in packages for maps that nothing here needs.
MODULES = "log,signing,wp,rally,fence,ftp,param,relay,arm,mode,rc,misc,cmdlong,battery,output"


class MavProxy:
    """A running MAVProxy whose terminal is read and typed into."""

    def __init__(self, master, folder):
        program = os.path.join(os.path.dirname(sys.executable), "mavproxy.py")
        self.process = subprocess.Popen(
            [sys.executable, "-u", program, "--master", master, "--state-basedir", folder,
             "--default-modules", MODULES, "--streamrate", "2"],
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, cwd=folder)
        self.text, self.read_up_to = "", 0
        self.more = threading.Condition()
        threading.Thread(target=self.read, daemon=True).start()

    def read(self):
        """Collects what it prints; a prompt has no end of line."""
        while piece := self.process.stdout.read(1):
            with self.more:
                self.text += piece
                self.more.notify()

    def type(self, command):
        """Types one line."""
        self.process.stdin.write(command + "\n")
        self.process.stdin.flush()

    def insist(self, command, pattern):
        """Types a command until it shows what it should: MAVProxy changes parameters in its own time."""
        deadline = time.monotonic() + PATIENCE
        while True:
            self.type(command)
            try:
                return self.expect(pattern, ANSWER)
            except AssertionError:
                if time.monotonic() > deadline:
                    raise

    def expect(self, pattern, within=PATIENCE):
        """Waits until it has printed this, after what was expected before; returns the match."""
        deadline = time.monotonic() + within
        with self.more:
            while not (found := re.compile(pattern).search(self.text, self.read_up_to)):
                left = deadline - time.monotonic()
                assert left > 0, f"MAVProxy did not print `{pattern}`; it printed:\n{self.text}"
                self.more.wait(left)
            self.read_up_to = found.end()
            return found


def parameters(station):
    """All of them, one of them shown."""
    station.expect("online system 1")
    connected = Stopwatch()
    count = int(station.expect(r"Received (\d+) parameters").group(1))
    took = connected.within(PARAMETERS_WITHIN, "fetching all parameters")
    print(f"{count} parameters {took:.2f} s after connecting")
    station.type("param show SYSID_MYGCS")
    station.expect(r"SYSID_MYGCS\s+255")


def drive(station, plan):
    """What a user types to run a mission, and what he sees."""
    station.type("param set WP_RADIUS 1.5")
    station.insist("param fetch WP_RADIUS", r"WP_RADIUS = 1\.5")
    station.type(f"wp load {plan}")
    loaded = int(station.expect(r"Loaded (\d+) waypoints").group(1))
    station.expect("MISSION_ACK: TYPE_MISSION: ACCEPTED")
    station.type("wp list")
    station.expect(f"Saved {loaded} waypoints")

    station.type("arm throttle")
    station.expect("ARMED")
    station.type("mode AUTO")
    station.expect("Mode AUTO")
    station.expect("Reached waypoint #1")
    station.type("mode HOLD")
    station.expect("Mode HOLD")
    station.type("mode AUTO")
    station.expect("Mode AUTO")
    for item in range(2, loaded):
        station.expect(f"Reached waypoint #{item}")
    station.expect("Mission Complete")
    station.type("mode RTL")
    station.expect("Mode RTL")
    station.expect("Reached destination")
    station.type("disarm")
    station.expect("DISARMED")
    print("every waypoint reached, back home")


def watch(station):
    """What a user sees while another ground station drives."""
    station.expect("Mission Complete")
    station.type("wp list")
    print(f"saw the mission end, {station.expect('Saved ([0-9]+) waypoints').group(1)} items on board")


def main():
    master, plan, *role = sys.argv[1:]
    with tempfile.TemporaryDirectory() as folder:
        station = MavProxy(master, folder)
        try:
            parameters(station)
            if role == ["watch"]:
                watch(station)
            else:
                drive(station, plan)
        finally:
            station.process.kill()
            station.process.wait()


main()
