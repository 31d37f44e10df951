//! Makes the recorded calls again and compares every frame with the recorded one.

use std::collections::VecDeque;
use std::fmt::Write as _;
use std::io::Read;
use std::time::Duration;

use helmlink_wire::{Frame, LinkId, LinkStatistics};
use sha2::{Digest, Sha256};

use super::recording::{Played, Recording, RecordingError};
use crate::bridge::Bridge;
use crate::record::ControlState;
use crate::record::state::VALUES;

/// What replaying a recording has shown.
#[derive(Debug)]
pub struct Proof {
    /// The version of helmlink that recorded.
    pub recorded_by: String,
    /// Calls made again.
    pub calls: u64,
    /// Frames that were the same, byte for byte.
    pub frames: u64,
    /// How many of them steer the boat.
    pub commands: u64,
    /// Control steps made.
    pub steps: u64,
    /// Time from the first call to the last, by the recording bridge's clock.
    pub duration: Duration,
    /// Vehicle time from the first control step to the last, seconds.
    pub driven_s: f64,
    /// SHA-256 of every recorded steering frame, in order.
    pub recorded_sha256: String,
    /// SHA-256 of every replayed one.
    pub replayed_sha256: String,
    /// The first difference, if there is one; the replay ends there.
    pub difference: Option<Box<Difference>>,
    /// What the log holds and lacks.
    pub statistics: LinkStatistics,
}

/// The first frame that was not the same.
#[derive(Debug)]
pub struct Difference {
    /// Number of the frame among all that were sent, from 1.
    pub number: u64,
    /// When it was sent, by the recording bridge's clock.
    pub now: Duration,
    /// Link and frame in the recording; none when only the replay sends one.
    pub recorded: Option<(LinkId, Vec<u8>)>,
    /// Link and frame in the replay; none when only the recording has one.
    pub replayed: Option<(LinkId, Vec<u8>)>,
    /// The controller's last step in the recording.
    pub recorded_state: Option<ControlState>,
    /// The controller's last step in the replay.
    pub replayed_state: Option<ControlState>,
}

/// Replays a recording.
///
/// # Errors
/// The log is no recording, or is damaged: nothing is proven then.
pub fn prove<R: Read>(recording: Recording<R>) -> Result<Proof, RecordingError> {
    Replay::new(recording).run()
}

struct Replay<R> {
    recording: Recording<R>,
    bridge: Bridge,
    /// What the replayed bridge has sent and the recording has not been asked for yet.
    sent: VecDeque<(LinkId, Vec<u8>)>,
    recorded_commands: Sha256,
    recorded_state: Option<ControlState>,
    first_step_s: Option<f64>,
    proof: Proof,
}

impl<R: Read> Replay<R> {
    fn new(recording: Recording<R>) -> Self {
        let header = recording.header();
        let proof = Proof {
            recorded_by: header.helmlink.clone(),
            calls: 0,
            frames: 0,
            commands: 0,
            steps: 0,
            duration: Duration::ZERO,
            driven_s: 0.0,
            recorded_sha256: String::new(),
            replayed_sha256: String::new(),
            difference: None,
            statistics: LinkStatistics::default(),
        };
        let mut bridge = Bridge::new(header.settings.clone());
        bridge.keep_own();
        Self {
            bridge,
            recording,
            sent: VecDeque::new(),
            recorded_commands: Sha256::new(),
            recorded_state: None,
            first_step_s: None,
            proof,
        }
    }

    fn run(mut self) -> Result<Proof, RecordingError> {
        while self.proof.difference.is_none() {
            match self.recording.next_played()? {
                Some(Played::Call(now, input)) => {
                    self.expect_nothing_more();
                    if self.proof.difference.is_none() {
                        self.proof.duration = now;
                        self.proof.calls += 1;
                        input.apply(now, &mut self.bridge);
                        while self.bridge.poll_transmit().is_some() {}
                        while let Some(frame) = self.bridge.poll_own() {
                            self.sent.push_back(frame);
                        }
                        while self.bridge.poll_event().is_some() {}
                    }
                }
                Some(Played::Sent { link, frame, steers }) => self.compare(link, frame, steers),
                Some(Played::Stepped(state)) => {
                    let first_s = *self.first_step_s.get_or_insert(state.boot_s);
                    self.proof.driven_s = state.boot_s - first_s;
                    self.recorded_state = Some(*state);
                }
                None => break,
            }
        }
        self.proof.steps = self.bridge.status().steps;
        self.proof.statistics = *self.recording.statistics();
        self.proof.recorded_sha256 = hex(&self.recorded_commands.finalize());
        self.proof.replayed_sha256 = self.bridge.commands_digest().0;
        Ok(self.proof)
    }

    fn compare(&mut self, link: LinkId, frame: Vec<u8>, steers: bool) {
        if steers {
            self.recorded_commands.update(&frame);
        }
        match self.sent.pop_front() {
            Some(sent) if sent == (link, frame.clone()) => {
                self.proof.frames += 1;
                self.proof.commands += u64::from(steers);
            }
            sent => self.differ(Some((link, frame)), sent),
        }
    }

    /// Before the next call everything must have been compared.
    fn expect_nothing_more(&mut self) {
        if let Some(extra) = self.sent.pop_front() {
            self.differ(None, Some(extra));
        }
    }

    fn differ(&mut self, recorded: Option<(LinkId, Vec<u8>)>, replayed: Option<(LinkId, Vec<u8>)>) {
        self.proof.difference = Some(Box::new(Difference {
            number: self.proof.frames + 1,
            now: self.proof.duration,
            recorded,
            replayed,
            recorded_state: self.recorded_state,
            replayed_state: self.bridge.thought(),
        }));
    }
}

impl Proof {
    /// Every frame was the same.
    pub fn holds(&self) -> bool {
        self.difference.is_none()
    }
}

impl Difference {
    /// What differs, in a few lines.
    pub fn text(&self) -> String {
        let mut text = format!("frame {} at {:.3} s differs:\n", self.number, self.now.as_secs_f64());
        for (side, sent) in [("recorded", &self.recorded), ("replayed", &self.replayed)] {
            let shown =
                sent.as_ref().map_or_else(|| "nothing".to_owned(), |(link, frame)| show(*link, frame));
            let _ = writeln!(text, "  {side}: {shown}");
        }
        let (Some(recorded), Some(replayed)) = (&self.recorded_state, &self.replayed_state) else {
            text.push_str("  the controller had not made a step on both sides yet");
            return text;
        };
        let _ = writeln!(
            text,
            "  the controller's last step, at vehicle time {:.3} s recorded and {:.3} s replayed:",
            recorded.boot_s, replayed.boot_s
        );
        for ((name, unit, meaning), (a, b)) in
            VALUES.iter().zip(recorded.values().into_iter().zip(replayed.values()))
        {
            let mark = if a.to_bits() == b.to_bits() { ' ' } else { '*' };
            let _ = writeln!(text, "  {mark} {name:<10} {a:>14.6} {b:>14.6} {unit:<6} {meaning}");
        }
        text.push_str("  (* marks what is not the same)");
        text
    }
}

fn show(link: LinkId, frame: &[u8]) -> String {
    let bytes = hex(frame);
    match Frame::parse(frame) {
        Ok(frame) => {
            let name = frame.name().unwrap_or("unknown message");
            let content = frame.decode().map(|message| format!("{message:?}")).unwrap_or_default();
            format!("link {} from {} {name} {bytes}\n      {content}", link.0, frame.identity())
        }
        Err(_) => bytes,
    }
}

/// Bytes as hexadecimal digits.
pub fn hex(bytes: &[u8]) -> String {
    bytes.iter().fold(String::new(), |mut text, byte| {
        let _ = write!(text, "{byte:02x}");
        text
    })
}
