use super::*;
use crate::control::Boat;
use crate::guidance::unit;

fn boat() -> Boat {
    let b = match std::env::var("BOAT") { Ok(p) => Boat::from_toml(&std::fs::read_to_string(p).unwrap()).unwrap(), _ => Boat::embedded("otter").unwrap() };
    let Ok(set) = std::env::var("SET") else { return b };
    let mut p = params(&b);
    for kv in set.split(',') { let (k, v) = kv.split_once('=').unwrap(); let i = NAMES.iter().position(|n| *n == k).unwrap(); p[i] = v.parse().unwrap(); }
    apply(&b, &p)
}
const NAMES: [&str; 22] = ["lead","leadt","soft","tb","pre","spre","kpsi","fu","ku","lu","phiu","fr","kr","lr","phir","dmr","turn","dec","ar","creep","gr","dc"];
fn params(b: &Boat) -> [f64; 22] { let (g, c) = (&b.guidance, &b.control); [g.lead_m, g.lead_time_s, g.lead_softness_m, g.drift_time_s, g.preview_s, g.speed_preview_s, c.heading_gain, c.surge.filter_s, c.surge.reaching_gain, c.surge.integral_slope, c.surge.boundary, c.yaw.filter_s, c.yaw.reaching_gain, c.yaw.integral_slope, c.yaw.boundary, c.yaw.disturbance_max, b.limits.turn_rate_radps, b.limits.deceleration_mps2, c.yaw.acceleration_max, g.creep_mps, c.yaw.disturbance_rate, c.yaw.damping_at_command] }
fn apply(b: &Boat, p: &[f64; 22]) -> Boat { let mut b = b.clone(); let g = &mut b.guidance; g.lead_m = p[0]; g.lead_time_s = p[1]; g.lead_softness_m = p[2]; g.drift_time_s = p[3]; g.preview_s = p[4]; g.speed_preview_s = p[5]; let c = &mut b.control; c.heading_gain = p[6]; c.surge.filter_s = p[7]; c.surge.reaching_gain = p[8]; c.surge.integral_slope = p[9]; c.surge.boundary = p[10]; c.yaw.filter_s = p[11]; c.yaw.reaching_gain = p[12]; c.yaw.integral_slope = p[13]; c.yaw.boundary = p[14]; c.yaw.disturbance_max = p[15]; b.limits.turn_rate_radps = p[16]; b.limits.deceleration_mps2 = p[17]; c.yaw.acceleration_max = p[18]; g.creep_mps = p[19]; c.yaw.disturbance_rate = p[20]; c.yaw.damping_at_command = p[21]; b }

fn scenario(boat: &Boat, path: &helmlink_mission::path::Path, i: usize, trace: bool) -> Report {
    let points = if std::env::var("SHORT").is_ok() { box_points().iter().map(|p| *p * 0.45).collect() } else { box_points() };
    let speed = std::env::var("SPEED").map_or(1.38, |k| k.parse().unwrap());
    let mut plant = if boat.name == "otter" { Plant::otter() } else { Plant::of(boat) };
    plant.heading_rad = std::f64::consts::FRAC_PI_2;
            let mut c = (0.3, 30.0);
    let mut delay = 0; let mut rate = 20.0; let mut noise = 0.0;
    let h = &mut plant.hull;
    let damp = |h: &mut crate::control::Hull, k: f64| { for d in [&mut h.surge_damping, &mut h.sway_damping, &mut h.yaw_damping] { for x in d.iter_mut() { *x *= k; } } };
    match i { 0 => {} 1 => { h.m11_kg *= 1.5; h.m22_kg *= 1.5; h.m33_kgm2 *= 1.5 } 2 => { h.m11_kg *= 0.5; h.m22_kg *= 0.5; h.m33_kgm2 *= 0.5 } 3 => damp(h, 0.5), 4 => damp(h, 1.5), 5 => c = (0.0, 0.0), 6 => c = (0.5, 120.0), 7 => c = (0.5, 300.0), 8 => { delay = 4 } 9 => rate = 5.0, 10 => noise = 1.0, 11 => { delay = 3; noise = 1.0 } _ => unreachable!() }
    if let Ok(v) = std::env::var("CURRENT") { c.0 *= v.parse::<f64>().unwrap(); }
    plant.current = unit(f64::to_radians(c.1)) * c.0;
    let bow = unit(plant.heading_rad); plant.nu = [0.5 + bow.dot(plant.current), bow.cross(plant.current), 0.0];
    let run = Run { boat, path, points: &points, speed_mps: speed, rate_hz: rate, delay_ticks: delay, noise, trace };
    run.run(&mut plant)
}
#[test]
fn scratch() {
    let boat = boat();
    let kappa: f64 = std::env::var("KAPPA").map_or(0.25, |k| k.parse().unwrap());
    let path = helmlink_mission::path::Path::through(&if std::env::var("SHORT").is_ok() { box_points().iter().map(|p| *p * 0.45).collect::<Vec<_>>() } else { box_points() }, &helmlink_mission::path::PathLimits::new(1.0 / kappa, std::env::var("TRANS").map_or(3.0, |k| k.parse().unwrap()))).unwrap();
    if let Ok(i) = std::env::var("TRACE") { println!("{:#?}", scenario(&boat, &path, i.parse().unwrap(), true)); return; }
    for (i, n) in ["nominal", "mass 1.5", "mass .5", "damp .5", "damp 1.5", "calm", ".5 120", ".5 300", "delay 4", "5 Hz", "noise", "noise+delay3"].iter().enumerate() {
        let r = scenario(&boat, &path, i, false);
        println!("{n:12} settled {:.4} max {:.3} | path {:.3} max {:.3} | whole {:.3} max {:.3} | TV st {:.2} th {:.2} settled {:.2} | {:.0} s {}", r.settled_rms_m, r.settled_max_m, r.path_rms_m, r.path_max_m, r.whole_rms_m, r.whole_max_m, r.steering_per_min, r.throttle_per_min, r.settled_steering_per_min, r.duration_s, r.finished);
    }
}
fn cost(boat: &Boat, path: &helmlink_mission::path::Path) -> f64 {
    let mut sum = 0.0;
    for i in 0..12 {
        let r = scenario(boat, path, i, false);
        let settled = if r.settled_rms_m.is_nan() { 5.0 } else { r.settled_rms_m };
        let mut c = r.path_rms_m + 2.0 * settled + 0.01 * r.steering_per_min.min(100.0) + 0.003 * r.settled_steering_per_min.min(100.0) + 0.002 * r.throttle_per_min;
        if !r.finished { c += 5.0; }
        sum += if i == 0 { 2.0 } else { 1.0 } * c;
    }
    sum
}
#[test]
fn search() {
    use rand_chacha::rand_core::{Rng, SeedableRng};
    let seed: u64 = std::env::var("SEED").map_or(1, |k| k.parse().unwrap());
    let n: usize = std::env::var("N").map_or(1, |k| k.parse().unwrap());
    let kappa: f64 = std::env::var("KAPPA").map_or(0.25, |k| k.parse().unwrap());
    let path = helmlink_mission::path::Path::through(&if std::env::var("SHORT").is_ok() { box_points().iter().map(|p| *p * 0.45).collect::<Vec<_>>() } else { box_points() }, &helmlink_mission::path::PathLimits::new(1.0 / kappa, std::env::var("TRANS").map_or(3.0, |k| k.parse().unwrap()))).unwrap();
    let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(seed);
    let base = boat();
    let mut best = params(&base);
    let mut best_cost = cost(&base, &path);
    let fixed: Vec<String> = std::env::var("FIX").unwrap_or_default().split(',').map(String::from).collect();
    println!("start {best_cost}");
    for it in 0..n {
        let mut p = best;
        let scale = if it % 3 == 0 { 0.4 } else { 0.15 };
        for (i, x) in p.iter_mut().enumerate() {
            if fixed.iter().any(|f| f == NAMES[i]) { continue; }
            let r = |rng: &mut rand_chacha::ChaCha8Rng| rng.next_u32() as f64 / u32::MAX as f64;
            if r(&mut rng) < 0.25 { *x *= (scale * (2.0 * r(&mut rng) - 1.0) * 1.5).exp(); if NAMES[i] == "leadt" && *x < 0.1 && r(&mut rng) < 0.3 { *x = 0.3 + r(&mut rng); } }
        }
        let b = apply(&base, &p);
        if b.check().is_err() { continue; }
        let c = cost(&b, &path);
        if c < best_cost { best_cost = c; best = p; println!("{it} {c:.4} SET={}", NAMES.iter().zip(best).map(|(n, v)| format!("{n}={v:.4}")).collect::<Vec<_>>().join(",")); }
    }
}
#[test]
fn boats() {
    use helmlink_mission::path::{Path, PathLimits};
    for (name, scale, radius, speed, currents, hz) in [("monohull38", 7.0, 180.0, 4.0, 0.6, 10.0), ("motorboat", 0.4, 4.0, 2.0, 1.0, 20.0), ("motorboat", 0.4, 4.0, 5.0, 1.0, 20.0), ("skiff", 0.5, 8.0, 2.0, 0.4, 20.0), ("otter", 1.0, 4.0, 1.38, 0.3, 20.0)] {
        let boat = Boat::embedded(name).unwrap();
        let points: Vec<_> = box_points().iter().map(|p| *p * scale).collect();
        let path = Path::through(&points, &PathLimits::new(radius, radius * 0.75)).unwrap();
        for c in [0.0, currents] {
            let mut plant = if boat.name == "otter" { Plant::otter() } else { Plant::of(&boat) };
            plant.heading_rad = std::f64::consts::FRAC_PI_2;
            plant.current = unit(0.52) * c;
            let bow = unit(plant.heading_rad); plant.nu = [0.5 * speed + bow.dot(plant.current), bow.cross(plant.current), 0.0];
            let run = Run { boat: &boat, path: &path, points: &points, speed_mps: speed, rate_hz: hz, delay_ticks: std::env::var("DELAY").map_or(0, |k| k.parse().unwrap()), noise: 0.0, trace: std::env::var("TRACE").is_ok_and(|t| t == name) };
            let r = run.run(&mut plant);
            println!("{name:12} {speed} c {c} settled {:.4} max {:.3} | path {:.3} max {:.3} | whole {:.3} max {:.3} | TV st {:.2} th {:.2} settled {:.2} | {:.0} s {}", r.settled_rms_m, r.settled_max_m, r.path_rms_m, r.path_max_m, r.whole_rms_m, r.whole_max_m, r.steering_per_min, r.throttle_per_min, r.settled_steering_per_min, r.duration_s, r.finished);
        }
    }
}
