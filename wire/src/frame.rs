//! One MAVLink frame whose checksum has been verified.
