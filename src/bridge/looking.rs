//! What the driver can look at, and the journal that it may have kept.

use helmlink_wire::{LinkId, LinkStatistics};

use super::{Bridge, Counts, Status};
use crate::control::Helm;
use crate::pilot::MissionRun;
use crate::record::{ControlState, Header, Journal};

impl Bridge {
    /// The bridge at this instant.
    pub fn status(&self) -> Status {
        let helm = self.run.as_ref().map(MissionRun::helm);
        Status {
            state: self.supervisor.state(),
            reason: self.reason,
            vehicle: self.vehicle.map(|vehicle| vehicle.id),
            mode: self.telemetry.mode(),
            armed: self.telemetry.is_armed(),
            progress: self.run.as_ref().map(MissionRun::progress),
            demand: self.steering.demand,
            diagnostics: self.steering.diagnostics,
            steps: self.steering.steps,
            pace: self.steering.pace,
            round_trip_s: self.timesync.round_trip().map(|trip| trip.as_secs_f64()),
            answer_delay: helm.and_then(Helm::measured_delay),
            compass: helm.map(Helm::compass_error),
            delay_s: helm.map_or(0.0, Helm::delay_s),
        }
    }

    /// [`Self::abandon`] was called.
    pub fn is_abandoned(&self) -> bool {
        self.abandoned
    }

    /// How often what has gone wrong so far.
    pub fn counts(&self) -> &Counts {
        &self.counts
    }

    /// Control steps made so far.
    pub fn steps(&self) -> u64 {
        self.steering.steps
    }

    /// The mission being driven, once there is one.
    pub fn run(&self) -> Option<&MissionRun> {
        self.run.as_ref()
    }

    /// What the controller took in and thought at the last step, once there was one.
    pub fn thought(&self) -> Option<ControlState> {
        self.steering.thought
    }

    /// Why this vehicle cannot be steered at all, if so.
    pub fn refusal(&self) -> Option<&str> {
        self.refusal.as_deref()
    }

    /// What a link has carried and lost.
    pub fn statistics(&self, link: LinkId) -> Option<LinkStatistics> {
        self.links.statistics(link)
    }

    /// SHA-256 of every steering frame sent so far, in order, and their number.
    pub fn commands_digest(&self) -> (String, u64) {
        self.links.commands_digest()
    }

    /// Keeps everything received and sent, and what is needed to make the same calls again, for
    /// [`Self::take_journal`]. The driver's time zero is `unix_start_us` microseconds after the Unix epoch.
    /// To be called before anything else happens: see [`crate::record`].
    pub fn keep_journal(&mut self, unix_start_us: u64) {
        self.links.keep_journal(Journal::new(&Header::new(unix_start_us, &self.given)));
    }

    /// Keeps the frames of the bridge's own, not those it passes on, for [`Self::poll_own`] as well.
    pub fn keep_own(&mut self) {
        self.links.keep_own();
    }

    /// The next frame of the bridge's own that was put out for sending, where [`Self::keep_own`] was called.
    pub fn poll_own(&mut self) -> Option<(LinkId, Vec<u8>)> {
        self.links.poll_own()
    }

    /// Telemetry log records since the last call, whole ones only.
    pub fn take_journal(&mut self) -> Vec<u8> {
        self.links.journal().map(Journal::take).unwrap_or_default()
    }

    /// The last records of the log: nothing that happens afterwards can be proven from it.
    pub fn finish_journal(&mut self) -> Vec<u8> {
        self.links.journal().map(Journal::finish).unwrap_or_default()
    }

    /// The records with which every file of the log begins; those of the first are in [`Self::take_journal`] too.
    pub fn journal_header(&mut self) -> Vec<u8> {
        self.links.journal().map(|journal| journal.header().to_vec()).unwrap_or_default()
    }

    /// Lets the journal, if one is kept, take something down.
    pub(super) fn record(&mut self, write: impl FnOnce(&mut Journal)) {
        if let Some(journal) = self.links.journal() {
            write(journal);
        }
    }
}
