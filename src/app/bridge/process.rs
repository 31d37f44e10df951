//! What the system says that this process costs.

use std::fs;

/// The system counts processor time in units of 10 ms (USER_HZ, the same on every Linux).
const CPU_UNITS_PER_S: f64 = 100.0;

/// What the process has used.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Usage {
    /// Processor time so far, user and system together, seconds.
    pub(super) cpu_s: f64,
    /// Memory that is resident now, bytes.
    pub(super) resident_bytes: f64,
}

impl Usage {
    /// As it is now; none where the system does not tell, as outside Linux.
    pub(super) fn now() -> Option<Self> {
        let read = |file: &str| fs::read_to_string(format!("/proc/self/{file}")).ok();
        Self::parse(&read("stat")?, &read("status")?)
    }

    fn parse(stat: &str, status: &str) -> Option<Self> {
        // Behind the name, which is in brackets: state, ten other fields, user and system time.
        let mut times = stat.rsplit_once(')')?.1.split_whitespace().skip(11);
        let mut units = || times.next()?.parse::<f64>().ok();
        let cpu_s = (units()? + units()?) / CPU_UNITS_PER_S;
        let resident = status.lines().find_map(|line| line.strip_prefix("VmRSS:"))?;
        let kibibytes: f64 = resident.split_whitespace().next()?.parse().ok()?;
        Some(Self { cpu_s, resident_bytes: kibibytes * 1024.0 })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_with_brackets_and_spaces_misleads_nobody() {
        let stat = "42 (a (b) c) S 1 2 3 4 5 6 7 8 9 10 150 50 0 0 20 0 2";
        let usage = Usage::parse(stat, "Name:\ta\nVmRSS:\t    2048 kB\n").unwrap();
        assert_eq!(usage, Usage { cpu_s: 2.0, resident_bytes: 2_097_152.0 });
        assert_eq!(Usage::parse("42 (a", "VmRSS: 1 kB"), None);
    }
}
