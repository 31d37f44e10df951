//! How fast one core indexes and decodes a log that is larger than memory should be used for:
//! `cargo bench -p helmlink-wire --bench big_log`. HELMLINK_BENCH_LOG_MB sets its size, 2048 if not given.

use std::fs::File;
use std::hint::black_box;
use std::io::{BufWriter, Write};
use std::path::PathBuf;
use std::time::Instant;

use helmlink_wire::tlog::{Index, TlogReader, TlogWriter, records};

/// A recorded run of ArduRover.
const LOG: &[u8] = include_bytes!("../../tests/data/ardurover-4.6-motorboat.tlog");

/// A file that is gone when the benchmark ends.
struct Scratch(PathBuf);

impl Drop for Scratch {
    fn drop(&mut self) {
        std::fs::remove_file(&self.0).ok();
    }
}

fn main() -> std::io::Result<()> {
    // `cargo test --benches` only wants to see that it runs.
    let is_test = !std::env::args().any(|argument| argument == "--bench");
    let default_mb = if is_test { 4 } else { 2048 };
    let megabytes = std::env::var("HELMLINK_BENCH_LOG_MB").ok().and_then(|text| text.parse().ok());
    // Not the system's folder for temporary files, which may be memory.
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR"));
    std::fs::create_dir_all(&folder)?;
    let scratch = Scratch(folder.join(format!("bench-{}.tlog", std::process::id())));
    let length = make(&scratch, megabytes.unwrap_or(default_mb) * 1_000_000)?;
    let memory_before = peak_memory_mb();

    let (index, rate) = timed(length, || Index::build(File::open(&scratch.0)?))?;
    let mut out = std::io::stdout();
    writeln!(out, "index:  {rate} ({} records, {} marks)", index.records, index.marks().len())?;

    let (decoded, rate) = timed(length, || {
        let mut reader = TlogReader::new(File::open(&scratch.0)?);
        let mut decoded = 0_u64;
        while let Some(record) = reader.next_record()? {
            decoded += u64::from(black_box(record.frame.decode()).is_ok());
        }
        Ok(decoded)
    })?;
    writeln!(out, "decode: {rate} ({decoded} messages)")?;
    let memory = memory_before.zip(peak_memory_mb());
    if let Some((before, after)) = memory {
        writeln!(
            out,
            "memory: {after:.1} MB at the most ({before:.1} MB before) for {:.0} MB of log",
            length / 1e6
        )?;
    }
    assert_eq!(decoded, index.records, "every record of this log decodes");
    Ok(())
}

/// Writes the recorded run over and over, each time stamped later.
fn make(scratch: &Scratch, length: u64) -> std::io::Result<f64> {
    let mut writer = TlogWriter::new(BufWriter::with_capacity(1 << 20, File::create(&scratch.0)?));
    let rounds = length.div_ceil(LOG.len() as u64);
    for round in 0..rounds {
        for record in records(LOG) {
            writer.write(record.time_us + round * 20_000_000, &record.frame)?;
        }
    }
    writer.flush()?;
    Ok((rounds * LOG.len() as u64) as f64)
}

/// Runs `job` and says how fast it went through `length` bytes.
fn timed<T>(length: f64, job: impl FnOnce() -> std::io::Result<T>) -> std::io::Result<(T, String)> {
    let (started, cpu) = (Instant::now(), cpu_s());
    let result = job()?;
    let wall_s = started.elapsed().as_secs_f64();
    let of_core = cpu.zip(cpu_s()).map_or(String::new(), |(before, after)| {
        format!(", {:.0} MB per second of processor time", length / 1e6 / (after - before))
    });
    Ok((result, format!("{:.0} MB/s by the clock{of_core}", length / 1e6 / wall_s)))
}

/// Processor time that this process has used, seconds; only where /proc tells.
fn cpu_s() -> Option<f64> {
    let text = std::fs::read_to_string("/proc/self/stat").ok()?;
    let fields: Vec<&str> = text.rsplit_once(')')?.1.split_whitespace().collect();
    let ticks = fields.get(11)?.parse::<f64>().ok()? + fields.get(12)?.parse::<f64>().ok()?;
    Some(ticks / 100.0)
}

/// The most memory that this process has held, megabytes; only where /proc tells.
fn peak_memory_mb() -> Option<f64> {
    let text = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = text.lines().find(|line| line.starts_with("VmHWM:"))?;
    line.split_whitespace().nth(1)?.parse::<f64>().ok().map(|kilobytes| kilobytes / 1000.0)
}
