//! How often what has gone wrong.

use crate::pilot::failsafe::{DEFINITIONS, Failsafe};

/// Counts since the start of the bridge.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Counts {
    failsafes: [u64; DEFINITIONS.len()],
    /// Control steps that gave no command.
    pub controller_errors: u64,
}

impl Counts {
    /// A failsafe has acted, or has warned.
    pub(super) fn on_failsafe(&mut self, failsafe: Failsafe) {
        self.failsafes[failsafe as usize] += 1;
    }

    /// Every failsafe by its key, with how often it has acted or warned.
    pub fn failsafes(&self) -> impl Iterator<Item = (&'static str, u64)> + '_ {
        DEFINITIONS.iter().map(|definition| (definition.key, self.failsafes[definition.failsafe as usize]))
    }
}
