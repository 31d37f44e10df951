//! The signing key from its file, and the time stamps from run to run.

use std::fs;
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime, UNIX_EPOCH};

use helmlink_wire::signing::{Signing, SigningKey, Timestamp};

use crate::app::failure::Failure;
use crate::app::state_dir::write_whole;

/// The file in the state folder.
const FILE: &str = "signing-timestamp";
/// How often the time stamp is written.
const SAVE_INTERVAL: Duration = Duration::from_secs(10);

/// A key, and where its time stamps are kept.
pub(super) struct SigningStore {
    key: SigningKey,
    start: Timestamp,
    path: PathBuf,
    saved: Option<Duration>,
    complained: bool,
}

impl SigningStore {
    /// Reads the key, and the time stamp of the last run.
    pub(super) fn open(key: &Path, state: &Path) -> Result<Self, Failure> {
        let path = state.join(FILE);
        let clock = Timestamp::from_unix(SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default());
        let key = read_key(key)?;
        let start = clock.max(last(&path)?);
        let mut store = Self { key, start, path, saved: None, complained: false };
        // Before the first frame: a run that is killed at once has used some already.
        store.save(Some(start));
        Ok(store)
    }

    /// The signatures of this run.
    pub(super) fn signing(&self) -> Signing {
        Signing::new(self.key.clone(), self.start)
    }

    /// Keeps the time stamp, now and then, for the next run.
    pub(super) fn save_when_due(&mut self, now: Duration, timestamp: Option<Timestamp>) {
        if self.saved.is_none_or(|then| now.saturating_sub(then) >= SAVE_INTERVAL) {
            self.saved = Some(now);
            self.save(timestamp);
        }
    }

    /// Keeps the time stamp for the next run.
    pub(super) fn save(&mut self, timestamp: Option<Timestamp>) {
        let Some(timestamp) = timestamp else { return };
        match write_whole(&self.path, format!("{}\n", timestamp.units()).as_bytes()) {
            Ok(()) => self.complained = false,
            Err(error) if !self.complained => {
                self.complained = true;
                tracing::error!("cannot keep the signing time stamp in {}: {error}", self.path.display());
            }
            Err(_) => {}
        }
    }
}

/// Later than any time stamp the last run can have used.
fn last(path: &Path) -> Result<Timestamp, Failure> {
    match fs::read_to_string(path) {
        Ok(text) => {
            let units = text.trim().parse().map_err(|_| {
                Failure::usage(format!(
                    "{} holds no time stamp: delete it if the clock is right",
                    path.display()
                ))
            })?;
            Ok(Timestamp::from_units(units).later(SAVE_INTERVAL))
        }
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => Ok(Timestamp::default()),
        Err(error) => Err(Failure::usage(format!("cannot read {}: {error}", path.display()))),
    }
}

fn read_key(path: &Path) -> Result<SigningKey, Failure> {
    let fault = |what: String| Failure::usage(format!("--signing-key {}: {what}", path.display()));
    let file = fs::metadata(path).map_err(|error| fault(error.to_string()))?;
    if others_may_read(&file) {
        return Err(fault(format!("others can read it: chmod 600 {}", path.display())));
    }
    let contents = fs::read(path).map_err(|error| fault(error.to_string()))?;
    SigningKey::from_file_contents(&contents).map_err(|error| fault(error.to_string()))
}

#[cfg(unix)]
fn others_may_read(file: &fs::Metadata) -> bool {
    use std::os::unix::fs::PermissionsExt;
    const GROUP_OR_WORLD: u32 = 0o077;
    file.permissions().mode() & GROUP_OR_WORLD != 0
}

/// Elsewhere, permissions are not for this program to judge.
#[cfg(not(unix))]
fn others_may_read(_: &fs::Metadata) -> bool {
    false
}

#[cfg(unix)]
#[cfg(test)]
mod tests {
    use std::os::unix::fs::PermissionsExt;

    use super::*;

    /// A folder with a key file in it, removed at the end.
    struct Folder(PathBuf);

    impl Folder {
        fn new(name: &str) -> Self {
            let path = std::env::temp_dir().join(format!("helmlink-signing-{name}-{}", std::process::id()));
            fs::create_dir_all(&path).unwrap();
            let folder = Self(path);
            fs::write(folder.key(), "a passphrase of some length\n").unwrap();
            fs::set_permissions(folder.key(), fs::Permissions::from_mode(0o600)).unwrap();
            folder
        }

        fn key(&self) -> PathBuf {
            self.0.join("key")
        }

        fn open(&self) -> Result<SigningStore, Failure> {
            SigningStore::open(&self.key(), &self.0)
        }
    }

    impl Drop for Folder {
        fn drop(&mut self) {
            fs::remove_dir_all(&self.0).ok();
        }
    }

    #[test]
    fn a_key_that_others_can_read_is_refused() {
        let folder = Folder::new("mode");
        for (mode, fits) in [(0o600, true), (0o400, true), (0o640, false), (0o604, false)] {
            fs::set_permissions(folder.key(), fs::Permissions::from_mode(mode)).unwrap();
            let result = folder.open();
            assert_eq!(result.is_ok(), fits, "{mode:o}");
            if let Err(failure) = result {
                assert!(failure.to_string().contains("chmod 600"));
            }
        }
    }

    #[test]
    fn time_stamps_go_on_after_a_restart_with_a_clock_gone_back() {
        let folder = Folder::new("restart");
        let far = Timestamp::from_unix(Duration::from_secs(4_000_000_000));
        folder.open().unwrap().save(Some(far));
        assert!(folder.open().unwrap().signing().timestamp() > far);
    }

    #[test]
    fn a_run_that_is_killed_at_once_has_used_its_time_stamps_up() {
        let folder = Folder::new("killed");
        let first = folder.open().unwrap().signing().timestamp();
        assert!(folder.open().unwrap().signing().timestamp() >= first.later(SAVE_INTERVAL));
    }

    #[test]
    fn a_spoilt_file_is_named() {
        let folder = Folder::new("spoilt");
        fs::write(folder.0.join(FILE), "yesterday").unwrap();
        assert!(folder.open().err().unwrap().to_string().contains(FILE));
    }
}
