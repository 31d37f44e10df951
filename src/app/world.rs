//! The boat and the sea that the command line asks for.

use clap::Args;
use helmlink_mission::geodesy::Geodetic;
use helmlink_sitl::physics::sea::{Current, Waves, Wind, checked_depth_m};
use helmlink_sitl::physics::{Hull, Sea, SeaState, SensorSettings};

use super::failure::Failure;
use super::ranges::DepthM;

/// The boat and the sea of a simulation.
#[derive(Debug, Clone, Args)]
pub struct WorldArgs {
    /// The boat: otter, monohull38, skiff or motorboat, or a hull file (.toml)
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
    /// Depth of the water in m, for the drag of a near bottom; deep if not given
    #[arg(long, value_name = "M")]
    pub depth: Option<DepthM>,
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

/// A simulated world, checked.
#[derive(Debug, Clone)]
pub(super) struct World {
    /// The hull.
    pub(super) hull: Hull,
    /// Current, wind and waves.
    pub(super) sea: Sea,
    /// Sensors.
    pub(super) sensors: SensorSettings,
    /// Seed of everything random.
    pub(super) seed: u64,
    /// Where the boat starts, if the user says so.
    pub(super) home: Option<(Geodetic, Option<f64>)>,
    /// The sea in words.
    pub(super) sea_text: String,
    /// The sensors in words.
    pub(super) sensors_text: String,
}

impl World {
    /// # Errors
    /// The first option that makes no sense, with what would.
    pub(super) fn from_args(args: &WorldArgs) -> Result<Self, Failure> {
        let hull = hull(&args.boat)?;
        let state: SeaState = args.sea.parse().map_err(Failure::usage)?;
        let mut sea = Sea::preset(state, &hull);
        let mut sea_text = args.sea.clone();
        for (option, text) in [("current", &args.current), ("wind", &args.wind), ("waves", &args.waves)] {
            let Some(text) = text else { continue };
            match option {
                "current" => sea.current = Some(text.parse::<Current>().map_err(Failure::usage)?),
                "wind" => sea.wind = Some(text.parse::<Wind>().map_err(Failure::usage)?),
                _ => sea.waves = Some(text.parse::<Waves>().map_err(Failure::usage)?),
            }
            sea_text.push_str(&format!(", {option} {text}"));
        }
        if let Some(depth_m) = args.depth {
            sea.depth_m = Some(depth_for(&hull, *depth_m)?);
            sea_text.push_str(&format!(", depth {depth_m} m"));
        }
        let sensors = args.sensors.parse().map_err(Failure::usage)?;
        let home = args.home.as_deref().map(parse_home).transpose()?;
        Ok(Self { hull, sea, sensors, seed: args.seed, home, sea_text, sensors_text: args.sensors.clone() })
    }
}

/// A depth in which the drag of this hull is known.
fn depth_for(hull: &Hull, depth_m: f64) -> Result<f64, Failure> {
    let fault = |why: String| Failure::usage(format!("--depth {depth_m}: {why}"));
    checked_depth_m(depth_m).map_err(|error| fault(error.to_string()))?;
    let Some(size) = hull.shallow_water else {
        return Err(fault(format!(
            "the boat {} does not say how large it is under water; leave the depth out, or give a hull file with a \
             table [shallow_water]",
            hull.name
        )));
    };
    let least_m = size.least_depth_m();
    if depth_m < least_m {
        return Err(fault(format!("the boat {} needs between {least_m:.2} and 1000 m", hull.name)));
    }
    Ok(depth_m)
}

/// A built-in hull by its name, or one from a file.
fn hull(boat: &str) -> Result<Hull, Failure> {
    if Hull::builtin_text(boat).is_some() || !boat.contains(['.', '/', '\\']) {
        return Hull::builtin(boat).map_err(Failure::usage);
    }
    let text = std::fs::read_to_string(boat).map_err(|error| {
        let names = Hull::names().collect::<Vec<_>>().join(", ");
        Failure::usage(format!("--boat {boat}: {error}; give a hull file, or one of {names}"))
    })?;
    Hull::from_toml(&text).map_err(|error| Failure::usage(format!("--boat {boat}: {error}")))
}

/// `LAT,LON` or `LAT,LON,HEADING` in degrees.
fn parse_home(text: &str) -> Result<(Geodetic, Option<f64>), Failure> {
    let fault = |why: &str| {
        Failure::usage(format!(
            "--home {text}: {why}; give degrees as LAT,LON or LAT,LON,HEADING, such as 63.4389,10.399,90"
        ))
    };
    let numbers: Result<Vec<f64>, _> = text.split(',').map(|part| part.trim().parse()).collect();
    match numbers.map_err(|_| fault("not numbers"))?.as_slice() {
        [latitude, longitude, rest @ ..] if rest.len() <= 1 => {
            let home = Geodetic::new(*latitude, *longitude);
            home.check().map_err(|error| fault(&error.to_string()))?;
            let heading = rest.first().copied();
            if heading.is_some_and(|heading| !(-360.0..=360.0).contains(&heading)) {
                return Err(fault("the heading must lie between -360 and 360"));
            }
            Ok((home, heading.map(f64::to_radians)))
        }
        _ => Err(fault("two or three numbers are needed")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_depth_must_suit_the_boat() {
        let refused =
            |boat, depth_m| depth_for(&Hull::builtin(boat).unwrap(), depth_m).unwrap_err().to_string();
        assert!(refused("otter", f64::NAN).contains("between 0.1 and 1000 m"));
        assert!(refused("otter", 0.2).contains("--depth 0.2: the boat otter needs between 0.25 and 1000 m"));
        assert!(refused("motorboat", 2.0).contains("[shallow_water]"));
        assert_eq!(depth_for(&Hull::builtin("skiff").unwrap(), 0.5).unwrap(), 0.5);
    }

    #[test]
    fn reads_a_home() {
        let (home, heading) = parse_home("63.5, 10.25,90").unwrap();
        assert_eq!((home.latitude_deg, home.longitude_deg), (63.5, 10.25));
        assert!((heading.unwrap() - std::f64::consts::FRAC_PI_2).abs() < 1e-12);
        assert_eq!(parse_home("63.5,10.25").unwrap().1, None);
        for wrong in ["", "63.5", "a,b", "91,10", "nan,10", "0,0", "63.5,10,720", "1,2,3,4"] {
            let text = parse_home(wrong).unwrap_err().to_string();
            assert!(text.contains("--home"), "{wrong}: {text}");
        }
    }
}
