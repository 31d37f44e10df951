//! The `helmlink` command.

fn main() {}
