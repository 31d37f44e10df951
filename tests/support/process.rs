//! A child process whose output is collected, and which does not outlive its test.

use std::io::{BufRead, BufReader, Read};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::sync::{Arc, Mutex};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// No step of a test takes longer than this, even on a busy machine.
pub const PATIENCE: Duration = Duration::from_secs(120);
/// How often an ending process is looked at.
const GLANCE: Duration = Duration::from_millis(5);

/// A child process, killed when dropped.
pub struct Process {
    child: Child,
    name: String,
    lines: Receiver<String>,
    printed: Arc<Mutex<String>>,
    readers: Vec<JoinHandle<()>>,
}

/// What a process left behind.
#[derive(Debug)]
pub struct Ended {
    /// How it ended.
    pub status: ExitStatus,
    /// Everything it printed, standard output and standard error as they came.
    pub printed: String,
}

impl Process {
    /// Starts `command`.
    pub fn start(name: &str, command: &mut Command) -> Self {
        let mut child = command
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap_or_else(|error| panic!("cannot start {name}: {error}"));
        let (to_lines, lines) = channel();
        let printed = Arc::new(Mutex::new(String::new()));
        let collect = |stream: Box<dyn Read + Send>| {
            let (to_lines, printed) = (to_lines.clone(), Arc::clone(&printed));
            std::thread::spawn(move || {
                for line in BufReader::new(stream).lines().map_while(Result::ok) {
                    let mut all = printed.lock().expect("a reader panicked");
                    all.push_str(&line);
                    all.push('\n');
                    drop(all);
                    to_lines.send(line).ok();
                }
            })
        };
        let readers = vec![
            collect(Box::new(child.stdout.take().expect("piped"))),
            collect(Box::new(child.stderr.take().expect("piped"))),
        ];
        Self { child, name: name.to_owned(), lines, printed, readers }
    }

    /// The next line with `text` in it, from standard output or standard error.
    pub fn wait_for_line(&self, text: &str) -> String {
        let deadline = Instant::now() + PATIENCE;
        loop {
            match self.lines.recv_timeout(deadline.saturating_duration_since(Instant::now())) {
                Ok(line) if line.contains(text) => return line,
                Ok(_) => {}
                Err(RecvTimeoutError::Timeout) => self.fail(&format!("did not print `{text}` in time")),
                Err(RecvTimeoutError::Disconnected) => self.fail(&format!("ended without printing `{text}`")),
            }
        }
    }

    /// Asks the process to end as Ctrl-C does.
    #[cfg(unix)]
    pub fn interrupt(&self) {
        self.signal(rustix::process::Signal::INT);
    }

    /// Ends the process on the spot, without asking.
    pub fn kill(&mut self) {
        self.child.kill().expect("can be killed");
        self.child.wait().expect("has been started");
    }

    /// Asks the process to end as service managers do.
    #[cfg(unix)]
    pub fn terminate(&self) {
        self.signal(rustix::process::Signal::TERM);
    }

    /// Tells the process that its terminal has gone.
    #[cfg(unix)]
    pub fn hang_up(&self) {
        self.signal(rustix::process::Signal::HUP);
    }

    #[cfg(unix)]
    fn signal(&self, signal: rustix::process::Signal) {
        let id = rustix::process::Pid::from_child(&self.child);
        rustix::process::kill_process(id, signal).expect("is running");
    }

    /// The process id.
    pub fn id(&self) -> u32 {
        self.child.id()
    }

    /// Everything printed so far.
    pub fn printed(&self) -> String {
        self.printed.lock().expect("a reader panicked").clone()
    }

    /// Waits for the end.
    pub fn wait(mut self) -> Ended {
        let deadline = Instant::now() + PATIENCE;
        let status = loop {
            if let Some(status) = self.child.try_wait().expect("has been started") {
                break status;
            }
            if Instant::now() > deadline {
                self.fail("did not end in time");
            }
            std::thread::sleep(GLANCE);
        };
        for reader in self.readers.drain(..) {
            reader.join().expect("a reader panicked");
        }
        Ended { status, printed: self.printed() }
    }

    /// Waits for the end, which must be a good one; returns what was printed.
    pub fn succeed(self) -> String {
        let name = self.name.clone();
        let ended = self.wait();
        assert!(ended.status.success(), "{name} failed ({}):\n{}", ended.status, ended.printed);
        ended.printed
    }

    fn fail(&self, what: &str) -> ! {
        panic!("{} {what}; it printed:\n{}", self.name, self.printed());
    }
}

impl Drop for Process {
    fn drop(&mut self) {
        self.child.kill().ok();
        self.child.wait().ok();
    }
}
