//! Writes a log to disk in a thread of its own: the control loop never waits for a disk.

use std::collections::VecDeque;
use std::fs::{self, File, OpenOptions};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, TrySendError, sync_channel};
use std::thread::JoinHandle;
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

use clap::Args;

use super::failure::Failure;
use super::ranges::Megabytes;
use super::report;

/// Where and how much is recorded.
#[derive(Debug, Clone, Args)]
pub struct RecordArgs {
    /// Write everything received, sent and thought to a telemetry log in this folder, and a report at the end
    #[arg(long, value_name = "DIR")]
    pub record: Option<PathBuf>,
    /// Begin a new file of the log when one would grow larger than this, MB
    #[arg(long, default_value = "256", value_name = "MB")]
    pub record_file_mb: Megabytes,
    /// Remove the oldest logs in the folder when all of them together grow larger than this, MB
    #[arg(long, default_value = "8192", value_name = "MB")]
    pub record_total_mb: Megabytes,
}

impl RecordArgs {
    fn limits(&self) -> RecordLimits {
        const MEGABYTE: u64 = 1_000_000;
        RecordLimits {
            file_bytes: u64::from(*self.record_file_mb).saturating_mul(MEGABYTE),
            total_bytes: u64::from(*self.record_total_mb).saturating_mul(MEGABYTE),
        }
    }

    /// Begins to record where the user wants that. `header` gives the records with which every file begins, once the
    /// time of the start is known, microseconds since 1970 UTC.
    ///
    /// # Errors
    /// The folder or the first file cannot be made.
    pub(super) fn start(&self, header: impl FnOnce(u64) -> Vec<u8>) -> Result<Option<Recorder>, Failure> {
        let Some(folder) = &self.record else { return Ok(None) };
        let start_us = unix_time_us();
        Recorder::start(folder, self.limits(), start_us, header(start_us)).map(Some)
    }
}

/// The wall clock, microseconds since 1970 UTC.
pub(super) fn unix_time_us() -> u64 {
    SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |since| since.as_micros() as u64)
}

/// Pieces of log that may wait for the disk; some milliseconds of telemetry each.
const QUEUE: usize = 1024;
/// Bytes that may wait on top of that, when the disk is slow.
const BACKLOG: usize = 16 * 1024 * 1024;
/// What has been written is on the disk itself, and survives a loss of power, after this long at the latest.
const SYNC: Duration = Duration::from_secs(2);
/// After a failed write another one is tried this much later: somebody may have made room.
const RETRY: Duration = Duration::from_secs(10);
/// How the files of a recording are called: this, the time of the start, and the number of the file.
const PREFIX: &str = "helmlink-";

/// How much may be written.
#[derive(Debug, Clone, Copy)]
struct RecordLimits {
    /// A new file is begun when one would grow larger than this, bytes.
    file_bytes: u64,
    /// The oldest recordings in the folder are removed when all of them together are larger, bytes.
    total_bytes: u64,
}

/// A recording being written.
pub(super) struct Recorder {
    sender: Option<SyncSender<Vec<u8>>>,
    thread: Option<JoinHandle<Vec<PathBuf>>>,
    backlog: VecDeque<Vec<u8>>,
    backlog_bytes: usize,
    lost_bytes: u64,
    failing: Arc<AtomicBool>,
    told_failing: bool,
}

impl Recorder {
    /// Begins a recording in `folder`; every file of it begins with `header`, which the first piece given to
    /// [`Self::write`] must hold too.
    ///
    /// # Errors
    /// The folder or the first file cannot be made.
    fn start(folder: &Path, limits: RecordLimits, start_us: u64, header: Vec<u8>) -> Result<Self, Failure> {
        let fault = |error: io::Error| {
            Failure::usage(format!("--record: cannot write into {}: {error}", folder.display()))
        };
        fs::create_dir_all(folder).map_err(fault)?;
        let stem = format!("{PREFIX}{}", start_us / 1_000_000);
        let mut writer = Writer {
            folder: folder.to_owned(),
            stem,
            limits,
            header,
            file: None,
            parts: Vec::new(),
            failed_at: None,
            failing: Arc::default(),
            synced_at: Instant::now(),
        };
        writer.open_next().map_err(fault)?;
        let failing = Arc::clone(&writer.failing);
        let (sender, receiver) = sync_channel(QUEUE);
        let thread = std::thread::Builder::new()
            .name("recorder".to_owned())
            .spawn(move || writer.run(&receiver))
            .map_err(Failure::failed)?;
        Ok(Self {
            sender: Some(sender),
            thread: Some(thread),
            backlog: VecDeque::new(),
            backlog_bytes: 0,
            lost_bytes: 0,
            failing,
            told_failing: false,
        })
    }

    /// Hands whole records to the disk, without waiting for it.
    pub(super) fn write(&mut self, records: Vec<u8>) {
        if !records.is_empty() {
            self.backlog_bytes += records.len();
            self.backlog.push_back(records);
        }
        let Some(sender) = &self.sender else { return };
        while let Some(records) = self.backlog.pop_front() {
            let length = records.len();
            match sender.try_send(records) {
                Ok(()) => self.backlog_bytes -= length,
                Err(TrySendError::Full(records)) => {
                    self.backlog.push_front(records);
                    break;
                }
                Err(TrySendError::Disconnected(_)) => {
                    self.backlog.clear();
                    self.backlog_bytes = 0;
                    self.sender = None;
                    return;
                }
            }
        }
        while self.backlog_bytes > BACKLOG {
            let Some(lost) = self.backlog.pop_front() else { break };
            if self.lost_bytes == 0 {
                tracing::error!("the disk is too slow for the recording: parts of it are lost");
            }
            self.backlog_bytes -= lost.len();
            self.lost_bytes += lost.len() as u64;
        }
    }

    /// Whether the log can be written, when that has changed since the last call.
    pub(super) fn poll_failing(&mut self) -> Option<bool> {
        let failing = self.failing.load(Ordering::Relaxed);
        (std::mem::replace(&mut self.told_failing, failing) != failing).then_some(failing)
    }

    /// Writes what is waiting and ends, then makes the report of the recording.
    pub(super) fn finish_with_report(self) {
        let parts = self.finish();
        let Some(folder) = parts.first().map(|part| part.with_extension("report")) else { return };
        match report::make(&parts, &folder) {
            Ok(()) => tracing::info!("log {}, report {}", parts[0].display(), folder.display()),
            Err(failure) => tracing::warn!("log {}; no report: {failure}", parts[0].display()),
        }
    }

    /// Writes what is waiting and ends; the files of the recording.
    fn finish(mut self) -> Vec<PathBuf> {
        if let Some(sender) = self.sender.take() {
            for records in self.backlog.drain(..) {
                sender.send(records).ok();
            }
        }
        self.thread.take().and_then(|thread| thread.join().ok()).unwrap_or_default()
    }
}

/// The side of the thread.
struct Writer {
    folder: PathBuf,
    stem: String,
    limits: RecordLimits,
    header: Vec<u8>,
    /// The file being written and the length of its whole records.
    file: Option<(File, u64)>,
    parts: Vec<PathBuf>,
    failed_at: Option<Instant>,
    failing: Arc<AtomicBool>,
    synced_at: Instant,
}

impl Writer {
    fn run(mut self, receiver: &Receiver<Vec<u8>>) -> Vec<PathBuf> {
        let mut is_first = true;
        loop {
            match receiver.recv_timeout(SYNC) {
                Ok(records) => {
                    // The header was in the first piece already.
                    self.write(&records, is_first);
                    is_first = false;
                }
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => break,
            }
            self.sync(SYNC);
        }
        self.sync(Duration::ZERO);
        self.parts
    }

    /// Writes whole records, into the next file where this one is full. Steering goes on whatever happens here.
    fn write(&mut self, records: &[u8], has_header: bool) {
        if self.failed_at.is_some_and(|then| then.elapsed() < RETRY) {
            return;
        }
        let fits = self
            .file
            .as_ref()
            .is_some_and(|(_, length)| has_header || length + records.len() as u64 <= self.limits.file_bytes);
        let result = if fits {
            self.append(records)
        } else {
            self.sync(Duration::ZERO);
            self.open_next()
                .and_then(|()| self.append(&self.header.clone()))
                .and_then(|()| self.append(records))
        };
        match (result, self.failed_at) {
            (Ok(()), None) => {}
            (Ok(()), Some(_)) => {
                tracing::warn!("recording again; what happened meanwhile is not in the log");
                self.failed_at = None;
                self.failing.store(false, Ordering::Relaxed);
            }
            (Err(error), before) => {
                if before.is_none() {
                    tracing::error!(
                        "cannot record in {}: {error}; everything else goes on, and the log is valid up to here",
                        self.folder.display()
                    );
                }
                self.file = None;
                self.failed_at = Some(Instant::now());
                self.failing.store(true, Ordering::Relaxed);
            }
        }
    }

    /// Appends to the present file; what a failed write has left of a record is cut off again.
    fn append(&mut self, records: &[u8]) -> io::Result<()> {
        let Some((file, length)) = &mut self.file else {
            return Err(io::Error::other("there is no file"));
        };
        match file.write_all(records) {
            Ok(()) => {
                *length += records.len() as u64;
                Ok(())
            }
            Err(error) => {
                file.set_len(*length).ok();
                Err(error)
            }
        }
    }

    fn open_next(&mut self) -> io::Result<()> {
        self.remove_oldest();
        let path = self.folder.join(format!("{}-{:03}.tlog", self.stem, self.parts.len()));
        let file = OpenOptions::new().write(true).create_new(true).open(&path)?;
        self.file = Some((file, 0));
        self.parts.push(path);
        Ok(())
    }

    /// Makes room for one more file within the limit, at the cost of the oldest ones.
    fn remove_oldest(&self) {
        let mut files = recordings(&self.folder);
        let mut total: u64 = files.iter().map(|(_, length)| length).sum();
        files.reverse();
        while total + self.limits.file_bytes > self.limits.total_bytes {
            let Some((path, length)) = files.pop() else { break };
            match fs::remove_file(&path) {
                Ok(()) => {
                    tracing::info!("removed {} to stay below the limit", path.display());
                    total -= length;
                }
                Err(error) => tracing::warn!("cannot remove {}: {error}", path.display()),
            }
        }
    }

    fn sync(&mut self, after: Duration) {
        if let Some((file, _)) = self.file.as_ref().filter(|_| self.synced_at.elapsed() >= after) {
            file.sync_data().ok();
            self.synced_at = Instant::now();
        }
    }
}

/// Every recording in a folder with its length, the oldest first.
fn recordings(folder: &Path) -> Vec<(PathBuf, u64)> {
    let Ok(entries) = fs::read_dir(folder) else { return Vec::new() };
    let is_ours = |name: &str| name.starts_with(PREFIX) && name.ends_with(".tlog");
    let mut files: Vec<(PathBuf, u64)> = entries
        .flatten()
        .filter(|entry| entry.file_name().to_str().is_some_and(is_ours))
        .map(|entry| (entry.path(), entry.metadata().map_or(0, |metadata| metadata.len())))
        .collect();
    files.sort();
    files
}

#[cfg(test)]
mod tests {
    use super::*;

    fn folder(name: &str) -> PathBuf {
        let path = std::env::temp_dir().join(format!("helmlink-recorder-{name}-{}", std::process::id()));
        fs::remove_dir_all(&path).ok();
        path
    }

    fn record(folder: &Path, limits: RecordLimits, pieces: usize) -> Vec<PathBuf> {
        let header = b"HEAD".to_vec();
        let mut recorder = Recorder::start(folder, limits, 1_795_000_000_000_000, header.clone()).unwrap();
        recorder.write(header);
        for number in 0..pieces {
            recorder.write(vec![number as u8; 100]);
        }
        recorder.finish()
    }

    #[test]
    fn a_long_recording_goes_into_several_files_with_the_header_in_each() {
        let folder = folder("rotates");
        let parts = record(&folder, RecordLimits { file_bytes: 1000, total_bytes: 1_000_000 }, 50);
        assert!(parts.len() > 4, "{parts:?}");
        let mut pieces = Vec::new();
        for part in &parts {
            let bytes = fs::read(part).unwrap();
            assert!(bytes.len() <= 1004 && bytes.starts_with(b"HEAD"));
            pieces.extend(bytes[4..].iter().step_by(100).copied());
        }
        assert_eq!(pieces, (0..50).collect::<Vec<u8>>());
        fs::remove_dir_all(folder).unwrap();
    }

    #[test]
    fn the_oldest_files_make_room_and_others_are_left_alone() {
        let folder = folder("limits");
        fs::create_dir_all(&folder).unwrap();
        fs::write(folder.join("helmlink-1000000000-000.tlog"), vec![0; 5000]).unwrap();
        fs::write(folder.join("mine.tlog"), vec![0; 5000]).unwrap();
        record(&folder, RecordLimits { file_bytes: 1000, total_bytes: 3000 }, 100);
        let total: u64 = recordings(&folder).iter().map(|(_, length)| length).sum();
        assert!(total <= 3000, "{total}");
        assert!(!folder.join("helmlink-1000000000-000.tlog").exists() && folder.join("mine.tlog").exists());
        fs::remove_dir_all(folder).unwrap();
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn a_full_disk_does_not_stop_the_caller() {
        let folder = folder("full");
        let limits = RecordLimits { file_bytes: 1000, total_bytes: 1_000_000 };
        let mut writer = Writer {
            folder: folder.clone(),
            stem: "helmlink-1".to_owned(),
            limits,
            header: Vec::new(),
            file: Some((OpenOptions::new().write(true).open("/dev/full").unwrap(), 0)),
            parts: Vec::new(),
            failed_at: None,
            failing: Arc::default(),
            synced_at: Instant::now(),
        };
        writer.write(&[1; 100], false);
        assert!(writer.failing.load(Ordering::Relaxed) && writer.file.is_none());
        fs::create_dir_all(&folder).unwrap();
        writer.failed_at = Instant::now().checked_sub(RETRY);
        writer.write(&[2; 100], false);
        assert!(writer.failed_at.is_none(), "there is room again");
        assert_eq!(fs::read(&writer.parts[0]).unwrap(), [2; 100]);
        fs::remove_dir_all(folder).unwrap();
    }
}
