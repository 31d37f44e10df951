//! `helmlink replay`: what would the controller have commanded?

use std::collections::BTreeMap;
use std::fs::File;
use std::io::BufWriter;
use std::path::Path;

use helmlink_mission::geodesy::Geodetic;
use helmlink_mission::route::Route;

use super::engine::{Engine, Wishes};
use super::{LogFiles, Outcome, ReplayArgs, check_digest};
use crate::app::failure::Failure;
use crate::app::log_report::{self, LogReport};
use crate::replay::export::Exporting;
use crate::replay::export::commands::CommandLog;
use crate::replay::export::foxglove::McapExport;
use crate::replay::export::rows::{RowFormat, Rows};
use crate::replay::picture::Side;
use crate::replay::what_if::{Sink, WhatIfSettings};

pub(super) fn run(args: &ReplayArgs, files: &LogFiles) -> Result<(), Failure> {
    let mut engine = Engine::scan(files.clone(), args.system.map(u8::from))?;
    let settings = engine.settings(&wishes(args), args.window.window())?;
    let mut exports = Vec::new();
    for path in &args.out {
        exports.push(export(path)?);
    }
    if let Some(path) = &args.mcap {
        exports.push(mcap(path, &engine, &settings)?);
    }
    let mut sinks: Vec<&mut dyn Sink> = exports.iter_mut().map(|export| export as &mut dyn Sink).collect();
    let outcome = engine.run(settings.clone(), Side::Replayed, &mut sinks)?;
    finish(exports)?;
    let report = LogReport::new(&engine, &settings, &outcome);
    if !args.no_report && outcome.result.steps > 0 {
        let panels = outcome.picture.panels();
        log_report::write(&args.report, &report, &outcome.what_if, &panels, Side::Replayed)?;
        tracing::info!("report in {}", args.report.display());
    }
    report.say(Side::Replayed, args.common.json)?;
    check_driven(&engine, &outcome, args)?;
    check_digest(args.expect.as_deref(), &outcome.result.commands_sha256)
}

/// What the user has said.
pub(super) fn wishes(args: &ReplayArgs) -> Wishes<'_> {
    Wishes {
        boat: args.boat.as_deref(),
        mission: args.mission.as_deref(),
        controller: args.controller,
        output: args.output,
        speed_mps: args.speed.map(f64::from),
    }
}

/// Nothing replayed is no success.
pub(super) fn check_driven(engine: &Engine, outcome: &Outcome, args: &ReplayArgs) -> Result<(), Failure> {
    if outcome.result.steps > 0 {
        return Ok(());
    }
    let has_mission = args.mission.is_some() || outcome.result.waypoints > 0;
    Err(if has_mission {
        Failure::failed(
            "the controller was never asked: in this log the boat was never armed in AUTO or GUIDED, nor steered by a \
             companion; --while armed or --while any takes other times too",
        )
    } else {
        Failure::usage(format!(
            "{}: no mission to replay: give one with --mission FILE",
            engine.files().shown()
        ))
    })
}

/// An export into a file whose name says the format.
///
/// # Errors
/// Another ending, or a file that cannot be made.
pub(in crate::app) fn export(path: &Path) -> Result<Exporting, Failure> {
    let extension = path.extension().and_then(|extension| extension.to_str()).unwrap_or_default();
    let unknown = || {
        Failure::usage(format!(
            "{}: the name must end in .tlog, .csv or .json (one object a line), or use --mcap FILE",
            path.display()
        ))
    };
    if !["tlog", "csv", "json", "jsonl"].contains(&extension) {
        return Err(unknown());
    }
    let out = create(path)?;
    Ok(Exporting::new(
        path.display().to_string(),
        match extension {
            "tlog" => Box::new(CommandLog::new(out)),
            "csv" => Box::new(Rows::new(out, RowFormat::Csv)),
            _ => Box::new(Rows::new(out, RowFormat::JsonLines)),
        },
    ))
}

/// An MCAP file of a log.
///
/// # Errors
/// A file that cannot be made.
pub(in crate::app) fn mcap(
    path: &Path,
    engine: &Engine,
    settings: &WhatIfSettings,
) -> Result<Exporting, Failure> {
    let fault = |error| Failure::usage(format!("cannot write {}: {error}", path.display()));
    let parameters: BTreeMap<String, f64> = engine
        .scan
        .parameters
        .iter()
        .filter_map(|data| Some((data.param_id.to_str().ok()?.to_owned(), f64::from(data.param_value))))
        .collect();
    let of_log = engine.scan.missions.last().map(|transferred| &transferred.mission);
    let mission: Vec<Geodetic> = settings
        .mission
        .as_ref()
        .or(of_log)
        .and_then(|mission| Route::from_mission(mission).ok())
        .map(|route| route.waypoints.iter().map(|waypoint| waypoint.position).collect())
        .unwrap_or_default();
    let export = McapExport::new(create(path)?, &parameters, &mission).map_err(fault)?;
    Ok(Exporting::new(path.display().to_string(), Box::new(export)))
}

fn create(path: &Path) -> Result<BufWriter<File>, Failure> {
    File::create(path)
        .map(BufWriter::new)
        .map_err(|error| Failure::usage(format!("cannot write {}: {error}", path.display())))
}

/// Completes all files.
///
/// # Errors
/// The first that could not be written.
pub(in crate::app) fn finish(exports: Vec<Exporting>) -> Result<(), Failure> {
    for export in exports {
        export.finish().map_err(|(name, error)| Failure::failed(format!("cannot write {name}: {error}")))?;
    }
    Ok(())
}
