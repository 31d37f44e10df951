#!/usr/bin/env python3
"""Make messages.xml and ../src/enums.rs from the published MAVLink definitions.

    python3 flatten.py DIR

DIR holds ardupilotmega.xml and the files it includes (the `message_definitions/v1.0` folder that the
`mavlink` crate and pymavlink ship). Every message of the dialect is kept, with its wire types, but without
the `enum` attributes: a number that a newer vehicle sends and this version has no name for then stays a
number instead of losing the whole message. CRC_EXTRA does not depend on those attributes. The names that
Helmlink uses become plain integer constants, of the type that the messages carry.
"""

import pathlib
import sys
import xml.etree.ElementTree as ET

KEEP = [
    "MAV_TYPE", "MAV_AUTOPILOT", "MAV_STATE", "MAV_MODE_FLAG", "MAV_COMPONENT", "MAV_CMD", "MAV_FRAME",
    "MAV_RESULT", "MAV_MISSION_RESULT", "MAV_MISSION_TYPE", "MISSION_STATE", "MAV_SEVERITY",
    "MAV_PARAM_TYPE", "MAV_PARAM_ERROR", "MAV_PROTOCOL_CAPABILITY", "MAV_SYS_STATUS_SENSOR",
    "MAV_LANDED_STATE", "MAV_VTOL_STATE", "GPS_FIX_TYPE", "EKF_STATUS_FLAGS", "ESTIMATOR_STATUS_FLAGS",
    "POSITION_TARGET_TYPEMASK", "ATTITUDE_TARGET_TYPEMASK", "ROVER_MODE", "MAV_BATTERY_TYPE",
    "MAV_BATTERY_FUNCTION", "MAV_BATTERY_CHARGE_STATE", "FENCE_BREACH", "FENCE_ACTION", "SPEED_TYPE",
    "MAV_DATA_STREAM", "FIRMWARE_VERSION_TYPE", "MAV_DO_REPOSITION_FLAGS",
    "MAV_FTP_OPCODE", "MAV_FTP_ERR", "COMP_METADATA_TYPE",
]
# Where no message field carries the enum, or the first that does is not the one that matters.
WIDTH = {"MAV_CMD": "u16", "MAV_MODE_FLAG": "u8", "MAV_COMPONENT": "u8", "ROVER_MODE": "u32", "SPEED_TYPE": "u8",
         "MAV_DO_REPOSITION_FLAGS": "u32", "MAV_SYS_STATUS_SENSOR": "u32", "MAV_PROTOCOL_CAPABILITY": "u64",
         "MAV_DATA_STREAM": "u8", "FIRMWARE_VERSION_TYPE": "u8", "MAV_FTP_OPCODE": "u8", "MAV_FTP_ERR": "u8",
         "FENCE_ACTION": "u8", "EKF_STATUS_FLAGS": "u16", "ESTIMATOR_STATUS_FLAGS": "u16",
         "COMP_METADATA_TYPE": "u32"}
RUST = {"uint8_t": "u8", "uint16_t": "u16", "uint32_t": "u32", "uint64_t": "u64",
        "int8_t": "i8", "int16_t": "i16", "int32_t": "i32"}


def number(text):
    """An enum value as written: decimal, 0x…, or 2**n."""
    base, _, exponent = text.partition("**")
    return int(base, 0) ** int(exponent, 0) if exponent else int(base, 0)


def load(folder, name, seen, messages, enums):
    if name in seen:
        return
    seen.add(name)
    root = ET.parse(folder / name).getroot()
    for include in root.findall("include"):
        load(folder, include.text, seen, messages, enums)
    for enum in root.iter("enum"):
        entries = enums.setdefault(enum.get("name"), {})
        for entry in enum.findall("entry"):
            if entry.get("value") is not None:
                entries[entry.get("name")] = number(entry.get("value"))
    for message in root.iter("message"):
        messages[int(message.get("id"))] = message


def main():
    folder = pathlib.Path(sys.argv[1])
    here = pathlib.Path(__file__).parent
    messages, enums = {}, {}
    load(folder, "ardupilotmega.xml", set(), messages, enums)

    root = ET.Element("mavlink")
    listing = ET.SubElement(root, "messages")
    width = {}
    for number in sorted(messages):
        message = messages[number]
        out = ET.SubElement(listing, "message", id=str(number), name=message.get("name"))
        for child in message:
            if child.tag == "extensions":
                ET.SubElement(out, "extensions")
            elif child.tag == "field":
                ET.SubElement(out, "field", type=child.get("type"), name=child.get("name"))
                if child.get("enum"):
                    width.setdefault(child.get("enum"), RUST.get(child.get("type")))
    ET.indent(root, space=" ")
    ET.ElementTree(root).write(here / "messages.xml")

    lines = [
        "//! The MAVLink names that Helmlink uses, as integers of the width the messages carry.",
        "//!",
        "//! Made by `dialect/flatten.py`; see <https://mavlink.io/en/messages/ardupilotmega.html> for their meaning.",
        "#![allow(missing_docs)]",
        "",
    ]
    for name in KEEP:
        if name not in enums:
            continue
        kind = WIDTH.get(name) or width.get(name) or "u32"
        lines.append(f"// {name}")
        for entry, value in sorted(enums[name].items(), key=lambda pair: (pair[1], pair[0])):
            if not entry.endswith("_ENUM_END"):
                lines.append(f"pub const {entry}: {kind} = {value};")
        lines.append("")
    (here.parent / "src" / "enums.rs").write_text("\n".join(lines))


main()
