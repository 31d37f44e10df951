"""A signing ground station and two impostors at the bridge: pymavlink_signing.py udpout:HOST:PORT PASSPHRASE.

The bridge answers a command only to the one with the key, and signs what it answers.
"""

import hashlib
import sys
import time

from pymavlink import mavutil

import boat

mavlink = mavutil.mavlink
PAUSE = mavlink.MAV_CMD_DO_PAUSE_CONTINUE
# How long a silence has to last to be one, seconds.
SILENCE = 3.0


def station(address, component, passphrase):
    """A ground station that signs and refuses unsigned frames, or one that knows nothing of signing."""
    connection = mavutil.mavlink_connection(address, source_system=255, source_component=component)
    if passphrase:
        key = hashlib.sha256(passphrase.encode()).digest()
        connection.setup_signing(key, sign_outgoing=True, allow_unsigned_callback=None)
    return connection


def ask(connection):
    boat.say_hello(connection)
    connection.mav.command_long_send(1, 191, PAUSE, 0, 0, 0, 0, 0, 0, 0, 0)


def answer(connection, patience):
    """The acknowledgement of a command, or None."""
    deadline = time.monotonic() + patience
    while time.monotonic() < deadline:
        ask(connection)
        until = time.monotonic() + boat.ANSWER
        while (left := until - time.monotonic()) > 0:
            ack = connection.recv_match(type="COMMAND_ACK", blocking=True, timeout=left)
            if ack is not None and ack.command == PAUSE:
                return ack
    return None


def main(address, passphrase):
    friend = station(address, 190, passphrase)
    ack = answer(friend, boat.PATIENCE)
    assert ack is not None, "the bridge does not answer a signed command"
    assert ack.get_signed(), "the bridge's answer is not signed"
    assert answer(station(address, 191, "not the passphrase"), SILENCE) is None, "a wrong key was obeyed"
    assert answer(station(address, 192, None), SILENCE) is None, "an unsigned command was obeyed"
    print("signed both ways; a wrong key and no key are refused")


main(*sys.argv[1:])
