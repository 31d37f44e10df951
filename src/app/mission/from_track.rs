//! `helmlink mission from-track`: the driven track of a log as a mission.

use std::path::PathBuf;

use clap::Args;
use helmlink_mission::geodesy::Geodetic;
use helmlink_mission::plan::Plan;
use helmlink_mission::track::{Fix, TrackSettings, mission_of_track};
use helmlink_wire::Message;
use helmlink_wire::enums;
use helmlink_wire::tlog::TlogReader;
use serde_json::json;

use super::super::cli::Common;
use super::super::console;
use super::super::failure::Failure;
use super::super::ranges::{LogS, StopS, SystemId, ToleranceM};
use super::super::replay::LogFiles;
use super::convert;

/// `helmlink mission from-track`.
#[derive(Debug, Clone, Args)]
#[command(after_help = "\
Examples:
  helmlink mission from-track log.tlog -o again.waypoints
  helmlink mission from-track log.tlog --from 60 --to 600 --tolerance 0.5 -o part.plan

A boat driven by hand once can so repeat it: the mission has the track's corners within the tolerance,
its speeds, and a hold wherever the boat stood still. Times are those of the vehicle's own clock.")]
pub struct FromTrackArgs {
    /// The telemetry log (.tlog), or all files of one recording in order, or the folder that holds them
    #[arg(required = true, value_name = "LOG")]
    pub log: Vec<PathBuf>,
    /// The file to write; standard output (QGC WPL 110) if not given
    #[arg(short, long, value_name = "FILE")]
    pub output: Option<PathBuf>,
    /// The format of the file, if its ending does not say: wpl, plan, geojson, gpx, kml, kmz or csv
    #[arg(long, value_name = "FORMAT")]
    pub format: Option<String>,
    /// How far the track may be from the mission's legs, m
    #[arg(long, default_value = "1", value_name = "M")]
    pub tolerance: ToleranceM,
    /// Standing still at least so long becomes a hold, s; 0 leaves stops out
    #[arg(long, default_value = "10", value_name = "S")]
    pub stops: StopS,
    /// Begin so many seconds after the first position
    #[arg(long, default_value = "0", value_name = "S")]
    pub from: LogS,
    /// End so many seconds after the first position
    #[arg(long, value_name = "S")]
    pub to: Option<LogS>,
    /// The vehicle's MAVLink system id; the first one with a position if not given
    #[arg(long, value_name = "ID")]
    pub system: Option<SystemId>,
    #[command(flatten)]
    #[allow(missing_docs)]
    pub common: Common,
}

pub(super) fn run(args: &FromTrackArgs) -> Result<(), Failure> {
    let format = convert::target(args.output.as_deref(), args.format.as_deref())?;
    let files = LogFiles::find(&args.log)?;
    let fixes = read_track(&files, args.system.map(u8::from))?;
    let first_s = fixes.first().map_or(0.0, |fix| fix.time_s);
    let until_s = args.to.map_or(f64::INFINITY, f64::from);
    let within = |fix: &Fix| (*args.from..=until_s).contains(&(fix.time_s - first_s));
    let chosen: Vec<Fix> = fixes.iter().copied().filter(within).collect();
    let settings = TrackSettings {
        tolerance_m: *args.tolerance,
        stop_s: Some(*args.stops).filter(|stop_s| *stop_s > 0.0),
    };
    let made = mission_of_track(&chosen, &settings).ok_or_else(|| {
        let what =
            if fixes.is_empty() { "holds no position of a vehicle" } else { "shows no boat that moves" };
        Failure::failed(format!("{} {what} (see --system, --from and --to)", files.shown()))
    })?;
    let plan = Plan { mission: made.mission, ..Plan::default() };
    let losses = convert::write(&plan, format, args.output.as_deref(), args.common.json)?;
    let summary = format!(
        "{} positions, {:.0} m in {:.0} s, became {} items; nothing is farther than {:.2} m from the mission's legs",
        chosen.len(),
        made.length_m,
        made.duration_s,
        plan.mission.items.len(),
        made.deviation_m
    );
    if args.common.json {
        let losses: Vec<String> = losses.iter().map(ToString::to_string).collect();
        let report = json!({
            "log": files.shown(), "output": args.output, "format": format.name(), "positions": chosen.len(),
            "items": plan.mission.items.len(), "length_m": made.length_m, "duration_s": made.duration_s,
            "tolerance_m": *args.tolerance, "deviation_m": made.deviation_m, "losses": losses,
        });
        console::say(&report.to_string());
    } else {
        tracing::info!("{summary}");
    }
    Ok(())
}

/// Where a vehicle was, by its own clock.
pub(super) fn read_track(files: &LogFiles, system: Option<u8>) -> Result<Vec<Fix>, Failure> {
    let fault = |error: std::io::Error| Failure::usage(format!("cannot read {}: {error}", files.shown()));
    let mut reader = TlogReader::new(files.open());
    let mut system = system;
    let mut clock = BootClock::default();
    let mut fixes = Vec::new();
    while let Some(record) = reader.next_record().map_err(fault)? {
        let from = record.frame.identity();
        if from.component != enums::MAV_COMP_ID_AUTOPILOT1 {
            continue;
        }
        let Ok(Message::GLOBAL_POSITION_INT(data)) = record.frame.decode() else { continue };
        let position = Geodetic::from_e7(data.lat, data.lon);
        if !position.is_valid() || *system.get_or_insert(from.system) != from.system {
            continue;
        }
        let speed_mps = f64::from(data.vx).hypot(f64::from(data.vy)) * 0.01;
        fixes.push(Fix { time_s: clock.time_s(data.time_boot_ms), position, speed_mps });
    }
    Ok(fixes)
}

/// The vehicle's clock, which begins anew when the vehicle restarts.
#[derive(Debug, Default)]
struct BootClock {
    last_ms: Option<u32>,
    before_s: f64,
}

impl BootClock {
    /// A little disorder is the link's; more is a restart.
    const DISORDER_MS: u32 = 2000;

    fn time_s(&mut self, boot_ms: u32) -> f64 {
        let last_ms = self.last_ms.unwrap_or(boot_ms);
        if boot_ms.saturating_add(Self::DISORDER_MS) < last_ms {
            self.before_s += f64::from(last_ms) * 1e-3;
            self.last_ms = Some(boot_ms);
        } else {
            self.last_ms = Some(last_ms.max(boot_ms));
        }
        self.before_s + f64::from(boot_ms) * 1e-3
    }
}
