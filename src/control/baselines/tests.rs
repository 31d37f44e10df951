use helmlink_mission::geodesy::NorthEast;
use helmlink_mission::path::{Path, PathLimits};

use crate::control::testing::{Plant, Run};
use crate::control::{Boat, Controller};

fn corner() -> Path {
    let points =
        [(0.0, 0.0), (120.0, 0.0), (120.0, 120.0)].map(|(north_m, east_m)| NorthEast { north_m, east_m });
    Path::through(&points, &PathLimits::new(8.0, 6.0)).unwrap()
}

#[test]
fn every_controller_holds_a_line_in_a_cross_current() {
    let boat = Boat::embedded("otter").unwrap();
    let current = NorthEast { north_m: 0.1, east_m: 0.2 };
    for controller in Controller::ALL {
        let mut plant = Plant::otter().under_way(0.0, 1.2, current);
        let report = Run { controller, ..Run::new(&boat, &corner(), 1.2) }.run(&mut plant);
        // The paper's guidance leaves the offset lead·sin β that its course does not see.
        let settled_m = if controller == Controller::PiSmcPaper { 0.7 } else { 0.1 };
        assert!(report.finished && report.settled_rms_m < settled_m, "{controller}: {report:?}");
    }
}

#[test]
fn the_papers_guidance_is_off_by_the_lead_times_the_crab_angle() {
    let boat = Boat::embedded("otter").unwrap();
    let path = straight();
    let lead_m = boat.baselines.pi_smc_paper.guidance.lead_m;
    let mut plant = Plant::otter().under_way(0.0, 1.2, NorthEast { north_m: 0.0, east_m: 0.2 });
    let run = Run { controller: Controller::PiSmcPaper, ..Run::new(&boat, &path, 1.2) };
    let expected_m = lead_m * (0.2f64 / 1.2).asin().sin();
    let report = run.run(&mut plant);
    assert!((report.settled_rms_m - expected_m).abs() < 0.15 * expected_m, "{report:?} {expected_m}");
}

fn straight() -> Path {
    let points = [(0.0, 0.0), (200.0, 0.0)].map(|(north_m, east_m)| NorthEast { north_m, east_m });
    Path::through(&points, &PathLimits::new(8.0, 6.0)).unwrap()
}

#[test]
fn the_sign_function_chatters_and_the_integral_surface_does_not() {
    let boat = Boat::embedded("otter").unwrap();
    let steering = |controller| {
        let mut plant = Plant::otter().under_way(0.0, 1.2, NorthEast { north_m: 0.0, east_m: 0.1 });
        Run { controller, ..Run::new(&boat, &straight(), 1.2) }.run(&mut plant).steering_per_min
    };
    let (smooth, sign) = (steering(Controller::PiSmc), steering(Controller::SignSmc));
    assert!(sign > 10.0 * smooth, "pi-smc {smooth}, sign-smc {sign}");
}
