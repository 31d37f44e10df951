//! The real `helmlink`, as a user starts it.

use std::ops::Deref;
use std::process::Command;

use super::process::{Ended, Process};

/// A running `helmlink`.
pub struct Helmlink {
    process: Process,
}

impl Helmlink {
    /// Starts `helmlink` with these arguments.
    pub fn start(arguments: &[&str]) -> Self {
        let name = format!("helmlink {}", arguments.join(" "));
        Self { process: Process::start(&name, Command::new(env!("CARGO_BIN_EXE_helmlink")).args(arguments)) }
    }

    /// Runs `helmlink` to its end.
    pub fn run(arguments: &[&str]) -> Ended {
        Self::start(arguments).process.wait()
    }

    /// A simulated boat that listens on a free port by `scheme` (`tcpin` or `udpin`); returns its `HOST:PORT` too.
    pub fn sitl(scheme: &str, arguments: &[&str]) -> (Self, String) {
        let listen = format!("{scheme}:127.0.0.1:0");
        let boat = Self::start(&[&["sitl", "--json", "--listen", &listen], arguments].concat());
        let address = boat.wait_for_address();
        (boat, address)
    }

    /// The address that the next endpoint listens on, as `sitl --json` says it.
    pub fn wait_for_address(&self) -> String {
        let line = self.wait_for_line("\"address\"");
        let said: serde_json::Value = serde_json::from_str(&line).expect("one JSON object a line");
        said["address"].as_str().expect("an address").to_owned()
    }

    /// The `HOST:PORT` that the bridge's next listening link is bound to, as its log says it.
    pub fn wait_for_place(&self) -> String {
        let line = self.wait_for_line("listening at");
        line.rsplit_once('(').expect("an address").1.trim_end_matches(')').to_owned()
    }

    /// The process, to wait for its end.
    pub fn into_process(self) -> Process {
        self.process
    }

    /// Ends it at once.
    pub fn kill(&mut self) {
        self.process.kill();
    }
}

impl Deref for Helmlink {
    type Target = Process;

    fn deref(&self) -> &Process {
        &self.process
    }
}
