use helmlink_mission::geodesy::Geodetic;
use helmlink_wire::Framer;

use super::*;
use crate::physics::{Sea, SensorSettings};

fn boat(change: impl FnOnce(&mut SitlSettings)) -> Result<Sitl, SitlError> {
    let mut settings = SitlSettings::new(Hull::builtin("otter").unwrap());
    change(&mut settings);
    Sitl::new(settings)
}

fn sent(boat: &mut Sitl) -> Vec<u8> {
    let mut all = Vec::new();
    while let Some((_, bytes)) = boat.poll_transmit() {
        all.extend(bytes);
    }
    all
}

#[test]
fn settings_that_make_no_sense_are_refused_by_name() {
    let home = boat(|settings| settings.home = Geodetic::new(95.0, 0.0));
    assert!(matches!(home, Err(SitlError::Home(_))));
    assert!(matches!(boat(|settings| settings.heading_rad = f64::NAN), Err(SitlError::Heading(_))));
    let unknown = boat(|settings| settings.autopilot.parameters = vec![("NO_SUCH".into(), 1.0)]);
    assert!(unknown.unwrap_err().to_string().contains("NO_SUCH"));
    assert!(boat(|settings| settings.autopilot.parameters = vec![("WP_SPEED".into(), 1.2)]).is_ok());
}

#[test]
fn loops_run_only_when_they_end_in_time() {
    let mut boat = boat(|_| {}).unwrap();
    boat.advance(Duration::from_millis(59));
    assert_eq!(boat.now(), Duration::from_millis(40));
    boat.advance(Duration::from_millis(10));
    assert_eq!(boat.now(), Duration::from_millis(40), "time does not run back");
}

#[test]
fn the_same_settings_and_bytes_give_the_same_bytes_in_any_portions() {
    let run = |portion_ms: u64| {
        let mut boat = boat(|settings| settings.sensors = SensorSettings::typical()).unwrap();
        boat.link_up(LinkId(1));
        let mut bytes = Vec::new();
        for end in (0..=6000).step_by(portion_ms as usize) {
            boat.advance(Duration::from_millis(end));
            bytes.extend(sent(&mut boat));
        }
        bytes
    };
    let reference = run(20);
    assert!(reference.len() > 1000);
    assert_eq!(run(20), reference);
    assert_eq!(run(200), reference);
    assert_eq!(run(1000), reference);
}

#[test]
fn a_current_waits_until_the_boat_is_armed() {
    let current = Some("0.5@90".parse().unwrap());
    let mut boat = boat(|settings| settings.sea = Sea { current, ..Sea::default() }).unwrap();
    boat.advance(Duration::from_secs(10));
    assert!(boat.truth().hull.east_m.abs() < 1e-9);
    assert!(boat.autopilot.arm(false));
    boat.advance(Duration::from_secs(20));
    assert!(boat.truth().hull.east_m > 4.0, "{:?}", boat.truth());
}

#[test]
fn whoever_comes_hears_a_heartbeat_within_a_second() {
    let mut boat = boat(|_| {}).unwrap();
    for (number, comes_at_ms) in [(1, 0), (2, 2020), (3, 5980)] {
        let (link, comes_at) = (LinkId(number), Duration::from_millis(comes_at_ms));
        boat.advance(comes_at);
        boat.link_up(link);
        while boat.poll_transmit().is_some() {}
        let heard = (1..=51).find(|loops| {
            boat.advance(comes_at + LOOP * *loops);
            let mut framer = Framer::new();
            while let Some((to, bytes)) = boat.poll_transmit() {
                if to == link {
                    framer.push(&bytes);
                }
            }
            std::iter::from_fn(|| framer.next_frame().map(|frame| frame.message_id())).any(|id| id == 0)
        });
        assert!(heard.is_some_and(|loops| loops <= 50), "{heard:?} loops after {comes_at:?}");
    }
}

#[test]
fn unknown_links_are_ignored() {
    let mut boat = boat(|_| {}).unwrap();
    boat.on_bytes(LinkId(9), &[0xFD, 1, 2, 3]);
    boat.link_down(LinkId(9));
    boat.advance(Duration::from_secs(1));
    assert!(boat.poll_transmit().is_none());
}
