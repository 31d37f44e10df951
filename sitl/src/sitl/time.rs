//! Whether and how fast time passes.

use std::time::Duration;

use helmlink_wire::LinkId;

use super::Sitl;
use crate::clock::ClockOrder;

impl Sitl {
    /// While time is held: answers what clients have asked and takes their orders; no time passes.
    pub fn serve(&mut self) {
        self.autopilot.serve();
    }

    /// Stops time (true) or lets it pass again (false). While it stands, [`Sitl::advance`] only answers what
    /// clients ask.
    pub fn set_paused(&mut self, paused: bool) {
        let order = if paused { ClockOrder::Pause } else { ClockOrder::Resume };
        self.autopilot.clock.obey(LinkId(0), order, self.now);
    }

    /// Runs one loop of 20 ms with time stopped before and after.
    pub fn step(&mut self) {
        self.set_paused(true);
        self.run_loop();
    }

    /// Whether time stands because somebody has paused it.
    pub fn is_paused(&self) -> bool {
        self.autopilot.clock.is_paused()
    }

    /// Whether time cannot pass now: it is paused, or a client in lockstep has not answered.
    pub fn is_held(&self) -> bool {
        !self.autopilot.clock.may_run()
    }

    /// The clients in lockstep that time waits for.
    pub fn waits_for(&self) -> Vec<LinkId> {
        self.autopilot.clock.waits_for()
    }

    /// No longer waits for a client in lockstep.
    pub fn leave_lockstep(&mut self, link: LinkId) {
        self.autopilot.clock.forget(link);
    }

    /// From now on time passes by `beat` at the most until the client on `link` has answered: it gets
    /// SYSTEM_TIME after each beat, and sends the same message back when it is done with all up to then.
    pub fn join_lockstep(&mut self, link: LinkId, beat: Duration) {
        self.autopilot.clock.obey(link, ClockOrder::Join(beat), self.now);
    }

    /// The multiple of real time that the parameter SIM_SPEEDUP asks for; 0 is as fast as it goes. It is up to
    /// the owner to keep that pace.
    pub fn speedup(&self) -> f64 {
        self.autopilot.speedup()
    }

    /// Shows ground stations the pace.
    pub fn set_speedup(&mut self, speedup: f64) {
        self.autopilot.put_speedup(speedup);
    }
}
