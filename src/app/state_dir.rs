//! The folder for what outlives a run.

use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use clap::Args;

use super::failure::Failure;

/// Where state is kept.
#[derive(Debug, Clone, Args)]
pub struct StateDirArgs {
    /// Keep what outlives a run in this folder [default: $STATE_DIRECTORY, else ~/.local/state/helmlink]
    #[arg(long, value_name = "DIR")]
    pub state_dir: Option<PathBuf>,
}

impl StateDirArgs {
    /// The folder, which exists from now on.
    pub(super) fn folder(&self) -> Result<PathBuf, Failure> {
        let variable =
            |name: &str| std::env::var_os(name).filter(|value| !value.is_empty()).map(PathBuf::from);
        let folder = self
            .state_dir
            .clone()
            // Given by systemd to services with StateDirectory=.
            .or_else(|| variable("STATE_DIRECTORY"))
            .or_else(|| variable("XDG_STATE_HOME").map(|base| base.join("helmlink")))
            .or_else(|| variable("HOME").map(|home| home.join(".local/state/helmlink")))
            .ok_or_else(|| Failure::usage("no folder to keep state in: give --state-dir DIR"))?;
        fs::create_dir_all(&folder).map_err(|error| {
            Failure::usage(format!("cannot make {}: {error}; choose another --state-dir", folder.display()))
        })?;
        Ok(folder)
    }
}

/// Writes a file so that it is at any time either the old or the new one, whole, even when the power fails.
pub(super) fn write_whole(path: &Path, contents: &[u8]) -> io::Result<()> {
    let fresh = path.with_extension("new");
    let mut file = File::create(&fresh)?;
    file.write_all(contents)?;
    file.sync_all()?;
    fs::rename(&fresh, path)
}
