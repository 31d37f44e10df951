//! The real bridge as a child process, and what the system says of it.

use std::error::Error;
use std::fs;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::Duration;

/// The system counts processor time in units of 10 ms (USER_HZ, the same on every Linux).
const CPU_UNIT: Duration = Duration::from_millis(10);

/// A running program of ours.
pub(crate) struct Bridge {
    child: Child,
}

impl Bridge {
    /// A bridge that steers the boat at this UDP port.
    pub(crate) fn start(port: u16, mission: &Path) -> Result<Self, Box<dyn Error>> {
        let (url, mission) = (format!("udpout:127.0.0.1:{port}"), mission.display().to_string());
        Self::run(&[
            "bridge",
            "--connect",
            &url,
            "--mission",
            &mission,
            "--output",
            "guided",
            "--rate",
            "50",
            "--engage",
            "-q",
        ])
    }

    /// `helmlink` with these arguments.
    pub(crate) fn run(arguments: &[&str]) -> Result<Self, Box<dyn Error>> {
        let mut command = Command::new(env!("CARGO_BIN_EXE_helmlink"));
        Ok(Self { child: command.args(arguments).stdin(Stdio::null()).stdout(Stdio::null()).spawn()? })
    }

    /// Processor time used so far, and resident memory now in KiB.
    pub(crate) fn usage(&self) -> Result<(Duration, u32), Box<dyn Error>> {
        let folder = format!("/proc/{}", self.child.id());
        let stat = fs::read_to_string(format!("{folder}/stat"))?;
        // Behind the name, which is in brackets: state, 10 other fields, user and system time.
        let behind_name = stat.rsplit_once(')').ok_or("no name in /proc/PID/stat")?.1;
        let fields: Vec<&str> = behind_name.split_whitespace().collect();
        let units = fields[11].parse::<u32>()? + fields[12].parse::<u32>()?;
        let status = fs::read_to_string(format!("{folder}/status"))?;
        let resident = status.lines().find_map(|line| line.strip_prefix("VmRSS:")).ok_or("no VmRSS")?;
        let kib = resident.split_whitespace().next().ok_or("no number behind VmRSS")?.parse()?;
        Ok((CPU_UNIT * units, kib))
    }
}

impl Drop for Bridge {
    fn drop(&mut self) {
        self.child.kill().ok();
        self.child.wait().ok();
    }
}
