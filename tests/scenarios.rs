//! Every scenario that comes along, as users start it: the boat alone, and with the bridge at the helm.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod support;

use helmlink_sitl::scenario::Scenario;
use support::Helmlink;

const MISSION: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/mission/plans/fossen-otter.waypoints");

fn each(mut test: impl FnMut(&str, Scenario)) {
    for name in Scenario::names() {
        test(name, Scenario::from_toml(Scenario::builtin_text(name).unwrap()).unwrap());
    }
}

#[test]
fn every_scenario_passes_with_the_boat_alone() {
    each(|name, _| {
        let ended =
            Helmlink::run(&["sitl", "--scenario", name, "--listen", "tcpin:127.0.0.1:0", "--speedup", "max"]);
        assert_eq!(ended.status.code(), Some(0), "{name}: {}", ended.printed);
        assert!(
            ended.printed.contains("passed  ") && !ended.printed.contains("FAILED"),
            "{name}: {}",
            ended.printed
        );
    });
}

#[test]
fn a_scenario_that_leaves_the_helm_passes_with_a_mission_and_with_the_bridge() {
    each(|name, scenario| {
        let refuses = scenario.order().is_some();
        let simulated = Helmlink::run(&["simulate", MISSION, "--speed", "1.2", "--scenario", name]);
        if refuses {
            let said = &simulated.printed;
            assert_eq!(simulated.status.code(), Some(2), "{name}: {said}");
            assert!(said.contains(&format!("`helmlink sitl --scenario {name}`")), "{said}");
            assert_eq!(said.lines().count(), 1, "{said}");
            return;
        }
        assert_eq!(simulated.status.code(), Some(0), "{name}: {}", simulated.printed);
        assert!(simulated.printed.contains("passed  cross_track_m"), "{name}: {}", simulated.printed);
        let listen = "tcpin:127.0.0.1:0";
        let sailed =
            ["sitl", "--mission", MISSION, "--scenario", name, "--listen", listen, "--speedup", "max"];
        let ended = Helmlink::run(&sailed);
        assert_eq!(ended.status.code(), Some(0), "{name}: {}", ended.printed);
    });
}

#[test]
fn what_did_not_come_true_is_told_in_words() {
    let path = std::path::Path::new(env!("CARGO_TARGET_TMPDIR")).join("never-rtl.toml");
    let text = "name = \"x\"\nduration_s = 3\n[[expect]]\nquantity = \"mode\"\nis = \"RTL\"\nafter_s = 3\n";
    std::fs::write(&path, text).unwrap();
    let listen = "tcpin:127.0.0.1:0";
    let ended = Helmlink::run(&[
        "sitl",
        "--scenario",
        path.to_str().unwrap(),
        "--listen",
        listen,
        "--speedup",
        "max",
    ]);
    assert_eq!(ended.status.code(), Some(1), "{}", ended.printed);
    assert!(ended.printed.contains("mode was LOITER at"), "{}", ended.printed);
}
