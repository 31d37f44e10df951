//! Ground-station clients in Python, in a virtual environment under `target/` that installs itself.

use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;

use super::process::Process;

/// What is installed, one pinned package a line.
const REQUIREMENTS: &str = include_str!("../clients/requirements.txt");

/// A client script of `tests/clients/`.
pub struct Script;

impl Script {
    /// Starts a script.
    pub fn start(script: &str, arguments: &[&str]) -> Process {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/clients").join(script);
        let mut command = Command::new(environment().join("bin/python"));
        // -u: a line must be seen when it is printed; -B: no byte code between the sources.
        command.args(["-u", "-B"]).arg(path).args(arguments);
        command.env("MAVLINK20", "1");
        Process::start(&format!("{script} {}", arguments.join(" ")), &mut command)
    }

    /// Runs a script, which must succeed; returns what it printed.
    pub fn run(script: &str, arguments: &[&str]) -> String {
        Self::start(script, arguments).succeed()
    }
}

/// The folder with the `python3` that has all these packages.
pub fn python_folder() -> PathBuf {
    environment().join("bin")
}

/// The virtual environment, installed when it is not there or when the pinned packages have changed.
fn environment() -> &'static Path {
    static ENVIRONMENT: OnceLock<PathBuf> = OnceLock::new();
    ENVIRONMENT.get_or_init(|| {
        let place = Path::new(env!("CARGO_TARGET_TMPDIR"));
        fs::create_dir_all(place).expect("target/tmp can be made");
        let lock = File::create(place.join("python-clients.lock")).expect("target/tmp can be written");
        // Several test binaries may want it at the same time: the first one installs, the others wait.
        lock.lock().expect("the file system supports locks");
        let folder = place.join("python-clients");
        let stamp = folder.join("installed.txt");
        if fs::read_to_string(&stamp).ok().as_deref() != Some(REQUIREMENTS) {
            install(&folder);
            fs::write(&stamp, REQUIREMENTS).expect("target/tmp can be written");
        }
        folder
    })
}

fn install(folder: &Path) {
    fs::remove_dir_all(folder).ok();
    let python = std::env::var("PYTHON").unwrap_or_else(|_| "python3".to_owned());
    must_work(
        Command::new(&python).args(["-m", "venv"]).arg(folder),
        "the tests with real ground stations need Python 3.10 or newer with venv and pip: install it (on Debian \
         and Ubuntu: apt install python3-venv), or name another Python in the variable PYTHON",
    );
    let list = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/clients/requirements.txt");
    must_work(
        Command::new(folder.join("bin/python"))
            // Not what the packages would draw in (MAVProxy: OpenCV, VTK, ...): the list has all that is used.
            .args([
                "-m",
                "pip",
                "install",
                "--quiet",
                "--disable-pip-version-check",
                "--no-deps",
                "--prefer-binary",
            ])
            .args(["--requirement".as_ref(), list.as_os_str()]),
        "pip could not install the ground stations that the tests run (tests/clients/requirements.txt): the first \
         run of the tests needs a package index; check the network, or pip's settings for a mirror or a proxy",
    );
}

/// Runs a step of the installation; when it fails, says what it printed and how to mend it.
fn must_work(command: &mut Command, advice: &str) {
    match command.output() {
        Ok(output) if output.status.success() => {}
        Ok(output) => panic!(
            "{advice}\n\n{command:?}: {}\n{}{}",
            output.status,
            String::from_utf8_lossy(&output.stdout),
            String::from_utf8_lossy(&output.stderr)
        ),
        Err(error) => panic!("{advice}\n\n{command:?}: {error}"),
    }
}
