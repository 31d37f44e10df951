"""Ground stations read what the bridge's parameters are: metadata.py HOST:PORT CACHE.

pymavlink and MAVSDK (native) fetch the files over UDP and check them; pymavlink also fetches a file of the flight
controller through the bridge.
"""

import asyncio
import json
import math
import os
import re
import struct
import sys
import tempfile
import zlib

import boat
from pymavlink import mavftp

mavlink = boat.mavlink
BRIDGE = 191
# The pinned pymavlink has no name for these.
COMPONENT_METADATA = 397
PARAMETER = 1

# The fields of MAVLink's parameter.schema.json (version 3) and their types.
TEXT, NUMBER, COUNT, LIST = str, (int, float), int, list
FIELDS = {
    "name": TEXT, "type": TEXT, "shortDesc": TEXT, "longDesc": TEXT, "units": TEXT, "default": NUMBER,
    "decimalPlaces": COUNT, "min": NUMBER, "max": NUMBER, "increment": NUMBER, "rebootRequired": bool, "group": TEXT,
    "category": TEXT, "volatile": bool, "values": LIST, "bitmask": LIST, "readOnly": bool,
}
NAME = re.compile(r"[.\-a-zA-Z0-9_{}]{1,16}")


def crc32(data):
    """MAVLink's: that of zlib, begun with 0 and not inverted."""
    return zlib.crc32(data, 0xFFFFFFFF) ^ 0xFFFFFFFF


def check_general(general):
    """The file has the form of general.schema.json; returns what it says of the parameters' file."""
    assert set(general) <= {
        "version", "vendorName", "modelName", "firmwareVersion", "hardwareVersion", "metadataTypes"}, general
    assert isinstance(general["version"], int) and general["version"] >= 1
    assert re.fullmatch(r"\d+\.\d+\.\d+(\.\d+)?", general["firmwareVersion"])
    (listed,) = general["metadataTypes"]
    assert set(listed) == {"type", "uri", "fileCrc"} and listed["type"] == PARAMETER
    return listed


def check_parameters(described):
    """The file has the form of parameter.schema.json, and each range holds its default."""
    assert set(described) == {"version", "parameters"} and described["version"] >= 3
    for entry in described["parameters"]:
        assert NAME.fullmatch(entry["name"]) and entry["type"] == "Float", entry
        for field, value in entry.items():
            assert isinstance(value, FIELDS[field]), (entry["name"], field, value)
        for choice in entry.get("values", []):
            assert set(choice) == {"value", "description"} and isinstance(choice["value"], NUMBER), entry
        assert math.isfinite(entry["min"]) and entry["min"] <= entry["default"] <= entry["max"], entry
        assert entry["shortDesc"] and entry["longDesc"], entry
    return {entry["name"]: entry for entry in described["parameters"]}


def download(connection, component, path):
    """A file of a component's, by MAVLink's file transfer protocol."""
    with tempfile.TemporaryDirectory() as folder:
        name = os.path.join(folder, "file")
        client = mavftp.MAVFTP(connection, 1, component)
        client.cmd_get([path, name])
        result = client.process_ftp_reply("OpenFileRO", timeout=boat.PATIENCE)
        assert result.error_code == mavftp.FtpError.Success, f"{path}: {result.error_code}"
        with open(name, "rb") as file:
            return file.read()


def unpack(message):
    """Checksum and place of the file that COMPONENT_METADATA names."""
    frame = bytes(message.get_msgbuf())
    assert frame[6] == BRIDGE, f"component {frame[6]}"
    # Zeros at the end are not sent.
    payload = frame[10:-2].ljust(108, b"\0")
    _, checksum, uri = struct.unpack("<II100s", payload)
    return checksum, uri.rstrip(b"\0").decode()


def path_of(uri):
    """The path of a file on the bridge."""
    place = f"mftp://[;comp={BRIDGE}]"
    assert uri.startswith(place), uri
    return uri[len(place):]


def read_with_pymavlink(address):
    """Both files, checked against their checksums; the parameters by name."""
    connection = boat.connect(address)

    def request():
        connection.mav.command_long_send(
            1, BRIDGE, mavlink.MAV_CMD_REQUEST_MESSAGE, 0, COMPONENT_METADATA, 0, 0, 0, 0, 0, 0)

    kind = f"UNKNOWN_{COMPONENT_METADATA}"
    checksum, uri = unpack(boat.ask(connection, request, kind, what="COMPONENT_METADATA"))
    general = download(connection, BRIDGE, path_of(uri))
    assert crc32(general) == checksum, "general.json is not the one that was announced"
    listed = check_general(json.loads(general))
    parameters = download(connection, BRIDGE, path_of(listed["uri"]))
    assert crc32(parameters) == listed["fileCrc"], "parameter.json is not the one that was announced"
    packed = download(connection, 1, "@PARAM/param.pck")
    assert packed[:2] == b"\x1b\x67", "the flight controller's parameters, through the bridge"
    return check_parameters(json.loads(parameters))


async def read_with_mavsdk(address):
    """The parameters' file, as MAVSDK finds it by itself."""
    from mavsdk.asyncio import ComponentType, Configuration, Mavsdk
    from mavsdk.asyncio.plugins.component_metadata import ComponentMetadataAsync
    from mavsdk.plugins.component_metadata import MetadataType

    mavsdk = Mavsdk(Configuration.create_with_component_type(ComponentType.GROUND_STATION))
    await mavsdk.add_any_connection(address)
    metadata = ComponentMetadataAsync(await mavsdk.first_autopilot(boat.PATIENCE))
    updates = metadata.subscribe_metadata_available()

    async def wait():
        async for update in updates:
            if update.type == MetadataType.PARAMETER:
                return update

    waiting = asyncio.ensure_future(asyncio.wait_for(wait(), boat.PATIENCE))
    await asyncio.sleep(0)
    await metadata.request_component(BRIDGE)
    update = await waiting
    assert update.compid == BRIDGE, update.compid
    return check_parameters(json.loads(update.json_metadata))


def main(address, cache):
    # Where MAVSDK keeps what it has read before.
    os.environ["XDG_CACHE_HOME"] = os.environ["HOME"] = cache
    described = read_with_pymavlink(f"udpout:{address}")
    assert described["HL_FS_BATT"]["max"] == 100 and described["HL_R_K"]["units"] == "1/s"
    assert asyncio.run(read_with_mavsdk(f"udpout://{address}")) == described
    print(f"{len(described)} parameters described, to pymavlink and to MAVSDK")


main(*sys.argv[1:])
