use super::*;
use crate::physics::{Hull, Sea, SensorSettings};
use crate::{Sitl, SitlSettings};

/// A boat in the world of a scenario, ready for it.
fn boat(scenario: &Scenario) -> Sitl {
    let world = &scenario.world;
    let hull = Hull::builtin(world.boat.as_deref().unwrap_or("otter")).unwrap();
    let state = world.sea.as_deref().unwrap_or("calm").parse().unwrap();
    let mut sea = Sea::preset(state, &hull);
    if let Some(current) = &world.current {
        sea.current = Some(current.parse().unwrap());
    }
    let sensors: SensorSettings = world.sensors.as_deref().unwrap_or("typical").parse().unwrap();
    let seed = world.seed.unwrap_or(1);
    let settings = SitlSettings { sea, sensors, seed, ..SitlSettings::new(hull) };
    Sitl::new(settings).unwrap()
}

fn played(scenario: Scenario) -> Vec<Verdict> {
    let mut boat = boat(&scenario);
    boat.play(scenario).unwrap();
    while !boat.is_scenario_over() {
        boat.advance(boat.now() + Duration::from_secs(1));
        boat.start();
        assert!(boat.now() < Duration::from_secs(1000), "the scenario must end");
    }
    boat.verdicts().to_vec()
}

#[test]
fn every_scenario_that_comes_along_comes_out_as_it_says() {
    for name in Scenario::names() {
        let scenario = Scenario::from_toml(Scenario::builtin_text(name).unwrap()).unwrap();
        assert!(!scenario.expectations.is_empty() && !scenario.summary.is_empty());
        for verdict in played(scenario) {
            assert_eq!(verdict.passed, Some(true), "{name}: {} ({})", verdict.expectation, verdict.seen);
        }
    }
}

#[test]
fn orders_to_the_autopilot_are_told() {
    let order = |name: &str| Scenario::from_toml(Scenario::builtin_text(name).unwrap()).unwrap().order();
    assert_eq!(order("gps-loss").as_deref(), Some("orders mode GUIDED at 0 s"));
    assert_eq!(order("bad-link"), None);
}

#[test]
fn what_does_not_come_true_is_told() {
    let text = r#"
        name = "too much asked"
        duration_s = 20
        [[expect]]
        quantity = "speed_mps"
        above = 5
        within_s = 10
        [[expect]]
        quantity = "distance_home_m"
        below = 5
        [[expect]]
        quantity = "mode"
        is = "RTL"
        after_s = 20
    "#;
    let verdicts = played(Scenario::from_toml(text).unwrap());
    let passed: Vec<_> = verdicts.iter().map(|verdict| verdict.passed).collect();
    assert_eq!(passed, [Some(false), Some(true), Some(false)]);
    assert!(verdicts[0].seen.contains("speed_mps was"), "{}", verdicts[0].seen);
    assert!(verdicts[2].seen.starts_with("mode was LOITER at"), "{}", verdicts[2].seen);
}

#[test]
fn faults_and_seas_happen_when_the_file_says() {
    let text = r#"
        name = "events"
        duration_s = 30
        [[event]]
        at_s = 10
        until_s = 20
        fault = "gps-loss"
        [[event]]
        at_s = 15
        current = "0.4@90"
        [[event]]
        at_s = 16
        parameter = "WP_SPEED=1.25"
        [[expect]]
        quantity = "has_position"
        is = true
        after_s = 5
        until_s = 9
        [[expect]]
        quantity = "has_position"
        is = false
        after_s = 10.1
        until_s = 19.9
        [[expect]]
        quantity = "has_position"
        is = true
        after_s = 20.1
    "#;
    let scenario = Scenario::from_toml(text).unwrap();
    let mut boat = boat(&scenario);
    boat.play(scenario).unwrap();
    boat.advance(Duration::from_secs(31));
    assert!(boat.verdicts().iter().all(|verdict| verdict.passed == Some(true)), "{:?}", boat.verdicts());
    assert_eq!(boat.sea().current.unwrap().speed_mps, 0.4);
    assert_eq!(boat.changed_parameters(), [("WP_SPEED".to_owned(), 1.25)]);
}

#[test]
fn a_broken_file_names_the_key_the_line_and_what_is_allowed() {
    let base = "name = \"x\"\nduration_s = 60\n";
    for (text, hints) in [
        ("duration_s = 60", &["name"][..]),
        ("name = \"x\"\nduration_s = -1", &["duration_s", "line 2", "between 0 and 604800"]),
        (&format!("{base}clock = \"noon\""), &["clock", "line 3", "start or armed"]),
        (&format!("{base}speed = 3"), &["speed", "line 3"]),
        (&format!("{base}[[event]]\nat_s = 1"), &["event.0", "nothing happens"]),
        (&format!("{base}[[event]]\nat_s = 1\nfault = \"gps\""), &["event.0.fault", "line 5", "gps-loss"]),
        (
            &format!("{base}[[event]]\nat_s = 9\nuntil_s = 3\nfault = \"gps-loss\""),
            &["until_s", "line 5", "later"],
        ),
        (&format!("{base}[[event]]\nat_s = 1\nwaves = \"9:2@0\""), &["event.0.waves", "line 5", "between"]),
        (&format!("{base}[[event]]\nat_s = 1\naction = \"mode FLY\""), &["event.0.action", "no mode"]),
        (&format!("{base}[[event]]\nat_s = 1\nparameter = \"A\""), &["NAME=VALUE"]),
        (&format!("{base}[world]\nboat = \"raft\""), &["world.boat", "line 4", "otter"]),
        (&format!("{base}[world]\nsea = \"stormy\""), &["world.sea", "line 4", "slight"]),
        (&format!("{base}[[expect]]\nquantity = \"depth\""), &["expect.0.quantity", "line 4", "speed_mps"]),
        (&format!("{base}[[expect]]\nquantity = \"armed\"\nbelow = 1"), &["armed is no number"]),
        (&format!("{base}[[expect]]\nquantity = \"speed_mps\"\nis = 1.0"), &["below and above"]),
        (&format!("{base}[[expect]]\nquantity = \"speed_mps\""), &["is, below or above"]),
        (
            &format!("{base}[[expect]]\nquantity = \"armed\"\nis = true\nafter_s = 70"),
            &["within the scenario's 60 s"],
        ),
    ] {
        let message = Scenario::from_toml(text).unwrap_err().to_string();
        for hint in hints {
            assert!(message.contains(hint), "{text}\n-> {message}\nlacks {hint}");
        }
    }
}

#[test]
fn a_scenario_that_does_not_fit_the_boat_is_refused() {
    let text = |what: &str| format!("name = \"x\"\nduration_s = 9\n[[event]]\nat_s = 1\n{what}\n");
    let mut boat = boat(&Scenario::from_toml(&text("sea = \"calm\"")).unwrap());
    for (what, hint) in [("fault = \"rudder-stuck\"", "no rudder"), ("parameter = \"NO_SUCH=1\"", "NO_SUCH")]
    {
        let refused = boat.play(Scenario::from_toml(&text(what)).unwrap()).unwrap_err();
        assert!(refused.to_string().contains(hint), "{refused}");
    }
}

#[test]
fn a_depth_is_checked_with_its_line_and_put_in_place() {
    let with = |world: &str, event: &str| {
        Scenario::from_toml(&format!(
            "name = \"bank\"\nduration_s = 5\n[world]\n{world}\n[[event]]\nat_s = 1\n{event}\n"
        ))
    };
    let message = with("depth_m = 0", "depth_m = 2").unwrap_err().to_string();
    assert!(message.contains("`world.depth_m` (line 4)") && message.contains("0.1 and 1000 m"), "{message}");
    let message = with("depth_m = 3", "depth_m = nan").unwrap_err().to_string();
    assert!(
        message.contains("`event.0.depth_m` (line 7)") && message.contains("0.1 and 1000 m"),
        "{message}"
    );
    let scenario = with("depth_m = 3", "depth_m = 0.5").unwrap();
    assert_eq!(scenario.world.depth_m, Some(3.0));
    let mut boat = boat(&scenario);
    boat.play(scenario).unwrap();
    boat.advance(Duration::from_secs(2));
    assert_eq!(boat.sea().depth_m, Some(0.5));
}
