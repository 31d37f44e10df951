//! How fast `helmlink replay` puts a large log through the controller, and how much memory it takes:
//! `cargo bench --bench replay`. HELMLINK_BENCH_LOG_MB sets the log's size, 300 if not given.

#![allow(clippy::print_stdout)] // what a benchmark is for

use std::error::Error;
use std::fs::File;
use std::io::BufWriter;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use helmlink_wire::dialect::SYSTEM_TIME_DATA;
use helmlink_wire::tlog::{TlogWriter, records};
use helmlink_wire::{Message, encoder};

/// A recorded run of ArduRover, 170 s of its time.
const LOG: &[u8] = include_bytes!("../tests/data/ardurover-4.6-motorboat.tlog");
/// Between two runs in the log, by the boat's clock, milliseconds.
const PERIOD_MS: u32 = 180_000;
/// How often memory is looked at.
const GLANCE: Duration = Duration::from_millis(20);

/// A file that is gone when the benchmark ends.
struct Scratch(PathBuf);

impl Drop for Scratch {
    fn drop(&mut self) {
        std::fs::remove_file(&self.0).ok();
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    // `cargo test --benches` only wants to see that it runs.
    let is_test = !std::env::args().any(|argument| argument == "--bench");
    let default_mb = if is_test { 4 } else { 300 };
    let asked_mb = std::env::var("HELMLINK_BENCH_LOG_MB").ok().and_then(|text| text.parse().ok());
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR"));
    std::fs::create_dir_all(folder)?;
    let scratch = Scratch(folder.join(format!("bench-replay-{}.tlog", std::process::id())));
    let bytes = write_log(&scratch.0, asked_mb.unwrap_or(default_mb) * 1_000_000)?;
    println!("log: {:.0} MB", bytes as f64 / 1e6);
    for (name, options) in [("what-if", &["--no-report"][..]), ("what-if with report", &[])] {
        let (report, wall_s, cpu_s, peak_mb) = replay(&scratch.0, options)?;
        let number = |key: &str| report[key].as_f64().unwrap_or_default();
        let vehicle_s = number("vehicle_s");
        println!(
            "{name}: {vehicle_s:.0} s of the boat's time, {:.0} of them driven; with the scan before it {:.0} × real time and {:.0} MB \
             a second of processor time, {:.0} × by the clock; {peak_mb:.0} MB of memory at the most",
            number("driven_s"),
            vehicle_s / cpu_s,
            bytes as f64 / 1e6 / cpu_s,
            vehicle_s / wall_s,
        );
    }
    Ok(())
}

/// The recorded run over and over, as one boat that drives for days: stamps and the boat's clock go on.
fn write_log(path: &Path, bytes: u64) -> Result<u64, Box<dyn Error>> {
    let mut writer = TlogWriter::new(BufWriter::with_capacity(1 << 20, File::create(path)?));
    let rounds = bytes.div_ceil(LOG.len() as u64);
    for round in 0..rounds as u32 {
        let later_ms = round * PERIOD_MS;
        for record in records(LOG) {
            let mut message = record.frame.decode()?;
            put_later(&mut message, later_ms);
            let (identity, sequence) = (record.frame.identity(), record.frame.sequence());
            let bytes = encoder::encode_numbered(record.frame.version(), identity, sequence, &message);
            let frame = helmlink_wire::Frame::parse(&bytes)?;
            // At the boat's own pace: the run was recorded at ten times real time.
            let first_us = 1_795_422_900_000_000;
            let time_us =
                first_us + 10 * record.time_us.saturating_sub(first_us) + u64::from(later_ms) * 1000;
            writer.write(time_us, &frame)?;
        }
    }
    writer.flush()?;
    Ok(std::fs::metadata(path)?.len())
}

/// Shifts the boat's own clock, in the messages that a replay goes by.
fn put_later(message: &mut Message, later_ms: u32) {
    match message {
        Message::ATTITUDE(data) => data.time_boot_ms += later_ms,
        Message::GLOBAL_POSITION_INT(data) => data.time_boot_ms += later_ms,
        Message::SYSTEM_TIME(data) => {
            *data = SYSTEM_TIME_DATA { time_boot_ms: data.time_boot_ms + later_ms, ..data.clone() };
        }
        _ => {}
    }
}

/// Runs `helmlink replay`; its figures, how long it took by the clock and of processor time, seconds, and the most
/// memory it held, MB.
fn replay(log: &Path, options: &[&str]) -> Result<(serde_json::Value, f64, f64, f64), Box<dyn Error>> {
    let report = log.with_extension("report");
    let mut command = Command::new(env!("CARGO_BIN_EXE_helmlink"));
    command.arg("replay").arg(log).args(["--json", "--quiet"]).args(options);
    if options.is_empty() {
        command.arg("--report").arg(&report);
    }
    let out = log.with_extension("json");
    let started = Instant::now();
    let mut child = command.stdin(Stdio::null()).stdout(File::create(&out)?).spawn()?;
    let (mut peak_mb, mut cpu_s) = (0.0_f64, f64::NAN);
    while child.try_wait()?.is_none() {
        peak_mb = peak_mb.max(peak_memory_mb(&child).unwrap_or_default());
        cpu_s = cpu_time_s(&child).unwrap_or(cpu_s);
        std::thread::sleep(GLANCE);
    }
    let wall_s = started.elapsed().as_secs_f64();
    let text = std::fs::read_to_string(&out)?;
    std::fs::remove_file(&out)?;
    std::fs::remove_dir_all(&report).ok();
    Ok((serde_json::from_str(&text)?, wall_s, cpu_s, peak_mb))
}

/// Processor time that a process has used so far, seconds; only where /proc tells.
fn cpu_time_s(child: &Child) -> Option<f64> {
    let text = std::fs::read_to_string(format!("/proc/{}/stat", child.id())).ok()?;
    let fields: Vec<&str> = text.rsplit_once(')')?.1.split_whitespace().collect();
    let ticks = fields.get(11)?.parse::<f64>().ok()? + fields.get(12)?.parse::<f64>().ok()?;
    (ticks > 0.0).then_some(ticks / 100.0)
}

/// The most memory that a process has held so far; only where /proc tells.
fn peak_memory_mb(child: &Child) -> Option<f64> {
    let text = std::fs::read_to_string(format!("/proc/{}/status", child.id())).ok()?;
    let line = text.lines().find(|line| line.starts_with("VmHWM:"))?;
    line.split_whitespace().nth(1)?.parse::<f64>().ok().map(|kilobytes| kilobytes / 1000.0)
}
