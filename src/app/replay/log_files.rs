//! The files of one log, read as one.

use std::fs::{self, File};
use std::io::{self, Read, Seek, SeekFrom};
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

    /// All of them as one, to be read from any place.
    ///
    /// # Errors
    /// One of them cannot be opened.
    pub(in crate::app) fn open_joined(&self) -> io::Result<Joined> {
        let part = |path: &PathBuf| File::open(path).and_then(|file| Ok((file.metadata()?.len(), file)));
        Ok(Joined { parts: self.paths.iter().map(part).collect::<Result<_, _>>()?, at: 0 })
    }

    /// Their length together.
    pub(in crate::app) fn bytes(&self) -> u64 {
        self.bytes
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

/// Files that are read as one, from any place.
#[derive(Debug)]
pub(in crate::app) struct Joined {
    /// Length and file.
    parts: Vec<(u64, File)>,
    at: u64,
}

impl Read for Joined {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let mut start = 0;
        for (length, file) in &mut self.parts {
            if self.at < start + *length {
                file.seek(SeekFrom::Start(self.at - start))?;
                let left = usize::try_from(start + *length - self.at).unwrap_or(usize::MAX).min(buffer.len());
                let count = file.read(&mut buffer[..left])?;
                self.at += count as u64;
                return Ok(count);
            }
            start += *length;
        }
        Ok(0)
    }
}

impl Seek for Joined {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        let length: u64 = self.parts.iter().map(|(length, _)| length).sum();
        let place = match to {
            SeekFrom::Start(place) => Some(place),
            SeekFrom::Current(by) => self.at.checked_add_signed(by),
            SeekFrom::End(by) => length.checked_add_signed(by),
        };
        self.at = place.ok_or_else(|| io::Error::from(io::ErrorKind::InvalidInput))?;
        Ok(self.at)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_files_of_a_folder_are_one_log_from_any_place() {
        let folder = std::env::temp_dir().join(format!("helmlink-log-files-{}", std::process::id()));
        fs::create_dir_all(&folder).unwrap();
        for (name, content) in
            [("a-000.tlog", "one "), ("a-001.tlog", ""), ("a-002.tlog", "two three"), ("b.txt", "no")]
        {
            fs::write(folder.join(name), content).unwrap();
        }
        let files = LogFiles::find(std::slice::from_ref(&folder)).unwrap();
        let (mut whole, mut joined) = (String::new(), files.open_joined().unwrap());
        files.open().read_to_string(&mut whole).unwrap();
        assert_eq!((whole.as_str(), files.bytes()), ("one two three", 13));
        for (place, rest) in
            [(0, "one two three"), (2, "e two three"), (4, "two three"), (8, "three"), (13, ""), (99, "")]
        {
            let mut read = String::new();
            joined.seek(SeekFrom::Start(place)).unwrap();
            joined.read_to_string(&mut read).unwrap();
            assert_eq!(read, rest, "from {place}");
        }
        assert_eq!(joined.seek(SeekFrom::End(-5)).unwrap(), 8);
        assert!(joined.seek(SeekFrom::Current(-9)).is_err());
        fs::remove_dir_all(folder).unwrap();
    }
}
