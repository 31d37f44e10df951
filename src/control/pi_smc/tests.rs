use proptest::prelude::*;

use super::*;

fn part(name: &str, dt_s: f64, predicted_s: f64) -> f64 {
    PiSmc::new(&Boat::embedded(name).unwrap()).gain_part(dt_s, predicted_s)
}

#[test]
fn all_of_the_gains_are_used_where_the_loop_is_quick_enough() {
    for name in Boat::names() {
        for (dt_s, predicted_s) in [(0.02, 0.0), (0.04, 0.5), (0.1, 0.0)] {
            assert_eq!(part(name, dt_s, predicted_s), 1.0, "{name} {dt_s} {predicted_s}");
        }
    }
    assert_eq!(part("otter", 0.2, 0.0), 1.0);
    assert!(part("motorboat", 0.2, 0.0) < 0.9);
    assert!(part("motorboat", 0.04, 1.0) < 0.8);
}

proptest! {
    #[test]
    fn no_loop_is_too_slow_for_the_gains_in_use(
        boat in prop::sample::select(Boat::names().collect::<Vec<_>>()), dt_s in 0.02..1.0f64, predicted_s in 0.0..1.5f64,
    ) {
        let mut law = PiSmc::new(&Boat::embedded(boat).unwrap());
        let part = law.gain_part(dt_s, predicted_s);
        let gain = part * law.yaw.total_gain() * (dt_s + BLIND_PART * predicted_s);
        prop_assert!(part > 0.0 && part <= 1.0 && gain < MOST_GAIN_BY_TIME + 1.0e-9, "{part} {gain}");
    }
}

#[test]
fn one_long_step_changes_little() {
    let mut law = PiSmc::new(&Boat::embedded("motorboat").unwrap());
    let steady: Vec<f64> = (0..50).map(|_| law.gain_part(0.04, 0.0)).collect();
    assert_eq!(steady[49], 1.0);
    assert_eq!(law.gain_part(0.4, 0.0), 1.0, "a gap");
    let slow = (0..100).map(|_| law.gain_part(0.2, 0.0)).last().unwrap();
    assert!(slow < 0.9, "{slow}");
}
