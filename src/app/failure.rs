//! How a command ends: one line that names the cause and the fix, and an exit code that means something.

use std::fmt;
use std::process::ExitCode;

/// The kinds of failure, by exit code.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    /// 1: the job did not succeed.
    Failed,
    /// 2: wrong usage or input.
    Usage,
    /// 3: no link.
    NoLink,
}

/// Why a command could not do its job.
#[derive(Debug)]
pub(super) struct Failure {
    kind: Kind,
    text: String,
}

impl Failure {
    /// The job did not succeed (exit code 1).
    pub(super) fn failed(text: impl fmt::Display) -> Self {
        Self { kind: Kind::Failed, text: text.to_string() }
    }

    /// Wrong usage or input (exit code 2).
    pub(super) fn usage(text: impl fmt::Display) -> Self {
        Self { kind: Kind::Usage, text: text.to_string() }
    }

    /// No link (exit code 3).
    pub(super) fn no_link(text: impl fmt::Display) -> Self {
        Self { kind: Kind::NoLink, text: text.to_string() }
    }

    /// The exit code.
    pub(super) fn exit_code(&self) -> ExitCode {
        ExitCode::from(match self.kind {
            Kind::Failed => 1,
            Kind::Usage => 2,
            Kind::NoLink => 3,
        })
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.text)
    }
}
