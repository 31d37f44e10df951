//! The bridge and the simulated boat, stepped in turn, with MAVLink frames in between.
//!
//! Both are the very parties that talk over sockets elsewhere; here their bytes change hands directly, so the
//! loop runs as fast as the machine allows and gives the same commands every time.

use std::collections::VecDeque;
use std::time::Duration;

use helmlink_mission::geodesy::Geodetic;
use helmlink_sitl::Sitl;
use helmlink_wire::LinkId;

use super::recorder::RunRecorder;
use super::score::Score;
use crate::bridge::Bridge;
use crate::pilot::supervisor::State;

/// Period of the autopilot's loop, after which the parties exchange bytes.
pub const LOOP: Duration = Duration::from_millis(20);
/// Loops between two samples of the score: 10 Hz.
const LOOPS_PER_SAMPLE: u32 = 5;
/// The one link between the two.
const LINK: LinkId = LinkId(1);

/// How a run ended.
#[derive(Debug, Clone, PartialEq)]
pub struct Outcome {
    /// The last waypoint was reached and the boat let go.
    pub completed: bool,
    /// Simulated time from start to end, seconds.
    pub simulated_s: f64,
    /// The figures; none when the first waypoint was never reached.
    pub score: Option<Score>,
    /// SHA-256 of every steering frame, in order.
    pub commands_sha256: String,
    /// Number of steering frames.
    pub commands: u64,
    /// Why the run did not end well, if known.
    pub complaint: Option<String>,
}

/// A simulated boat with the bridge on board.
pub struct ClosedLoop {
    sitl: Sitl,
    bridge: Bridge,
    /// How long the bridge's bytes are under way, and those that are.
    delay: Duration,
    under_way: VecDeque<(Duration, Vec<u8>)>,
    recorder: RunRecorder,
    now: Duration,
    loops: u32,
    last_problem: Option<String>,
}

impl ClosedLoop {
    /// Joins the two; `home` is the simulated boat's.
    pub fn new(sitl: Sitl, bridge: Bridge, home: Geodetic) -> Self {
        Self {
            sitl,
            bridge,
            delay: Duration::ZERO,
            under_way: VecDeque::new(),
            recorder: RunRecorder::new(home),
            now: Duration::ZERO,
            loops: 0,
            last_problem: None,
        }
    }

    /// Bytes of the bridge reach the boat only after `delay`: commands act late, answers come late.
    #[must_use]
    pub fn with_delay(mut self, delay: Duration) -> Self {
        self.delay = delay;
        self
    }

    /// Keeps a log of everything received and sent. Simulated time starts at the Unix epoch: the log must not
    /// depend on the day it was made.
    pub fn keep_journal(&mut self) {
        self.bridge.keep_journal(0);
    }

    /// Runs until the mission is complete, the bridge gives up, or `limit` of simulated time has passed.
    pub fn run(&mut self, limit: Duration) -> Outcome {
        while self.now < limit {
            self.step();
            let state = self.bridge.status().state;
            if matches!(state, State::Finished | State::Stopped)
                || self.bridge.refusal().is_some()
                || self.sitl.is_scenario_over()
            {
                break;
            }
        }
        self.outcome()
    }

    /// One loop of the autopilot.
    pub fn step(&mut self) {
        if self.loops == 0 {
            self.sitl.link_up(LINK);
            self.bridge.link_up(Duration::ZERO, LINK);
        }
        self.now += LOOP;
        self.loops += 1;
        self.sitl.advance(self.now);
        while let Some((_, bytes)) = self.sitl.poll_transmit() {
            self.bridge.on_bytes(self.now, LINK, &bytes, false);
        }
        self.bridge.on_tick(self.now);
        while let Some((_, bytes)) = self.bridge.poll_transmit() {
            self.under_way.push_back((self.now + self.delay, bytes));
        }
        while self.under_way.front().is_some_and(|(due, _)| *due <= self.now) {
            if let Some((_, bytes)) = self.under_way.pop_front() {
                self.sitl.on_bytes(LINK, &bytes);
            }
        }
        while let Some(event) = self.bridge.poll_event() {
            self.recorder.on_event(self.now.as_secs_f64(), &event);
            if event.severity <= helmlink_wire::enums::MAV_SEVERITY_WARNING {
                self.last_problem = Some(event.text);
            }
        }
        if self.loops.is_multiple_of(LOOPS_PER_SAMPLE) {
            self.recorder.sample(self.now.as_secs_f64(), &self.sitl, &self.bridge);
        }
    }

    /// The figures so far.
    pub fn outcome(&self) -> Outcome {
        let completed = self.bridge.status().state == State::Finished;
        let (commands_sha256, commands) = self.bridge.commands_digest();
        Outcome {
            completed,
            simulated_s: self.now.as_secs_f64(),
            score: self.recorder.score(),
            commands_sha256,
            commands,
            complaint: self.last_problem.clone().filter(|_| !completed),
        }
    }

    /// The simulated boat.
    pub fn sitl(&self) -> &Sitl {
        &self.sitl
    }

    /// The simulated boat, to change something about it.
    pub fn sitl_mut(&mut self) -> &mut Sitl {
        &mut self.sitl
    }

    /// The bridge.
    pub fn bridge(&self) -> &Bridge {
        &self.bridge
    }

    /// The bridge, to ask something of it.
    pub fn bridge_mut(&mut self) -> &mut Bridge {
        &mut self.bridge
    }

    /// Simulated time since the start.
    pub fn now(&self) -> Duration {
        self.now
    }

    /// What was recorded of the run, and the log of all frames where the bridge kept one.
    pub fn into_recorder(mut self) -> (RunRecorder, Vec<u8>) {
        let mut journal = self.bridge.take_journal();
        journal.extend(self.bridge.finish_journal());
        (self.recorder, journal)
    }
}
