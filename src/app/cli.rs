//! The command line: every option is defined here once; help, configuration files and defaults follow from it.

use std::path::PathBuf;

use clap::{ArgAction, Args, Parser, Subcommand, ValueEnum};

use crate::link::LinkUrl;
use crate::vehicle::{Mode, OutputKind};

/// Steers an uncrewed boat along its mission, or simulates one.
#[derive(Debug, Parser)]
#[command(name = "helmlink", version, about, max_term_width = 100, after_help = TOP_EXAMPLES)]
pub struct Cli {
    /// What to do.
    #[command(subcommand)]
    pub command: Command,
}

const TOP_EXAMPLES: &str = "\
Examples:
  helmlink demo                                     a boat drives a mission before your eyes
  helmlink sitl                                     the simulated boat, for any ground station
  helmlink bridge --connect tcp:127.0.0.1:5760      the bridge, on a simulated or a real boat
  helmlink simulate mission/plans/fossen-otter.waypoints --json

Exit codes: 0 done, 1 the job did not succeed, 2 wrong usage or input, 3 no link.";

/// The subcommands.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Start the built-in boat and the bridge, and drive a sample mission in sight
    Demo(Box<DemoArgs>),
    /// Steer a boat along its mission, through its flight controller
    Bridge(Box<BridgeArgs>),
    /// Run the simulated boat alone
    Sitl(Box<SitlArgs>),
    /// Drive a mission in simulation as fast as the machine allows, and report how well
    Simulate(Box<SimulateArgs>),
    /// Look at mission files
    #[command(subcommand)]
    Mission(MissionCommand),
}

/// Options that every subcommand has.
#[derive(Debug, Clone, Args)]
pub struct Common {
    /// Print one JSON object on standard output
    #[arg(long)]
    pub json: bool,
    /// Say more (repeat for still more); messages go to standard error
    #[arg(short, long, action = ArgAction::Count)]
    pub verbose: u8,
    /// Say only what went wrong
    #[arg(short, long)]
    pub quiet: bool,
    /// Read options from a TOML file; its tables are named after the subcommands
    #[arg(long, value_name = "FILE")]
    pub config: Option<PathBuf>,
    /// Print the merged settings and where each came from, then end without touching anything
    #[arg(long)]
    pub dry_run: bool,
}

/// The boat and the sea of a simulation.
#[derive(Debug, Clone, Args)]
pub struct WorldArgs {
    /// The boat: otter, monohull38, outboard or motorboat
    #[arg(long, default_value = "otter")]
    pub boat: String,
    /// The sea, scaled to the boat: calm, slight, moderate or rough
    #[arg(long, default_value = "calm")]
    pub sea: String,
    /// A steady current, m/s and the direction it flows TOWARD in degrees true, such as 0.3@30
    #[arg(long, value_name = "SPEED@TOWARD")]
    pub current: Option<String>,
    /// Wind, m/s and the direction it blows FROM, such as 6@270
    #[arg(long, value_name = "SPEED@FROM")]
    pub wind: Option<String>,
    /// Waves: significant height in m, peak period in s, direction they come FROM, such as 0.3:2.8@200
    #[arg(long, value_name = "HS:TP@FROM")]
    pub waves: Option<String>,
    /// How good the boat's sensors are: perfect, typical or poor
    #[arg(long, default_value = "typical")]
    pub sensors: String,
    /// Seed of everything random: the same seed gives the same run, bit for bit
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
    /// Where the boat starts: latitude, longitude and heading in degrees. If not given, at the mission's home
    /// with the bow toward the first waypoint, or in a harbour heading north
    #[arg(long, value_name = "LAT,LON[,HEADING]")]
    pub home: Option<String>,
}

/// `helmlink demo`.
#[derive(Debug, Clone, Args)]
#[command(after_help = "\
Example:
  helmlink demo --sea moderate --speedup 4 --report my-report

While it runs, connect a ground station to the address it prints. The boat exists only in this program.")]
pub struct DemoArgs {
    /// The mission to drive; a harbour survey that comes with helmlink if not given
    #[arg(long, value_name = "FILE")]
    pub mission: Option<PathBuf>,
    /// Speed over ground, m/s; the mission's own, or the boat's cruising speed, if not given
    #[arg(long, value_name = "M/S")]
    pub speed: Option<f64>,
    /// How many times faster than real time
    #[arg(long, default_value_t = 8.0, value_name = "N")]
    pub speedup: f64,
    /// Folder for the report
    #[arg(long, default_value = "helmlink-report", value_name = "DIR")]
    pub report: PathBuf,
    /// The address at which ground stations and the bridge find the boat; any free port if it is taken
    #[arg(long, default_value = "tcpin:127.0.0.1:5760", value_name = "URL")]
    pub listen: LinkUrl,
    /// By which messages the bridge steers
    #[arg(long, default_value = "rc-override", value_name = "rc-override|manual-control|guided")]
    pub output: OutputKind,
    #[command(flatten)]
    #[allow(missing_docs)]
    pub world: WorldArgs,
    #[command(flatten)]
    #[allow(missing_docs)]
    pub common: Common,
}

/// `helmlink bridge`.
#[derive(Debug, Clone, Args)]
#[command(after_help = "\
Examples:
  helmlink bridge --connect serial:/dev/ttyAMA0:921600 --engage-mode GUIDED --output guided
  helmlink bridge --connect tcp:127.0.0.1:5760 --engage
  helmlink bridge --connect udpin:0.0.0.0:14550 --shadow --mission survey.waypoints

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
    #[arg(long, default_value = "rc-override", value_name = "rc-override|manual-control|guided")]
    pub output: OutputKind,
    /// The boat that the controller is tuned for
    #[arg(long, default_value = "otter")]
    pub boat: String,
    /// Speed over ground, m/s; the mission's own, or the vehicle's WP_SPEED, if not given
    #[arg(long, value_name = "M/S")]
    pub speed: Option<f64>,
    /// Drive as soon as everything is ready and the boat is armed
    #[arg(long)]
    pub engage: bool,
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
    /// Write everything received and sent to a telemetry log in this folder
    #[arg(long, value_name = "DIR")]
    pub record: Option<PathBuf>,
    /// The control loop's rate, Hz
    #[arg(long, default_value_t = 25.0, value_name = "HZ")]
    pub rate: f64,
    /// The ground station's system id that overrides are sent with: the flight controller's SYSID_MYGCS
    #[arg(long, default_value_t = 255, value_name = "ID")]
    pub gcs_system: u8,
    /// Give up when no heartbeat has come for this many seconds after the start
    #[arg(long, default_value_t = 10.0, value_name = "S")]
    pub wait: f64,
    /// End when the mission is complete
    #[arg(long)]
    pub once: bool,
    #[command(flatten)]
    #[allow(missing_docs)]
    pub common: Common,
}

/// `helmlink sitl`.
#[derive(Debug, Clone, Args)]
#[command(after_help = "\
Examples:
  helmlink sitl
  helmlink sitl --listen tcpin:127.0.0.1:5760 --listen udpout:127.0.0.1:14550 --current 0.4@90 --speedup 5

Then, for example: mavproxy.py --master tcp:127.0.0.1:5760")]
pub struct SitlArgs {
    /// Where ground stations find the boat (repeatable)
    #[arg(long, value_name = "URL", default_value = "tcpin:127.0.0.1:5760")]
    pub listen: Vec<LinkUrl>,
    /// How many times faster than real time
    #[arg(long, default_value_t = 1.0, value_name = "N")]
    pub speedup: f64,
    /// A mission that the boat has on board from the start
    #[arg(long, value_name = "FILE")]
    pub mission: Option<PathBuf>,
    /// Take as long to start as real firmware does (position after 42 s)
    #[arg(long)]
    pub realistic_startup: bool,
    #[command(flatten)]
    #[allow(missing_docs)]
    pub world: WorldArgs,
    #[command(flatten)]
    #[allow(missing_docs)]
    pub common: Common,
}

/// `helmlink simulate`.
#[derive(Debug, Clone, Args)]
#[command(after_help = "\
Example:
  helmlink simulate mission/plans/fossen-otter.waypoints --boat otter --speed 1.38 \\
      --current 0.3@30 --sensors perfect --json")]
pub struct SimulateArgs {
    /// The mission file (.waypoints or .plan)
    pub mission: PathBuf,
    /// Speed over ground, m/s; the mission's own, or the boat's cruising speed, if not given
    #[arg(long, value_name = "M/S")]
    pub speed: Option<f64>,
    /// The control law
    #[arg(long, value_enum, default_value_t = ControllerName::PiSmc)]
    pub controller: ControllerName,
    /// By which messages the bridge steers
    #[arg(long, default_value = "rc-override", value_name = "rc-override|manual-control|guided")]
    pub output: OutputKind,
    /// The control loop's rate, Hz
    #[arg(long, default_value_t = 25.0, value_name = "HZ")]
    pub rate: f64,
    /// Folder for the report (track picture, result, log)
    #[arg(long, value_name = "DIR")]
    pub report: Option<PathBuf>,
    /// Give up after this much simulated time, seconds
    #[arg(long, default_value_t = 14_400.0, value_name = "S")]
    pub limit: f64,
    #[command(flatten)]
    #[allow(missing_docs)]
    pub world: WorldArgs,
    #[command(flatten)]
    #[allow(missing_docs)]
    pub common: Common,
}

/// The control laws.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum ControllerName {
    /// The adaptive PI sliding-mode controller with path-tangent guidance
    PiSmc,
}

impl ControllerName {
    /// The name as it is typed.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::PiSmc => "pi-smc",
        }
    }
}

/// `helmlink mission …`.
#[derive(Debug, Subcommand)]
pub enum MissionCommand {
    /// Read a mission file and say whether a boat can drive it
    Check(MissionFileArgs),
}

/// `helmlink mission check`.
#[derive(Debug, Clone, Args)]
#[command(after_help = "Example:\n  helmlink mission check mission/plans/harbour-survey.waypoints")]
pub struct MissionFileArgs {
    /// The mission file (.waypoints or .plan)
    pub mission: PathBuf,
    #[command(flatten)]
    #[allow(missing_docs)]
    pub common: Common,
}

impl Command {
    /// The options that every subcommand has.
    pub fn common(&self) -> &Common {
        match self {
            Self::Demo(args) => &args.common,
            Self::Bridge(args) => &args.common,
            Self::Sitl(args) => &args.common,
            Self::Simulate(args) => &args.common,
            Self::Mission(MissionCommand::Check(args)) => &args.common,
        }
    }
}
