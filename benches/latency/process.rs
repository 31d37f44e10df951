//! The real bridge as a child process, and what the system says of it.

use std::error::Error;
use std::fs;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::Duration;

/// What a thread or a process has cost so far.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Cost {
    /// Processor time, user and system together.
    pub(crate) cpu: Duration,
    /// Times that it went to sleep to wait for something.
    pub(crate) waits: u64,
}

impl Cost {
    /// Of the calling thread.
    pub(crate) fn of_this_thread() -> Result<Self, Box<dyn Error>> {
        Self::read(Path::new("/proc/thread-self"))
    }

    /// Of the thread in this folder under `/proc`.
    fn read(folder: &Path) -> Result<Self, Box<dyn Error>> {
        // Nanoseconds on a processor, nanoseconds waiting for one, turns.
        let times = fs::read_to_string(folder.join("schedstat"))?;
        let nanos = times.split_whitespace().next().ok_or("nothing in schedstat")?.parse()?;
        let waits = number(&fs::read_to_string(folder.join("status"))?, "voluntary_ctxt_switches:")?;
        Ok(Self { cpu: Duration::from_nanos(nanos), waits })
    }

    /// What has come on top since `before`.
    pub(crate) fn since(self, before: Self) -> Self {
        Self { cpu: self.cpu - before.cpu, waits: self.waits - before.waits }
    }

    /// Both together.
    pub(crate) fn and(self, other: Self) -> Self {
        Self { cpu: self.cpu + other.cpu, waits: self.waits + other.waits }
    }
}

/// The number behind a key in a status file.
fn number(status: &str, key: &str) -> Result<u64, Box<dyn Error>> {
    let value = status.lines().find_map(|line| line.strip_prefix(key)).ok_or_else(|| format!("no {key}"))?;
    Ok(value.split_whitespace().next().ok_or_else(|| format!("no number behind {key}"))?.parse()?)
}

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

    /// What all its threads have cost so far.
    pub(crate) fn cost(&self) -> Result<Cost, Box<dyn Error>> {
        let mut all = Cost::default();
        for thread in fs::read_dir(format!("/proc/{}/task", self.child.id()))? {
            all = all.and(Cost::read(&thread?.path())?);
        }
        Ok(all)
    }

    /// Resident memory now, KiB.
    pub(crate) fn resident_kib(&self) -> Result<u64, Box<dyn Error>> {
        number(&fs::read_to_string(format!("/proc/{}/status", self.child.id()))?, "VmRSS:")
    }
}

impl Drop for Bridge {
    fn drop(&mut self) {
        self.child.kill().ok();
        self.child.wait().ok();
    }
}
