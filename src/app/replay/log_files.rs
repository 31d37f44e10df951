//! The files of one log, read as one.

use std::fs::{self, File};
use std::io::{self, Read};
use std::path::{Path, PathBuf};

use super::Failure;

/// The files of one log in order.
#[derive(Debug, Clone)]
pub(in crate::app) struct LogFiles {
    paths: Vec<PathBuf>,
    bytes: u64,
}

impl LogFiles {
    /// Files as given; a folder stands for the `.tlog` files in it, in order of their names.
    ///
    /// # Errors
    /// What is not there or is no log by its looks.
    pub(in crate::app) fn find(given: &[PathBuf]) -> Result<Self, Failure> {
        let (mut paths, mut bytes) = (Vec::new(), 0);
        for path in given {
            if path.is_dir() {
                paths.extend(logs_in(path)?);
            } else {
                paths.push(path.clone());
            }
        }
        for path in &paths {
            let fault = |error: io::Error| Failure::usage(format!("cannot read {}: {error}", path.display()));
            bytes += fs::metadata(path).map_err(fault)?.len();
            File::open(path).map_err(fault)?;
        }
        Ok(Self { paths, bytes })
    }

    /// All of them, one after the other.
    pub(in crate::app) fn open(&self) -> impl Read + use<> {
        Chain { left: self.paths.clone().into_iter(), file: None }
    }

    /// Their length together.
    pub(in crate::app) fn bytes(&self) -> u64 {
        self.bytes
    }

    /// The files.
    pub(in crate::app) fn paths(&self) -> &[PathBuf] {
        &self.paths
    }

    /// The files, for a complaint.
    pub(in crate::app) fn shown(&self) -> String {
        match self.paths.as_slice() {
            [] => "the log".to_owned(),
            [path] => path.display().to_string(),
            [path, others @ ..] => format!("{} (and {} more)", path.display(), others.len()),
        }
    }

    /// What the log is called.
    pub(in crate::app) fn name(&self) -> String {
        let stem = self.paths.first().and_then(|path| path.file_stem());
        stem.map_or_else(|| "log".to_owned(), |stem| stem.to_string_lossy().into_owned())
    }
}

fn logs_in(folder: &Path) -> Result<Vec<PathBuf>, Failure> {
    let entries = fs::read_dir(folder)
        .map_err(|error| Failure::usage(format!("cannot read {}: {error}", folder.display())))?;
    let mut logs: Vec<PathBuf> = entries
        .flatten()
        .map(|entry| entry.path())
        .filter(|path| path.extension().is_some_and(|extension| extension == "tlog"))
        .collect();
    logs.sort();
    if logs.is_empty() {
        return Err(Failure::usage(format!("{} holds no .tlog file", folder.display())));
    }
    Ok(logs)
}

/// Files read one after the other, each opened when its turn comes.
struct Chain {
    left: std::vec::IntoIter<PathBuf>,
    file: Option<File>,
}

impl Read for Chain {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        loop {
            if let Some(file) = &mut self.file {
                let count = file.read(buffer)?;
                if count > 0 || buffer.is_empty() {
                    return Ok(count);
                }
            }
            match self.left.next() {
                Some(path) => self.file = Some(File::open(path)?),
                None => return Ok(0),
            }
        }
    }
}
