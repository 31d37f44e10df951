"""A telemetry log as other programs read it: pymavlink's reader, its mavlogdump, or MAVProxy.

    read_log.py pymavlink LOG      prints one JSON object: what is in the log
    read_log.py mavlogdump LOG     prints how many messages of each type it dumps, as JSON
    read_log.py mavproxy ADDRESS TEXT...   MAVProxy, while the log is played to it, prints all these texts
"""

import collections
import json
import os
import subprocess
import sys
import tempfile
import threading

from pymavlink import mavutil

PATIENCE = 90.0
"""Seconds after which a program is stuck."""


def program(name):
    """A program that was installed with pymavlink or MAVProxy."""
    return [sys.executable, os.path.join(os.path.dirname(sys.executable), name)]


def pymavlink(path):
    """What mavutil's log reader makes of it."""
    log = mavutil.mavlink_connection(path)
    assert isinstance(log, mavutil.mavlogfile), type(log)
    types, names = collections.Counter(), set()
    texts, steering, states = [], 0, 0
    first = last = None
    while (message := log.recv_match()) is not None:
        kind = message.get_type()
        types[kind] += 1
        first = message._timestamp if first is None else first
        last = message._timestamp
        sender = (message.get_srcSystem(), message.get_srcComponent())
        if kind == "NAMED_VALUE_FLOAT":
            names.add(message.name)
        elif kind == "STATUSTEXT":
            texts.append(message.text)
        elif kind in ("RC_CHANNELS_OVERRIDE", "MANUAL_CONTROL", "SET_ATTITUDE_TARGET", "SET_POSITION_TARGET_LOCAL_NED"):
            steering += sender[1] == 191
        elif kind == "DEBUG_FLOAT_ARRAY":
            assert message.name == "HELMLINK" and sender[1] == 192, message
            states += 1
    return {"types": types, "first_s": first, "last_s": last, "names": sorted(names), "texts": texts,
            "steering": steering, "states": states}


def mavlogdump(path):
    """What mavlogdump prints, a JSON object a line."""
    dump = subprocess.run([*program("mavlogdump.py"), "--format", "json", path],
                          capture_output=True, text=True, timeout=PATIENCE, check=True)
    types = collections.Counter()
    for line in dump.stdout.splitlines():
        if line.startswith("{"):
            types[json.loads(line)["meta"]["type"]] += 1
    return {"types": types}


def mavproxy(address, *awaited):
    """MAVProxy prints the boat's modes and texts, until all that is awaited has been printed."""
    with tempfile.TemporaryDirectory() as folder:
        proxy = subprocess.Popen(
            [*program("mavproxy.py"), "--master", address, "--state-basedir", folder, "--non-interactive",
             "--default-modules", "mode,arm"],
            stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, cwd=folder)
        threading.Timer(PATIENCE, proxy.kill).start()
        printed = ""
        while any(text not in printed for text in awaited):
            line = proxy.stdout.readline()
            assert line, f"MAVProxy ended without one of {awaited}:\n{printed}"
            printed += line
        proxy.kill()
        proxy.wait()
    return {"printed": printed}


if __name__ == "__main__":
    program_name, *rest = sys.argv[1:]
    print(json.dumps({"pymavlink": pymavlink, "mavlogdump": mavlogdump, "mavproxy": mavproxy}[program_name](*rest)))
    sys.stdout.flush()
    # The timer need not run out.
    os._exit(0)
