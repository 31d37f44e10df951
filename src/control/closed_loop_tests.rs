//! The whole controller on boats it does not know exactly.

use std::f64::consts::FRAC_PI_2;

use helmlink_mission::geodesy::NorthEast;
use helmlink_mission::path::{Path, PathLimits};

use super::testing::{Plant, Report, Run};
use super::{Boat, Controller, Helm, Hull};
use crate::guidance::{EndOfPath, unit};

/// The way-points of Fossen's Otter example in local metres, scaled.
fn box_path(scale: f64, radius_m: f64) -> Path {
    let points = [
        (0.0, 0.0),
        (0.0, 200.0),
        (149.0, 200.0),
        (149.0, -50.0),
        (-100.0, -50.0),
        (-100.0, 250.0),
        (200.0, 250.0),
    ]
    .map(|(north_m, east_m)| NorthEast { north_m: scale * north_m, east_m: scale * east_m });
    Path::through(&points, &PathLimits::new(radius_m, 0.75 * radius_m)).unwrap()
}

fn current(speed_mps: f64, toward_deg: f64) -> NorthEast {
    unit(toward_deg.to_radians()) * speed_mps
}

/// The Otter on Fossen's way-points at 1.38 m/s, its hull changed by `change`.
fn otter(water: NorthEast, change: impl Fn(&mut Hull), adjust: impl Fn(&mut Run<'_>)) -> Report {
    let boat = Boat::embedded("otter").unwrap();
    let path = box_path(1.0, 4.0);
    let mut plant = Plant::otter().under_way(FRAC_PI_2, 0.5, water);
    change(&mut plant.hull);
    let mut run = Run::new(&boat, &path, 1.38);
    adjust(&mut run);
    let report = run.run(&mut plant);
    println!("{report:.4?}");
    assert!(report.finished);
    report
}

fn scaled_damping(hull: &mut Hull, factor: f64) {
    for row in [&mut hull.surge_damping, &mut hull.sway_damping, &mut hull.yaw_damping] {
        row.iter_mut().for_each(|d| *d *= factor);
    }
}

fn scaled_mass(hull: &mut Hull, factor: f64) {
    hull.m11_kg *= factor;
    hull.m22_kg *= factor;
    hull.m33_kgm2 *= factor;
}

#[test]
fn fossens_mission_in_a_current() {
    let report = otter(current(0.3, 30.0), |_| (), |_| ());
    assert!(report.settled_rms_m < 0.01, "{report:?}");
    assert!(report.legs_rms_m < 0.20, "{report:?}");
    assert!(report.path_rms_m < 0.05, "{report:?}");
    assert!(report.path_max_m < 0.5, "{report:?}");
    // No chattering and no limit cycle.
    assert!(report.steering_per_min < 2.0, "{report:?}");
    assert!(report.settled_steering_per_min < 0.3, "{report:?}");
}

#[test]
fn calm_water_leaves_nothing_on_the_legs() {
    let report = otter(current(0.0, 0.0), |_| (), |_| ());
    assert!(report.settled_rms_m < 0.002 && report.path_rms_m < 0.03, "{report:?}");
}

#[test]
fn currents_from_all_sides() {
    for toward_deg in [0.0, 75.0, 120.0, 210.0, 300.0] {
        let report = otter(current(0.5, toward_deg), |_| (), |_| ());
        assert!(report.settled_rms_m < 0.03, "{toward_deg}: {report:?}");
        assert!(report.legs_rms_m < 0.3, "{toward_deg}: {report:?}");
    }
}

#[test]
fn a_hull_of_another_mass_and_damping() {
    for factor in [0.5, 1.5] {
        for report in [
            otter(current(0.3, 30.0), |hull| scaled_mass(hull, factor), |_| ()),
            otter(current(0.3, 30.0), |hull| scaled_damping(hull, factor), |_| ()),
        ] {
            assert!(report.settled_rms_m < 0.02, "{factor}: {report:?}");
            assert!(report.legs_rms_m < 0.25, "{factor}: {report:?}");
            assert!(report.settled_steering_per_min < 0.5, "{factor}: {report:?}");
        }
    }
}

#[test]
fn a_late_command_and_an_uneven_clock() {
    let late = otter(current(0.3, 30.0), |_| (), |run| run.delay_ticks = 6);
    assert!(late.settled_rms_m < 0.02 && late.legs_rms_m < 0.25, "{late:?}");
    for steps_s in [&[0.2][..], &[0.02], &[0.02, 0.2, 0.05, 0.1, 0.033]] {
        let report = otter(current(0.3, 30.0), |_| (), |run| run.steps_s = steps_s);
        assert!(report.settled_rms_m < 0.02 && report.legs_rms_m < 0.25, "{steps_s:?}: {report:?}");
    }
}

#[test]
fn a_delay_that_is_known_costs_little() {
    let half = otter(current(0.3, 30.0), |_| (), |run| (run.delay_ticks, run.told_delay_s) = (10, 0.5));
    let whole = otter(current(0.3, 30.0), |_| (), |run| (run.delay_ticks, run.told_delay_s) = (20, 1.0));
    for report in [half, whole] {
        assert!(report.settled_rms_m < 0.01 && report.path_rms_m < 0.08, "{report:?}");
        assert!(report.settled_steering_per_min < 0.5, "{report:?}");
    }
    // Told wrongly by a quarter of a second either way it still holds.
    let more = otter(current(0.3, 30.0), |_| (), |run| (run.delay_ticks, run.told_delay_s) = (10, 0.25));
    let less = otter(current(0.3, 30.0), |_| (), |run| (run.delay_ticks, run.told_delay_s) = (4, 0.5));
    for report in [more, less] {
        assert!(report.settled_rms_m < 0.02 && report.path_rms_m < 0.08, "{report:?}");
    }
    // Not told at all, the loop rings: the prediction is what does it.
    let untold = otter(current(0.3, 30.0), |_| (), |run| run.delay_ticks = 20);
    assert!(untold.settled_rms_m > 0.1, "{untold:?}");
}

#[test]
fn noise_is_not_amplified() {
    let report = otter(current(0.3, 30.0), |_| (), |run| run.noise_seed = Some(7));
    // The slow position error alone is 0.05 m.
    assert!(report.settled_rms_m < 0.06, "{report:?}");
    assert!(report.steering_per_min < 40.0, "{report:?}");
}

#[test]
fn a_constant_push_is_held_off() {
    let boat = Boat::embedded("otter").unwrap();
    let path = box_path(0.6, 4.0);
    let mut plant = Plant::otter().under_way(FRAC_PI_2, 0.5, current(0.0, 0.0));
    plant.push = [-15.0, 20.0, 4.0];
    let report = Run::new(&boat, &path, 1.2).run(&mut plant);
    assert!(report.finished && report.settled_rms_m < 0.02, "{report:?}");
}

/// Every boat on a box in a current: settled and whole-path limits, m.
#[test]
fn every_boat_follows_its_path() {
    for (name, scale, radius_m, speed_mps, current_mps, settled_m, path_m) in [
        ("monohull38", 7.0, 180.0, 4.0, 0.6, 0.5, 2.0),
        ("motorboat", 1.0, 4.0, 2.0, 1.0, 0.02, 0.15),
        ("motorboat", 1.5, 6.0, 5.0, 1.0, 0.02, 0.15),
        ("skiff", 1.0, 8.0, 2.0, 0.4, 0.05, 0.3),
    ] {
        let boat = Boat::embedded(name).unwrap();
        let path = box_path(scale, radius_m);
        let mut plant = Plant::of(&boat).under_way(FRAC_PI_2, 0.5 * speed_mps, current(current_mps, 30.0));
        let report = Run::new(&boat, &path, speed_mps).run(&mut plant);
        println!("{name} {speed_mps}: {report:.4?}");
        assert!(report.finished, "{name}: {report:?}");
        assert!(report.settled_rms_m < settled_m, "{name}: {report:?}");
        assert!(report.path_rms_m < path_m, "{name}: {report:?}");
        assert!(report.settled_steering_per_min < 3.0, "{name}: {report:?}");

        let mut plant = Plant::of(&boat).under_way(FRAC_PI_2, 0.5 * speed_mps, current(current_mps, 30.0));
        let late = Run { delay_ticks: 10, told_delay_s: 0.5, ..Run::new(&boat, &path, speed_mps) };
        let report = late.run(&mut plant);
        println!("{name} {speed_mps} late: {report:.4?}");
        assert!(report.finished && report.settled_rms_m < settled_m, "{name} late: {report:?}");
        assert!(report.settled_steering_per_min < 3.0, "{name} late: {report:?}");
    }
}

#[test]
fn far_away_and_facing_the_wrong_way_every_boat_finds_its_path() {
    for (name, scale, radius_m, speed_mps) in [
        ("otter", 1.0, 4.0, 1.38),
        ("motorboat", 1.0, 4.0, 2.0),
        ("skiff", 1.0, 8.0, 2.0),
        ("monohull38", 7.0, 180.0, 4.0),
    ] {
        let boat = Boat::embedded(name).unwrap();
        let path = box_path(scale, radius_m);
        for (north_m, heading_rad) in [(-60.0, -FRAC_PI_2), (60.0, 3.1), (-0.5, -1.4)] {
            let mut plant = Plant::of(&boat).under_way(heading_rad, 0.0, current(0.1, 100.0));
            plant.position = NorthEast { north_m: scale * north_m, east_m: 0.0 };
            let report = Run::new(&boat, &path, speed_mps).run(&mut plant);
            assert!(report.finished, "{name} from {north_m} {heading_rad}: {report:?}");
            assert!(
                report.settled_rms_m < 0.05 * boat.guidance.lead_m,
                "{name} from {north_m} {heading_rad}: {report:?}"
            );
        }
    }
}

/// There and back along nearly the same line, scaled to the boat: 180° and 170° corners.
fn hairpins(scale: f64, radius_m: f64) -> Path {
    let points = [(0.0, 0.0), (0.0, 120.0), (0.0, 20.0), (17.6, 119.7)]
        .map(|(north_m, east_m)| NorthEast { north_m: scale * north_m, east_m: scale * east_m });
    Path::through(&points, &PathLimits::new(radius_m, 0.75 * radius_m)).unwrap()
}

#[test]
fn every_boat_rounds_hairpins() {
    for (name, scale, speed_mps) in
        [("otter", 1.0, 1.38), ("motorboat", 1.0, 2.0), ("skiff", 1.0, 2.0), ("monohull38", 14.0, 4.0)]
    {
        let boat = Boat::embedded(name).unwrap();
        let path = hairpins(scale, boat.limits.turn_radius_m);
        let mut plant = Plant::of(&boat).under_way(FRAC_PI_2, 0.5 * speed_mps, current(0.1, 20.0));
        let report = Run::new(&boat, &path, speed_mps).run(&mut plant);
        assert!(report.finished, "{name}: {report:?}");
        assert!(report.path_rms_m < 0.1 * boat.guidance.lead_m, "{name}: {report:?}");
        assert!(report.path_max_m < 0.5 * boat.limits.turn_radius_m, "{name}: {report:?}");
    }
}

#[test]
fn a_boat_going_astern_is_brought_about() {
    for name in Boat::names() {
        let boat = Boat::embedded(name).unwrap();
        let (scale, radius_m) = if name == "monohull38" { (7.0, 180.0) } else { (1.0, 8.0) };
        let speed_mps = boat.limits.cruise_mps;
        for controller in Controller::ALL {
            let mut plant = Plant::of(&boat).under_way(FRAC_PI_2, -0.5 * speed_mps, current(0.1, 20.0));
            let path = box_path(0.5 * scale, radius_m);
            let report = Run { controller, ..Run::new(&boat, &path, speed_mps) }.run(&mut plant);
            assert!(report.finished, "{name} {controller}: {report:?}");
            // At first it may run off backwards; then it comes back and stays.
            assert!(report.path_max_m < 3.0 * boat.guidance.lead_m, "{name} {controller}: {report:?}");
        }
    }
}

#[test]
fn a_wanted_speed_of_zero_stops_every_boat_and_leaves_it_quiet() {
    for name in Boat::names() {
        let boat = Boat::embedded(name).unwrap();
        let path = box_path(if name == "monohull38" { 7.0 } else { 1.0 }, boat.limits.turn_radius_m);
        for controller in Controller::ALL {
            let mut plant = Plant::of(&boat).under_way(FRAC_PI_2, boat.limits.cruise_mps, current(0.0, 0.0));
            let mut helm = Helm::with_controller(&boat, controller, EndOfPath::Stop);
            helm.engage(&plant.state(), 0.0).unwrap();
            for _ in 0..2400 {
                let command = helm.step(0.05, &plant.state(), &path, 0.0).unwrap().command;
                assert!(command.throttle.abs() <= 1.0 && command.steering.abs() <= 1.0);
                plant.advance(0.05, command);
            }
            // Steerage way is kept by a boat that would drift helplessly without it.
            let least_mps = boat.limits.steerage_mps + 0.1 * boat.limits.cruise_mps;
            assert!(plant.nu[0].abs() < least_mps, "{name} {controller}: {:?}", plant.nu);
        }
    }
}

#[test]
fn a_boat_too_weak_for_its_speed_recovers_without_overshoot() {
    // Held back by more than its thrust for a while, then let go: no surge beyond the wanted speed.
    let boat = Boat::embedded("otter").unwrap();
    let path = box_path(1.0, 4.0);
    let mut plant = Plant::otter().under_way(FRAC_PI_2, 1.0, current(0.0, 0.0));
    let mut helm = Helm::new(&boat, EndOfPath::RunThrough);
    helm.engage(&plant.state(), 0.0).unwrap();
    let mut fastest_mps = 0.0f64;
    for tick in 0..1600 {
        plant.push[0] = if tick < 600 { -200.0 } else { 0.0 };
        let output = helm.step(0.05, &plant.state(), &path, 1.38).unwrap();
        if tick > 600 {
            fastest_mps = fastest_mps.max(plant.nu[0]);
        }
        plant.advance(0.05, output.command);
    }
    assert!(fastest_mps > 1.35 && fastest_mps < 1.55, "{fastest_mps}");
}
