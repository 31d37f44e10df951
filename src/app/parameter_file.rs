//! A file of parameters that outlives the simulated boat.

use std::fs;
use std::path::{Path, PathBuf};
use std::time::Duration;

use helmlink_sitl::Sitl;

use super::failure::Failure;

/// Changes are written at most this often.
const PAUSE: Duration = Duration::from_millis(500);

/// A file that follows the parameters of a boat.
#[derive(Debug)]
pub(super) struct ParameterFile {
    path: PathBuf,
    revision: u64,
    written: String,
    looked: Duration,
}

/// Reads `NAME=VALUE`, `NAME,VALUE` or `NAME VALUE`.
///
/// # Errors
/// What is wrong with the text.
pub(super) fn parse_assignment(text: &str) -> Result<(String, f32), String> {
    let wrong = || format!("`{text}` must be NAME=VALUE, such as WP_SPEED=2");
    let (name, value) = text.split_once(['=', ',', ' ', '\t']).ok_or_else(wrong)?;
    let value: f32 = value.trim().parse().map_err(|_| wrong())?;
    if name.trim().is_empty() || !value.is_finite() {
        return Err(wrong());
    }
    Ok((name.trim().to_uppercase(), value))
}

/// The parameters in a file; none when there is no file yet.
///
/// # Errors
/// The file cannot be read, or a line is no parameter: which.
pub(super) fn read(path: &Path) -> Result<Vec<(String, f32)>, Failure> {
    let text = match fs::read_to_string(path) {
        Ok(text) => text,
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(Vec::new()),
        Err(error) => return Err(Failure::usage(format!("--params {}: {error}", path.display()))),
    };
    let mut parameters = Vec::new();
    for (number, line) in text.lines().enumerate() {
        let line = line.split('#').next().unwrap_or_default().trim();
        if line.is_empty() {
            continue;
        }
        let parameter = parse_assignment(line).map_err(|why| {
            Failure::usage(format!("--params {}, line {}: {why}", path.display(), number + 1))
        })?;
        parameters.push(parameter);
    }
    Ok(parameters)
}

impl ParameterFile {
    /// A file that has just been read.
    pub(super) fn new(path: PathBuf, sitl: &Sitl) -> Self {
        let written = content(sitl);
        Self { path, revision: sitl.parameter_revision(), written, looked: Duration::ZERO }
    }

    /// Writes the file if a user's parameter has changed and the last look is long enough ago.
    ///
    /// # Errors
    /// The file cannot be written.
    pub(super) fn follow(&mut self, now: Duration, sitl: &Sitl) -> Result<(), Failure> {
        if now < self.looked + PAUSE || sitl.parameter_revision() == self.revision {
            return Ok(());
        }
        self.looked = now;
        self.save(sitl)
    }

    /// Writes the file if a user's parameter has changed.
    ///
    /// # Errors
    /// The file cannot be written.
    pub(super) fn save(&mut self, sitl: &Sitl) -> Result<(), Failure> {
        self.revision = sitl.parameter_revision();
        let content = content(sitl);
        if content == self.written {
            return Ok(());
        }
        replace(&self.path, &content).map_err(|error| {
            Failure::failed(format!("cannot write the parameters to {}: {error}", self.path.display()))
        })?;
        self.written = content;
        Ok(())
    }
}

fn content(sitl: &Sitl) -> String {
    let lines = sitl.changed_parameters().into_iter().map(|(name, value)| format!("{name},{value}\n"));
    lines.collect()
}

/// Puts a whole new file in place of the old one: whatever happens meanwhile, one of the two is there.
fn replace(path: &Path, content: &str) -> std::io::Result<()> {
    let mut name = path.file_name().unwrap_or_default().to_owned();
    name.push(format!(".{}.new", std::process::id()));
    let new = path.with_file_name(name);
    let written = write_through(&new, content).and_then(|()| fs::rename(&new, path));
    if written.is_err() {
        // Best effort: the first error is the one that matters.
        let _ = fs::remove_file(&new);
    }
    written
}

fn write_through(path: &Path, content: &str) -> std::io::Result<()> {
    use std::io::Write;
    let mut file = fs::File::create(path)?;
    file.write_all(content.as_bytes())?;
    file.sync_all()
}

#[cfg(test)]
mod tests {
    use helmlink_sitl::SitlSettings;
    use helmlink_sitl::physics::Hull;

    use super::*;

    fn boat(parameters: Vec<(String, f32)>) -> Sitl {
        let mut settings = SitlSettings::new(Hull::builtin("otter").unwrap());
        settings.autopilot.parameters = parameters;
        Sitl::new(settings).unwrap()
    }

    #[test]
    fn what_a_user_has_changed_comes_back_and_faults_do_not() {
        let folder = std::env::temp_dir().join(format!("helmlink-params-{}", std::process::id()));
        fs::create_dir_all(&folder).unwrap();
        let path = folder.join("boat.parm");
        assert!(read(&path).unwrap().is_empty(), "there is no file yet");
        let mut file = ParameterFile::new(path.clone(), &boat(Vec::new()));
        let changed = boat(vec![("WP_SPEED".into(), 1.25), ("SIM_GPS_DISABLE".into(), 1.0)]);
        file.follow(Duration::from_secs(1), &changed).unwrap();
        let parameters = read(&path).unwrap();
        assert_eq!(parameters, [("WP_SPEED".to_owned(), 1.25)]);
        assert_eq!(boat(parameters.clone()).changed_parameters(), parameters);
        assert_eq!(fs::read_dir(&folder).unwrap().count(), 1, "nothing else is left behind");
        fs::remove_dir_all(&folder).unwrap();
    }

    #[test]
    fn lines_are_read_in_every_usual_form_and_nonsense_names_its_line() {
        let folder = std::env::temp_dir().join(format!("helmlink-params-read-{}", std::process::id()));
        fs::create_dir_all(&folder).unwrap();
        let path = folder.join("boat.parm");
        fs::write(&path, "# comment\nWP_SPEED 2\nWP_RADIUS,3 # near\n\nfs_gcs_enable=1\n").unwrap();
        assert_eq!(read(&path).unwrap().len(), 3);
        fs::write(&path, "WP_SPEED 2\nWP_RADIUS\n").unwrap();
        assert!(read(&path).unwrap_err().to_string().contains("line 2"));
        fs::remove_dir_all(&folder).unwrap();
    }
}
