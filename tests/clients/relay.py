"""A relay between the bridge and the boat that looks at every frame, over UDP, TCP or a pseudo-terminal."""

import os
import pty
import select
import socket
import tty

from pymavlink.dialects.v20 import ardupilotmega as mavlink

PIECE = 4096
STEERING = ("RC_CHANNELS_OVERRIDE", "MANUAL_CONTROL", "SET_ATTITUDE_TARGET", "SET_POSITION_TARGET_LOCAL_NED")


class Relay:
    """Carries frames both ways when `carry` is called."""

    def __init__(self, kind, boat):
        """`boat` is the boat's HOST:PORT; the bridge connects to `url`."""
        host, port = boat.rsplit(":", 1)
        self.kind = kind
        self.peer = None
        self.hung_up = False
        if kind == "udp":
            self.boat = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
            self.near = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
            self.near.bind(("127.0.0.1", 0))
            self.url = f"udpout:127.0.0.1:{self.near.getsockname()[1]}"
        else:
            self.boat = socket.socket()
            if kind == "tcp":
                self.listener = socket.create_server(("127.0.0.1", 0))
                self.near = None
                self.url = f"tcp:127.0.0.1:{self.listener.getsockname()[1]}"
            else:
                # The other end stays open here, so that the line is there before the bridge is.
                self.near, self.far = pty.openpty()
                tty.setraw(self.far)
                self.url = f"serial:{os.ttyname(self.far)}:115200"
        self.boat.connect((host, int(port)))
        self.parsers = {side: mavlink.MAVLink(None) for side in ("bridge", "boat")}
        for parser in self.parsers.values():
            parser.robust_parsing = True

    def accept(self):
        """Waits for the bridge to connect, where connecting means something."""
        if self.kind == "tcp":
            self.near, _ = self.listener.accept()

    def carry(self, seconds):
        """Carries what comes within `seconds`; returns it as (side, message) in the order it went through."""
        ends = [self.boat] if self.hung_up else [self.near, self.boat]
        ready, _, _ = select.select(ends, [], [], seconds)
        passed = []
        if self.near in ready:
            passed += self.from_bridge()
        if self.boat in ready:
            for message in self.parsers["boat"].parse_buffer(self.boat.recv(PIECE)) or []:
                self.write_near(message.get_msgbuf())
                passed.append(("boat", message))
        return passed

    def from_bridge(self):
        """Carries what the bridge has said."""
        data = self.read_near()
        self.hung_up = not data
        if data:
            self.boat.sendall(data)
        return [("bridge", message) for message in self.parsers["bridge"].parse_buffer(data) or []]

    def read_near(self):
        """Bytes of the bridge; none when it has hung up."""
        try:
            if self.kind == "udp":
                data, self.peer = self.near.recvfrom(PIECE)
                return data
            return os.read(self.near, PIECE) if self.kind == "pty" else self.near.recv(PIECE)
        except ConnectionError:
            return b""

    def write_near(self, data):
        """Bytes to the bridge; lost, as on a real line, when it is gone."""
        try:
            if self.kind == "udp":
                if self.peer:
                    self.near.sendto(data, self.peer)
            elif self.kind == "pty":
                os.write(self.near, data)
            else:
                self.near.sendall(data)
        except OSError:
            pass


def is_steering(message):
    """The message steers the boat."""
    return message.get_type() in STEERING


def is_release(message):
    """An override that gives both channels back to the receiver."""
    return message.get_type() == "RC_CHANNELS_OVERRIDE" and message.chan1_raw == 0 and message.chan3_raw == 0


def is_neutral(message):
    """An override that stops the boat: throttle and steering at rest."""
    return message.get_type() == "RC_CHANNELS_OVERRIDE" and message.chan1_raw == 1500 and message.chan3_raw == 1500
