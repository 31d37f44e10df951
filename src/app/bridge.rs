//! `helmlink bridge`: steers a boat through its flight controller.

mod figures;
mod lateness;
mod links;
mod memory;
mod operation;
mod process;
mod service_manager;
mod signing;

use std::path::Path;
use std::time::Duration;

use clap::Args;
use helmlink_wire::Identity;
use tokio_util::task::AbortOnDropHandle;

use self::links::LinkArgs;
use self::memory::Memory;
use self::operation::{Operation, OperationArgs};
use self::signing::SigningStore;
use super::boat;
use super::cli::Common;
use super::console;
use super::edge::{self, Edge, Seen, unless_it_panics};
use super::failure::Failure;
use super::guarded::Guarded;
use super::interrupt::interrupted;
use super::mission;
use super::ranges::{self, RateHz, SpeedMps, SystemId, WaitS};
use super::recorder::{RecordArgs, Recorder};
use super::state_dir::StateDirArgs;
use super::trial;
use crate::bridge::{Bridge, BridgeSettings, MissionSource, TICK};
use crate::control::Boat;
use crate::link::LinkUrl;
use crate::pilot::failsafe::{FailsafeOption, FailsafeSettings};
use crate::pilot::supervisor::{Request, State};
use crate::vehicle::{Mode, OutputKind};

/// `helmlink bridge`.
#[derive(Debug, Clone, Args)]
#[command(after_help = "\
Examples:
  helmlink bridge --connect serial:/dev/ttyAMA0:921600 --engage-mode GUIDED --output guided
  helmlink bridge --connect tcp:127.0.0.1:5760 --engage
  helmlink bridge --connect udpin:127.0.0.1:14550 --shadow --mission survey.waypoints
  helmlink bridge --connect serial:/dev/ttyAMA0:921600 --gcs udpin:0.0.0.0:14550 --signing-key key --sign gcs

With --json, a line on standard output tells each change of state, with the reason.
Without --engage, --engage-mode or a command from a ground station (MISSION_START or DO_PAUSE_CONTINUE
to component 191) the bridge only watches. It never arms the motors unless --arm is given.
Ctrl-C: motors neutral, then the boat is let go.")]
pub struct BridgeArgs {
    /// The flight controller: tcp:HOST:PORT, udpin:HOST:PORT, udpout:HOST:PORT or serial:DEVICE:BAUD
    #[arg(long, value_name = "URL", required_unless_present = "config")]
    pub connect: Option<LinkUrl>,
    /// The mission: `vehicle` for the one on the flight controller, or a file
    #[arg(long, default_value = "vehicle", value_name = "vehicle|FILE")]
    pub mission: String,
    /// By which messages the boat is steered
    #[arg(
        long,
        default_value = "rc-override",
        value_name = "rc-override|manual-control|guided|guided-velocity"
    )]
    pub output: OutputKind,
    /// The boat that the controller is tuned for: a name, or a boat file as `helmlink boat` writes it
    #[arg(long, default_value = "otter", value_parser = ranges::boat)]
    pub boat: String,
    /// Speed over ground, m/s; the mission's own, or the vehicle's WP_SPEED, if not given
    #[arg(long, value_name = "M/S")]
    pub speed: Option<SpeedMps>,
    /// Drive as soon as everything is ready and the boat is armed
    #[arg(long)]
    pub engage: bool,
    /// Go on where a run that was broken off has been, if mission, boat and mode are as they were
    #[arg(long)]
    pub resume: bool,
    /// Limit and action of a failsafe (repeatable): KEY=LIMIT, KEY=ACTION or KEY=LIMIT:ACTION; see docs/safety.md
    #[arg(long, value_name = "KEY=…")]
    pub failsafe: Vec<FailsafeOption>,
    /// Drive when the pilot changes into this mode
    #[arg(long, value_name = "MODE")]
    pub engage_mode: Option<Mode>,
    /// Arm the motors when engaging
    #[arg(long)]
    pub arm: bool,
    /// The mode to leave the boat in when the mission is complete
    #[arg(long, default_value = "HOLD", value_name = "MODE")]
    pub end_mode: Mode,
    /// Compute and log what would be commanded, but send nothing at all
    #[arg(long)]
    pub shadow: bool,
    #[command(flatten)]
    #[allow(missing_docs)]
    pub recording: RecordArgs,
    /// The control loop's rate, Hz
    #[arg(long, default_value = "25", value_name = "HZ")]
    pub rate: RateHz,
    /// The ground station's system id that overrides are sent with: the flight controller's SYSID_MYGCS
    #[arg(long, default_value = "255", value_name = "ID")]
    pub gcs_system: SystemId,
    /// Give up when no heartbeat has come for this many seconds after the start; 0 waits for ever
    #[arg(long, default_value = "10", value_name = "S")]
    pub wait: WaitS,
    /// End when the mission is complete
    #[arg(long)]
    pub once: bool,
    #[command(flatten)]
    #[allow(missing_docs)]
    pub links: LinkArgs,
    #[command(flatten)]
    #[allow(missing_docs)]
    pub state: StateDirArgs,
    #[command(flatten)]
    #[allow(missing_docs)]
    pub operation: OperationArgs,
    #[command(flatten)]
    #[allow(missing_docs)]
    pub common: Common,
}

/// After Ctrl-C the bridge has this long to stop the boat and let go.
const STOPPING: Duration = Duration::from_secs(5);

pub(super) fn run(args: &BridgeArgs) -> Result<(), Failure> {
    run_for(args, boat::load(&args.boat)?)
}

/// Runs with this boat, whatever the options call it.
pub(super) fn run_for(args: &BridgeArgs, boat: Boat) -> Result<(), Failure> {
    let url = args.connect.clone().ok_or_else(|| {
        Failure::usage("say where the flight controller is: --connect tcp:HOST:PORT, udpin:…, udpout:… or serial:DEVICE:BAUD")
    })?;
    let mut settings = settings(args, boat)?;
    let memory = remember(args, &url, &mut settings)?;
    let signing = args.links.signing(&args.state)?;
    edge::block_on_task(drive(args.clone(), url, settings, memory, signing))?
}

/// What outlives a run, put into the settings. A shadow keeps nothing.
fn remember(
    args: &BridgeArgs,
    url: &LinkUrl,
    settings: &mut BridgeSettings,
) -> Result<Option<Memory>, Failure> {
    if args.shadow {
        return Ok(None);
    }
    let memory = Memory::open(&args.state.folder()?, url);
    settings.parameters = memory.parameters()?;
    if args.resume {
        settings.resume = memory.resume_point()?;
    }
    Ok(Some(memory))
}

/// The settings that the options ask for.
fn settings(args: &BridgeArgs, boat: Boat) -> Result<BridgeSettings, Failure> {
    trial::check_speed(args.speed.map(f64::from), &boat)?;
    let mission = match args.mission.as_str() {
        "vehicle" if args.shadow => {
            return Err(Failure::usage(
                "--shadow sends nothing, so it cannot ask the vehicle for its mission: give --mission FILE",
            ));
        }
        "vehicle" => MissionSource::Vehicle,
        file => MissionSource::Given(mission::load(Path::new(file))?.mission),
    };
    let mut failsafes = FailsafeSettings::default();
    for FailsafeOption(failsafe, rule) in &args.failsafe {
        failsafes.set(*failsafe, *rule).map_err(Failure::usage)?;
    }
    Ok(BridgeSettings {
        failsafes,
        mission,
        output: args.output,
        speed_mps: args.speed.map(f64::from),
        control_interval_s: 1.0 / *args.rate,
        engage: args.engage,
        engage_mode: args.engage_mode,
        may_arm: args.arm,
        end_mode: args.end_mode,
        shadow: args.shadow,
        ground_station_system: *args.gcs_system,
        ..BridgeSettings::new(boat)
    })
}

async fn drive(
    args: BridgeArgs,
    url: LinkUrl,
    settings: BridgeSettings,
    mut memory: Option<Memory>,
    signing: Option<SigningStore>,
) -> Result<(), Failure> {
    let interval = Duration::from_secs_f64(settings.control_interval_s);
    let mut operation = Operation::start(&args.operation, interval).await?;
    let mut bridge = Bridge::new(settings);
    let mut log = start_recording(&args, &mut bridge)?;
    let (guarded, hub) = args.links.open(&url, bridge, signing.as_ref()).await?;
    operation.keep(signing);
    let mut edge = Edge::new(guarded, hub, TICK);
    operation.ready();
    let mut watch = Watch::new(&args);
    let interrupt = AbortOnDropHandle::new(tokio::spawn(interrupted()));
    let ending = loop {
        let Some(seen) = unless_it_panics(edge.turn()).await else {
            edge.party.abandon();
            break Err(Failure::failed("an error in helmlink itself, told above: the boat has been let go"));
        };
        watch.look(seen);
        say_events(&mut edge);
        watch.note_changes(&mut edge.party, args.common.json);
        operation.after_turn(&edge);
        // What follows has time until the next tick, and need not be done for every datagram.
        if !edge.has_ticked() {
            continue;
        }
        write_log(&mut edge, &mut log);
        if let Some(memory) = &mut memory {
            memory.keep(edge.now(), &mut edge.party);
        }
        operation.after_tick(&edge);
        let now = edge.now();
        if let Some(health) = operation.health(now) {
            edge.party.set_health(now, health);
        }
        if interrupt.is_finished() {
            break Ok(());
        }
        if let Some(ending) = watch.ending(&edge, &url) {
            break ending;
        }
    };
    if !edge.party.is_abandoned() {
        stop(&mut edge).await;
        watch.note_changes(&mut edge.party, args.common.json);
    }
    if let Some(memory) = &mut memory {
        memory.keep(edge.now(), &mut edge.party);
    }
    operation.end(&edge);
    finish_recording(&mut edge, log);
    edge.close().await;
    ending
}

/// The bridge with its gate, its links and its clock.
type Live = Edge<Guarded<Bridge>>;

/// Decides when the command ends by itself.
struct Watch {
    once: bool,
    wait: Duration,
    found: Option<Identity>,
    /// A mission has been completed, whatever has happened since.
    finished: bool,
}

impl Watch {
    fn new(args: &BridgeArgs) -> Self {
        let wait = Duration::from_secs_f64(*args.wait);
        let wait = if wait.is_zero() { Duration::MAX } else { wait };
        Self { once: args.once, wait, found: None, finished: false }
    }

    /// Looks at every change of state, and tells programs of it where they want to hear.
    fn note_changes(&mut self, bridge: &mut Bridge, for_programs: bool) {
        while let Some(change) = bridge.poll_change() {
            self.finished |= change.state == State::Finished;
            if for_programs {
                console::say(&change.to_json().to_string());
            }
        }
    }

    fn look(&self, seen: Option<Seen>) {
        match seen {
            Some(Seen::Up(peer)) => tracing::info!("link up: {peer}"),
            Some(Seen::Down(reason)) => tracing::warn!("link down: {reason}"),
            None => {}
        }
    }

    fn ending(&mut self, edge: &Live, url: &LinkUrl) -> Option<Result<(), Failure>> {
        self.found = self.found.or(edge.party.status().vehicle);
        if let Some(refusal) = edge.party.refusal() {
            return Some(Err(Failure::usage(refusal)));
        }
        if self.found.is_none() && edge.now() > self.wait {
            let seconds = self.wait.as_secs_f64();
            return Some(Err(Failure::no_link(format!(
                "no heartbeat of a flight controller on {url} for {seconds} s: check that it is powered, the \
                 address and the baud rate, and that the port speaks MAVLink 2 (SERIALn_PROTOCOL 2); --wait 0 waits for ever"
            ))));
        }
        (self.once && self.finished).then_some(Ok(()))
    }
}

/// Stops the boat, lets go, and waits until that is done.
async fn stop(edge: &mut Live) {
    let now = edge.now();
    edge.party.request(now, Request::Stop).ok();
    edge.flush();
    let deadline = now + STOPPING;
    while edge.party.status().state != State::Stopped && edge.now() < deadline {
        edge.turn().await;
    }
    say_events(edge);
    edge.flush();
}

fn say_events(edge: &mut Live) {
    if let Some(news) = edge.party.gate.take_news() {
        tracing::warn!("{news}");
    }
    while let Some(event) = edge.party.poll_event() {
        console::log(&event);
    }
}

/// Begins to record where the user wants that.
fn start_recording(args: &BridgeArgs, bridge: &mut Bridge) -> Result<Option<Recorder>, Failure> {
    args.recording.start(|start_us| {
        bridge.keep_journal(start_us);
        bridge.journal_header()
    })
}

/// Hands what has been recorded to the disk.
fn write_log(edge: &mut Live, recorder: &mut Option<Recorder>) {
    let Some(recorder) = recorder else { return };
    recorder.write(edge.party.take_journal());
    if let Some(failing) = recorder.poll_failing() {
        let now = edge.now();
        edge.party.set_recording_failed(now, failing);
    }
}

/// Ends the recording, and makes its report: the boat has been let go, so that may take its time.
fn finish_recording(edge: &mut Live, recorder: Option<Recorder>) {
    let Some(mut recorder) = recorder else { return };
    recorder.write(edge.party.take_journal());
    recorder.write(edge.party.finish_journal());
    recorder.finish_with_report();
}
