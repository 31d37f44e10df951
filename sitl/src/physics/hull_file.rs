//! The hull file as it is written, and its validation into a [`Hull`].

use super::WATER_DENSITY_KGPM3;
use super::hull::{
    CrossFlow, Damping, Hull, HullDynamics, HullError, Maneuvering, Motorboat, Propulsion, ShallowWater,
    SteeredDrive, TwinThrusters, WaveResponse, WindLoads,
};
use super::hull_check;
use crate::toml_place::line_of;
use serde::Deserialize;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct HullFile {
    name: String,
    #[serde(default)]
    summary: String,
    length_m: f64,
    beam_m: f64,
    cruise_speed_mps: f64,
    inertia: Option<InertiaTable>,
    damping: Option<DampingTable>,
    cross_flow: Option<CrossFlowTable>,
    twin_thrusters: Option<TwinThrustersTable>,
    propeller_rudder: Option<PropellerRudderTable>,
    outboard: Option<OutboardTable>,
    motorboat: Option<MotorboatTable>,
    wind: Option<WindTable>,
    waves: Option<WavesTable>,
    shallow_water: Option<ShallowWaterTable>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct InertiaTable {
    m11_kg: f64,
    m22_kg: f64,
    m23_kgm: f64,
    m33_kgm2: f64,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct DampingTable {
    surge: DampingRow,
    sway: DampingRow,
    yaw: DampingRow,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct DampingRow {
    linear: f64,
    #[serde(default)]
    quadratic: f64,
    #[serde(default)]
    cubic: f64,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct CrossFlowTable {
    length_m: f64,
    draft_m: f64,
    drag_coefficient: f64,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct TwinThrustersTable {
    arm_m: f64,
    ahead_n_per_radps2: f64,
    astern_n_per_radps2: f64,
    ahead_limit_n: f64,
    astern_limit_n: f64,
    lag_s: f64,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct PropellerRudderTable {
    ahead_limit_n: f64,
    astern_limit_n: f64,
    throttle_lag_s: f64,
    rudder_arm_m: f64,
    rudder_area_m2: f64,
    rudder_lift: f64,
    slipstream_m2ps2_per_n: f64,
    steering_limit_deg: f64,
    steering_rate_degps: f64,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct OutboardTable {
    ahead_limit_n: f64,
    astern_limit_n: f64,
    throttle_lag_s: f64,
    arm_m: f64,
    leg_area_m2: f64,
    leg_lift: f64,
    slipstream_m2ps2_per_n: f64,
    steering_limit_deg: f64,
    steering_rate_degps: f64,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct MotorboatTable {
    mass_kg: f64,
    thrust_limit_n: f64,
    drag_n_per_mps2: f64,
    turning_circle_m: f64,
    steering_limit_deg: f64,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct WindTable {
    frontal_area_m2: f64,
    lateral_area_m2: f64,
    cx: f64,
    cy: f64,
    cn: f64,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct WavesTable {
    yaw_deg_per_m: f64,
    roll_factor: f64,
    pitch_factor: f64,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ShallowWaterTable {
    midship_area_m2: f64,
    draft_m: f64,
}

/// Parses and validates a hull file.
pub(super) fn parse(text: &str) -> Result<Hull, HullError> {
    checked(text).map_err(|error| match error {
        HullError::OutOfRange { key, value, allowed, .. } => {
            HullError::OutOfRange { line: line_of(text, &key), key, value, allowed }
        }
        other => other,
    })
}

fn checked(text: &str) -> Result<Hull, HullError> {
    let file: HullFile = toml::from_str(text).map_err(|error| HullError::Syntax(error.to_string()))?;
    if file.name.trim().is_empty() {
        return Err(HullError::Layout("hull key `name` is empty: give the boat a name".to_owned()));
    }
    let hull = Hull {
        length_m: within("length_m", file.length_m, 0.2, 500.0, "m")?,
        beam_m: within("beam_m", file.beam_m, 0.05, 100.0, "m")?,
        cruise_speed_mps: within("cruise_speed_mps", file.cruise_speed_mps, 0.05, 50.0, "m/s")?,
        dynamics: dynamics(&file)?,
        wind: file.wind.as_ref().map(wind).transpose()?,
        waves: file.waves.as_ref().map(waves).transpose()?,
        shallow_water: file.shallow_water.as_ref().map(shallow_water).transpose()?,
        name: file.name,
        summary: file.summary,
    };
    hull_check::check(&hull)?;
    Ok(hull)
}

fn shallow_water(table: &ShallowWaterTable) -> Result<ShallowWater, HullError> {
    Ok(ShallowWater {
        midship_area_m2: within("shallow_water.midship_area_m2", table.midship_area_m2, 1e-4, 5000.0, "m²")?,
        draft_m: within("shallow_water.draft_m", table.draft_m, 0.001, 50.0, "m")?,
    })
}

fn dynamics(file: &HullFile) -> Result<HullDynamics, HullError> {
    let hydrodynamic = file.inertia.is_some() || file.damping.is_some() || file.cross_flow.is_some();
    let mut drives = Vec::new();
    if let Some(table) = &file.twin_thrusters {
        drives.push(Propulsion::TwinThrusters(twin_thrusters(table)?));
    }
    if let Some(table) = &file.propeller_rudder {
        drives.push(Propulsion::PropellerRudder(propeller_rudder(table)?));
    }
    if let Some(table) = &file.outboard {
        drives.push(Propulsion::Outboard(outboard(table)?));
    }
    match (drives.as_slice(), &file.motorboat) {
        ([], Some(table)) if !hydrodynamic => motorboat(table).map(HullDynamics::Motorboat),
        ([drive], None) => Ok(HullDynamics::Maneuvering(maneuvering(file)?, *drive)),
        ([], None) => Err(HullError::Layout(
            "the hull has no drive: add one table of [twin_thrusters], [propeller_rudder], [outboard] or [motorboat]"
                .to_owned(),
        )),
        (_, Some(_)) => Err(HullError::Layout(
            "[motorboat] is a complete model of its own: remove [inertia], [damping], [cross_flow] and every \
             other drive, or remove [motorboat]"
                .to_owned(),
        )),
        (_, None) => Err(HullError::Layout(
            "the hull has more than one drive: keep one of [twin_thrusters], [propeller_rudder] and [outboard]"
                .to_owned(),
        )),
    }
}

fn maneuvering(file: &HullFile) -> Result<Maneuvering, HullError> {
    let (Some(inertia), Some(damping)) = (&file.inertia, &file.damping) else {
        return Err(HullError::Layout("the hull needs the tables [inertia] and [damping]".to_owned()));
    };
    let m11_kg = within("inertia.m11_kg", inertia.m11_kg, 0.1, 1e9, "kg")?;
    let m22_kg = within("inertia.m22_kg", inertia.m22_kg, 0.1, 1e9, "kg")?;
    let m33_kgm2 = within("inertia.m33_kgm2", inertia.m33_kgm2, 1e-3, 1e14, "kg·m²")?;
    let m23_kgm = within("inertia.m23_kgm", inertia.m23_kgm, -1e12, 1e12, "kg·m")?;
    let (m22_m33, m23_squared) = (m22_kg * m33_kgm2, m23_kgm * m23_kgm);
    if m22_m33 <= m23_squared {
        return Err(HullError::NotPositiveDefinite { m22_m33, m23_squared, limit_kgm: m22_m33.sqrt() });
    }
    Ok(Maneuvering {
        m11_kg,
        m22_kg,
        m23_kgm,
        m33_kgm2,
        surge: damping_row("damping.surge", &damping.surge)?,
        sway: damping_row("damping.sway", &damping.sway)?,
        yaw: damping_row("damping.yaw", &damping.yaw)?,
        cross_flow: file.cross_flow.as_ref().map(cross_flow).transpose()?,
    })
}

fn damping_row(key: &str, row: &DampingRow) -> Result<Damping, HullError> {
    let term = |name: &str, value: f64| within(&format!("{key}.{name}"), value, 0.0, 1e14, "SI");
    Ok(Damping {
        linear: term("linear", row.linear)?,
        quadratic: term("quadratic", row.quadratic)?,
        cubic: term("cubic", row.cubic)?,
    })
}

fn cross_flow(table: &CrossFlowTable) -> Result<CrossFlow, HullError> {
    let draft_m = within("cross_flow.draft_m", table.draft_m, 0.001, 50.0, "m")?;
    let coefficient = within("cross_flow.drag_coefficient", table.drag_coefficient, 0.0, 5.0, "")?;
    Ok(CrossFlow {
        length_m: within("cross_flow.length_m", table.length_m, 0.1, 500.0, "m")?,
        strip_n_per_m_mps2: 0.5 * WATER_DENSITY_KGPM3 * draft_m * coefficient,
    })
}

fn twin_thrusters(table: &TwinThrustersTable) -> Result<TwinThrusters, HullError> {
    let key = |name: &str| format!("twin_thrusters.{name}");
    Ok(TwinThrusters {
        arm_m: within(&key("arm_m"), table.arm_m, 0.01, 50.0, "m")?,
        ahead_n_per_radps2: within(
            &key("ahead_n_per_radps2"),
            table.ahead_n_per_radps2,
            1e-9,
            1e6,
            "N/(rad/s)²",
        )?,
        astern_n_per_radps2: within(
            &key("astern_n_per_radps2"),
            table.astern_n_per_radps2,
            1e-9,
            1e6,
            "N/(rad/s)²",
        )?,
        ahead_limit_n: within(&key("ahead_limit_n"), table.ahead_limit_n, 1e-3, 1e8, "N")?,
        astern_limit_n: within(&key("astern_limit_n"), table.astern_limit_n, 0.0, 1e8, "N")?,
        lag_s: within(&key("lag_s"), table.lag_s, 0.0, 60.0, "s")?,
    })
}

fn propeller_rudder(table: &PropellerRudderTable) -> Result<SteeredDrive, HullError> {
    let key = |name: &str| format!("propeller_rudder.{name}");
    let area_m2 = within(&key("rudder_area_m2"), table.rudder_area_m2, 1e-4, 500.0, "m²")?;
    let lift = within(&key("rudder_lift"), table.rudder_lift, 0.1, 6.3, "per radian")?;
    Ok(SteeredDrive {
        ahead_limit_n: within(&key("ahead_limit_n"), table.ahead_limit_n, 1e-3, 1e8, "N")?,
        astern_limit_n: within(&key("astern_limit_n"), table.astern_limit_n, 0.0, 1e8, "N")?,
        throttle_lag_s: within(&key("throttle_lag_s"), table.throttle_lag_s, 0.0, 60.0, "s")?,
        arm_m: within(&key("rudder_arm_m"), table.rudder_arm_m, 0.01, 250.0, "m")?,
        foil_n_per_mps2: 0.5 * WATER_DENSITY_KGPM3 * area_m2 * lift,
        slipstream_m2ps2_per_n: slipstream(&key("slipstream_m2ps2_per_n"), table.slipstream_m2ps2_per_n)?,
        steering_limit_rad: steering_limit(&key("steering_limit_deg"), table.steering_limit_deg)?,
        steering_rate_radps: steering_rate(&key("steering_rate_degps"), table.steering_rate_degps)?,
    })
}

fn outboard(table: &OutboardTable) -> Result<SteeredDrive, HullError> {
    let key = |name: &str| format!("outboard.{name}");
    let area_m2 = within(&key("leg_area_m2"), table.leg_area_m2, 0.0, 10.0, "m²")?;
    let lift = within(&key("leg_lift"), table.leg_lift, 0.0, 6.3, "per radian")?;
    Ok(SteeredDrive {
        ahead_limit_n: within(&key("ahead_limit_n"), table.ahead_limit_n, 1e-3, 1e8, "N")?,
        astern_limit_n: within(&key("astern_limit_n"), table.astern_limit_n, 0.0, 1e8, "N")?,
        throttle_lag_s: within(&key("throttle_lag_s"), table.throttle_lag_s, 0.0, 60.0, "s")?,
        arm_m: within(&key("arm_m"), table.arm_m, 0.01, 250.0, "m")?,
        foil_n_per_mps2: 0.5 * WATER_DENSITY_KGPM3 * area_m2 * lift,
        slipstream_m2ps2_per_n: slipstream(&key("slipstream_m2ps2_per_n"), table.slipstream_m2ps2_per_n)?,
        steering_limit_rad: steering_limit(&key("steering_limit_deg"), table.steering_limit_deg)?,
        steering_rate_radps: steering_rate(&key("steering_rate_degps"), table.steering_rate_degps)?,
    })
}

fn motorboat(table: &MotorboatTable) -> Result<Motorboat, HullError> {
    let key = |name: &str| format!("motorboat.{name}");
    Ok(Motorboat {
        mass_kg: within(&key("mass_kg"), table.mass_kg, 0.01, 1e6, "kg")?,
        thrust_limit_n: within(&key("thrust_limit_n"), table.thrust_limit_n, 1e-3, 1e8, "N")?,
        drag_n_per_mps2: within(&key("drag_n_per_mps2"), table.drag_n_per_mps2, 1e-4, 1e8, "N/(m/s)²")?,
        turning_circle_m: within(&key("turning_circle_m"), table.turning_circle_m, 0.1, 1e4, "m")?,
        steering_limit_rad: steering_limit(&key("steering_limit_deg"), table.steering_limit_deg)?,
    })
}

fn wind(table: &WindTable) -> Result<WindLoads, HullError> {
    Ok(WindLoads {
        frontal_area_m2: within("wind.frontal_area_m2", table.frontal_area_m2, 0.0, 1e4, "m²")?,
        lateral_area_m2: within("wind.lateral_area_m2", table.lateral_area_m2, 0.0, 1e4, "m²")?,
        cx: within("wind.cx", table.cx, 0.0, 3.0, "")?,
        cy: within("wind.cy", table.cy, 0.0, 3.0, "")?,
        cn: within("wind.cn", table.cn, 0.0, 1.0, "")?,
    })
}

fn waves(table: &WavesTable) -> Result<WaveResponse, HullError> {
    Ok(WaveResponse {
        yaw_rad_per_m: within("waves.yaw_deg_per_m", table.yaw_deg_per_m, 0.0, 90.0, "°/m")?.to_radians(),
        roll_factor: within("waves.roll_factor", table.roll_factor, 0.0, 5.0, "")?,
        pitch_factor: within("waves.pitch_factor", table.pitch_factor, 0.0, 5.0, "")?,
    })
}

fn slipstream(key: &str, value: f64) -> Result<f64, HullError> {
    within(key, value, 0.0, 10.0, "(m/s)²/N")
}

fn steering_limit(key: &str, degrees: f64) -> Result<f64, HullError> {
    within(key, degrees, 1.0, 80.0, "°").map(f64::to_radians)
}

fn steering_rate(key: &str, degrees_per_s: f64) -> Result<f64, HullError> {
    within(key, degrees_per_s, 0.1, 1000.0, "°/s").map(f64::to_radians)
}

/// `value` if it lies in [min, max]; NaN lies nowhere.
fn within(key: &str, value: f64, min: f64, max: f64, unit: &str) -> Result<f64, HullError> {
    if (min..=max).contains(&value) {
        return Ok(value);
    }
    let allowed = format!("between {min} and {max} {unit}").trim_end().to_owned();
    Err(HullError::OutOfRange { key: key.to_owned(), line: None, value, allowed })
}
