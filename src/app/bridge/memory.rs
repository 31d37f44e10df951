//! What outlives a run of the bridge: its parameters, and where on which mission it was.
//!
//! Files are written by a thread of their own: a slow disk must not hold up the control loop.

use std::path::PathBuf;
use std::sync::mpsc::{Sender, channel};
use std::thread::JoinHandle;
use std::time::Duration;

use crate::app::failure::Failure;
use crate::app::state_dir::write_whole;
use crate::bridge::Bridge;
use crate::bridge::resume::ResumePoint;
use crate::link::LinkUrl;

/// While nothing but the position changes, it is kept this often.
const INTERVAL: Duration = Duration::from_secs(5);

/// A file that waits to be written.
type Job = (PathBuf, Vec<u8>);

/// Keeps parameters and resume point of the bridge on one link.
pub(super) struct Memory {
    parameters: PathBuf,
    resume: PathBuf,
    kept: Option<(ResumePoint, Duration)>,
    jobs: Option<Sender<Job>>,
    writer: Option<JoinHandle<()>>,
}

impl Memory {
    /// The memory of the bridge on this link: several bridges on one machine do not mix theirs up.
    pub(super) fn open(folder: &std::path::Path, connect: &LinkUrl) -> Self {
        let name: String = connect
            .to_string()
            .chars()
            .map(|letter| if letter.is_ascii_alphanumeric() { letter } else { '-' })
            .collect();
        let (jobs, todo) = channel::<Job>();
        let writer = std::thread::spawn(move || {
            while let Ok((path, contents)) = todo.recv() {
                if let Err(error) = write_whole(&path, &contents) {
                    tracing::error!("cannot keep {}: {error}", path.display());
                }
            }
        });
        Self {
            parameters: folder.join(format!("{name}.parm")),
            resume: folder.join(format!("{name}.resume.json")),
            kept: None,
            jobs: Some(jobs),
            writer: Some(writer),
        }
    }

    /// The parameters of earlier runs.
    ///
    /// # Errors
    /// The file is there but cannot be read: a boat must not be driven with other gains than its owner has set.
    pub(super) fn parameters(&self) -> Result<String, Failure> {
        match std::fs::read_to_string(&self.parameters) {
            Ok(text) => Ok(text),
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => Ok(String::new()),
            Err(error) => {
                let path = self.parameters.display();
                Err(Failure::usage(format!(
                    "cannot read the parameters in {path}: {error}; remove it for factory values"
                )))
            }
        }
    }

    /// Where the last run was.
    ///
    /// # Errors
    /// The file is there but makes no sense: says so, rather than start from the beginning.
    pub(super) fn resume_point(&self) -> Result<Option<ResumePoint>, Failure> {
        let path = self.resume.display();
        match std::fs::read_to_string(&self.resume) {
            Ok(text) => serde_json::from_str(&text).map(Some).map_err(|error| {
                Failure::usage(format!(
                    "--resume: {path} makes no sense: {error}; remove it and engage by hand"
                ))
            }),
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => Ok(None),
            Err(error) => Err(Failure::usage(format!("--resume: cannot read {path}: {error}"))),
        }
    }

    /// Keeps what has changed.
    pub(super) fn keep(&mut self, now: Duration, bridge: &mut Bridge) {
        if let Some(text) = bridge.take_parameters() {
            self.write(self.parameters.clone(), text.into_bytes());
        }
        let Some(point) = bridge.resume_point() else { return };
        let is_news = self.kept.as_ref().is_none_or(|(kept, then)| {
            let same =
                (&kept.mission, kept.item, kept.driving) == (&point.mission, point.item, point.driving);
            !same || (point.driving && now.saturating_sub(*then) >= INTERVAL)
        });
        // A bridge that only waits has nothing to say about a drive that another one may want to take up.
        if is_news && (point.driving || self.kept.is_some()) {
            if let Ok(text) = serde_json::to_vec(&point) {
                self.write(self.resume.clone(), text);
            }
            self.kept = Some((point, now));
        }
    }

    fn write(&self, path: PathBuf, contents: Vec<u8>) {
        if let Some(jobs) = &self.jobs {
            // The thread ends only when this end is dropped.
            jobs.send((path, contents)).ok();
        }
    }
}

impl Drop for Memory {
    /// Waits until everything is written.
    fn drop(&mut self) {
        self.jobs = None;
        if let Some(writer) = self.writer.take() {
            writer.join().ok();
        }
    }
}
