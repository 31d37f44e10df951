//! A bridge that is killed under way and started again.

use std::fs;

use crate::support::{Folder, Helmlink};

const PLAN: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/short-survey.waypoints");
const OTHER_PLAN: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/mission/plans/fossen-otter.waypoints");

/// A boat with the survey on board, and bridges that follow one another.
struct Scene {
    folder: Folder,
    connect: String,
    _boat: Helmlink,
}

impl Scene {
    fn new(name: &str) -> Self {
        let options = ["--mission", PLAN, "--home", "63.442,10.395,20", "--speedup", "3"];
        let (boat, address) = Helmlink::sitl("tcpin", &options);
        Self { folder: Folder::new(name), connect: format!("tcp:{address}"), _boat: boat }
    }

    fn bridge(&self, options: &[&str]) -> Helmlink {
        let arguments = ["bridge", "--connect", &self.connect, "--state-dir", self.folder.path()];
        Helmlink::start(&[&arguments, options].concat())
    }

    /// A bridge has driven past the first waypoint and is then killed.
    fn drive_and_kill(&self) {
        let mut bridge = self.bridge(&["--engage", "--arm"]);
        bridge.wait_for_line("reached waypoint 1");
        self.until_kept("\"item\":2");
        bridge.kill();
    }

    /// Waits until the file that the next bridge goes by says so.
    fn until_kept(&self, text: &str) {
        let deadline = std::time::Instant::now() + crate::support::process::PATIENCE;
        while !fs::read_to_string(self.folder.file(".resume.json")).unwrap().contains(text) {
            assert!(std::time::Instant::now() < deadline, "`{text}` was not kept");
            std::thread::yield_now();
        }
    }
}

#[test]
fn a_killed_bridge_goes_on_with_the_next_leg_and_refuses_where_that_is_not_safe() {
    let scene = Scene::new("resume");
    scene.drive_and_kill();

    let mut bridge = scene.bridge(&["--resume"]);
    let line = bridge.wait_for_line("resum");
    assert!(line.contains("resuming at item 2"), "{line}");
    let line = bridge.wait_for_line("reached waypoint");
    assert!(line.contains("reached waypoint 2"), "{line}");
    scene.until_kept("\"item\":3");
    bridge.kill();

    // Somebody has carried the boat away, or the file is another boat's.
    let path = scene.folder.file(".resume.json");
    let kept = fs::read_to_string(&path).unwrap();
    let mut point: serde_json::Value = serde_json::from_str(&kept).unwrap();
    point["latitude_deg"] = serde_json::json!(point["latitude_deg"].as_f64().unwrap() + 0.1);
    fs::write(&path, point.to_string()).unwrap();
    let mut bridge = scene.bridge(&["--resume"]);
    let line = bridge.wait_for_line("not resumed: ");
    assert!(line.contains("m from where it was"), "{line}");
    bridge.kill();
    fs::write(&path, kept).unwrap();

    let ended = Helmlink::run(&["mission", "upload", OTHER_PLAN, "--connect", &scene.connect]);
    assert!(ended.status.success(), "{}", ended.printed);
    let mut bridge = scene.bridge(&["--resume"]);
    let line = bridge.wait_for_line("not resumed: ");
    assert!(line.contains("the mission is not the one that was being driven"), "{line}");
    bridge.kill();

    fs::write(&path, "{\"mission\":").unwrap();
    let ended = scene.bridge(&["--resume"]).into_process().wait();
    assert_eq!(ended.status.code(), Some(2), "{}", ended.printed);
    assert!(
        ended.printed.contains("makes no sense") && ended.printed.contains("engage by hand"),
        "{}",
        ended.printed
    );
}
