//! `helmlink replay --proof`.

use std::time::Instant;

use serde::Serialize;

use super::{LogFiles, ReplayArgs, check_digest};
use crate::app::console;
use crate::app::failure::Failure;
use crate::replay::proof::{Proof, prove};
use crate::replay::recording::{Recording, RecordingError};

/// What `--proof --json` prints.
#[derive(Debug, Serialize)]
struct Report {
    log: String,
    recorded_by: String,
    holds: bool,
    calls: u64,
    frames: u64,
    commands: u64,
    steps: u64,
    duration_s: f64,
    driven_s: f64,
    commands_sha256: String,
    realtime_factor: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    difference: Option<String>,
}

pub(super) fn run(args: &ReplayArgs, files: &LogFiles) -> Result<(), Failure> {
    let started = Instant::now();
    let proof = Recording::open(files.open()).and_then(prove).map_err(|error| match error {
        RecordingError::NotARecording | RecordingError::Header(_) | RecordingError::Io(_) => {
            Failure::usage(format!("{}: {error}", files.shown()))
        }
        _ => Failure::failed(format!("nothing is proven: {error}")),
    })?;
    let report = report(&proof, files, started.elapsed().as_secs_f64());
    if args.common.json {
        console::say(&serde_json::to_string_pretty(&report).map_err(Failure::failed)?);
    } else {
        console::say(&text(&report));
    }
    if let Some(difference) = &proof.difference {
        return Err(Failure::failed(format!("the replay is not the same: {}", difference.text())));
    }
    if proof.statistics.crc_errors > 0 {
        return Err(Failure::failed("the log is damaged: what is there is the same, the rest is not proven"));
    }
    check_digest(args.expect.as_deref(), &proof.replayed_sha256)
}

fn report(proof: &Proof, files: &LogFiles, wall_s: f64) -> Report {
    Report {
        log: files.name(),
        recorded_by: proof.recorded_by.clone(),
        holds: proof.holds(),
        calls: proof.calls,
        frames: proof.frames,
        commands: proof.commands,
        steps: proof.steps,
        duration_s: proof.duration.as_secs_f64(),
        driven_s: proof.driven_s,
        commands_sha256: proof.replayed_sha256.clone(),
        realtime_factor: proof.driven_s / wall_s.max(1e-9),
        difference: proof.difference.as_ref().map(|difference| difference.text()),
    }
}

fn text(report: &Report) -> String {
    let verdict = if report.holds { "every frame is the same" } else { "NOT the same" };
    format!(
        "{}: {verdict}\n  recorded by helmlink {}\n  frames sent         {} ({} of them steer)\n  calls, steps        {}, {}\n  \
         driven              {:.1} s of vehicle time\n  commands SHA-256    {}\n  speed of replay     {:.0} × real time",
        report.log,
        report.recorded_by,
        report.frames,
        report.commands,
        report.calls,
        report.steps,
        report.driven_s,
        report.commands_sha256,
        report.realtime_factor
    )
}
