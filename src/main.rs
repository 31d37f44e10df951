//! The `helmlink` command.

use std::process::ExitCode;

fn main() -> ExitCode {
    helmlink::app::run()
}
