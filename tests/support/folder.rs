//! Folders for what a program under test keeps.

use std::fs;
use std::path::PathBuf;

/// A folder of a test's own, empty at the start and removed at the end.
pub struct Folder(pub PathBuf);

impl Folder {
    /// A folder of this name among those of this process.
    pub fn new(name: &str) -> Self {
        let path = std::env::temp_dir().join(format!("helmlink-{name}-{}", std::process::id()));
        fs::remove_dir_all(&path).ok();
        fs::create_dir_all(&path).unwrap();
        Self(path)
    }

    /// Its path as a text.
    pub fn path(&self) -> &str {
        self.0.to_str().unwrap()
    }

    /// The only file in it whose name ends so.
    pub fn file(&self, ending: &str) -> PathBuf {
        let paths = fs::read_dir(&self.0).unwrap().map(|entry| entry.unwrap().path());
        let fits = |path: &PathBuf| path.to_str().unwrap().ends_with(ending);
        let found: Vec<_> = paths.filter(fits).collect();
        assert_eq!(found.len(), 1, "one file {ending} in {}: {found:?}", self.path());
        found.into_iter().next().unwrap()
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        fs::remove_dir_all(&self.0).ok();
    }
}
