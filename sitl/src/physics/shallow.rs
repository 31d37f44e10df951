//! What shallow water costs: the bottom slows the waves of the hull and speeds up the flow around it.
//!
//! H. Lackenby 1963, "The effect of shallow water on ship speed", Shipbuilder 70, in the form of ITTC Recommended
//! Procedure 7.5-04-01-01 (until 2021): at the same thrust a ship whose deep-water speed is V loses
//! `ΔV/V = 0.1242·(A_M/H² − 0.05) + 1 − √tanh(gH/V²)`, the first term where A_M/H² > 0.05; A_M is the immersed
//! midship section, H the depth. The second term is O. Schlichting's (1934): a wave as long as that of V in deep
//! water runs slower over the bottom.

use super::GRAVITY_MPS2;
use super::hull::{Damping, Maneuvering, ShallowWater};

/// Newton's method comes from below and is done to the last bits after a few of these.
const ITERATIONS: u32 = 12;

/// A hull over a bottom at one depth.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Shoal {
    depth_m: f64,
    /// Share of speed lost to the return flow, from 0 up to 0.118.
    blockage: f64,
}

impl Shoal {
    /// At depths below the hull's smallest one that one is taken: the formula's domain ends there.
    pub(super) fn new(hull: &ShallowWater, depth_m: f64) -> Shoal {
        let depth_m = depth_m.max(hull.least_depth_m());
        let blockage = 0.1242 * (hull.midship_area_m2 / (depth_m * depth_m) - 0.05).max(0.0);
        Shoal { depth_m, blockage }
    }

    /// Share of its speed in deep water, m/s, that a hull loses here. From the critical speed √(gH) on, where the
    /// formula ends, the loss stays what it is there.
    fn loss(&self, deep_mps: f64) -> f64 {
        self.blockage + 1.0 - self.wave_share(deep_mps)
    }

    fn wave_share(&self, deep_mps: f64) -> f64 {
        let squared = (deep_mps * deep_mps).min(GRAVITY_MPS2 * self.depth_m);
        // A boat at rest makes no waves: tanh of infinity is 1.
        (GRAVITY_MPS2 * self.depth_m / squared).tanh().sqrt()
    }

    /// How many times faster the hull would be in deep water than at `speed_mps` here, at the same drag: V/u ≥ 1
    /// with V·(1 − ΔV/V) = u.
    fn speed_ratio(&self, speed_mps: f64) -> f64 {
        let speed_mps = speed_mps.abs();
        let critical_mps = (GRAVITY_MPS2 * self.depth_m).sqrt();
        let reached_mps = critical_mps * (1.0 - self.loss(critical_mps));
        if speed_mps >= reached_mps {
            return 1.0 / (1.0 - self.loss(critical_mps));
        }
        let slowest = 1.0 / (1.0 - self.blockage);
        let mut deep_mps = speed_mps * slowest;
        if deep_mps < 1e-6 * critical_mps {
            return slowest;
        }
        // u(V) rises and is concave below the critical speed: from below, Newton's method never overshoots.
        for _ in 0..ITERATIONS {
            let share = self.wave_share(deep_mps);
            let ratio = GRAVITY_MPS2 * self.depth_m / (deep_mps * deep_mps);
            let slope = share - ratio * (1.0 - share.powi(4)) / share - self.blockage;
            deep_mps += (speed_mps - deep_mps * (share - self.blockage)) / slope;
        }
        deep_mps / speed_mps
    }

    /// The hull with the surge drag it has here at this speed through the water, m/s.
    pub(super) fn slowed(&self, hull: &Maneuvering, speed_mps: f64) -> Maneuvering {
        let ratio = self.speed_ratio(speed_mps);
        let Damping { linear, quadratic, cubic } = hull.surge;
        let surge = Damping {
            linear: linear * ratio,
            quadratic: quadratic * ratio * ratio,
            cubic: cubic * ratio * ratio * ratio,
        };
        Maneuvering { surge, ..*hull }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::super::{ActuatorCommand, Hull, Pose, Sea, SensorSettings, Vessel};
    use super::*;

    const BOATS: [&str; 3] = ["otter", "monohull38", "skiff"];

    /// Speed after two minutes at half throttle.
    fn speed_mps(name: &str, depth_m: Option<f64>) -> f64 {
        let sea = Sea { depth_m, ..Sea::default() };
        let hull = Hull::builtin(name).unwrap();
        let mut boat = Vessel::new(hull, &sea, &SensorSettings::perfect(), 1, Pose::default());
        let ahead = ActuatorCommand::ThrottleSteering { throttle: 0.5, steering: 0.0 };
        boat.step(60.0, ahead);
        boat.step(60.0, ahead);
        boat.truth().hull.u_mps
    }

    #[test]
    fn lackenbys_loss_is_the_published_one() {
        // A_M/H² = 0.1: 0.1242·0.05 = 0.00621. V²/gH = 0.5: 1 − √tanh 2 = 1 − √0.964028 = 0.018151.
        let shoal = Shoal::new(&ShallowWater { midship_area_m2: 0.4, draft_m: 0.5 }, 2.0);
        let loss = shoal.loss((0.5 * GRAVITY_MPS2 * 2.0).sqrt());
        assert!((loss - 0.024361).abs() < 1e-6, "{loss}");
        // At the critical speed the waves alone take 1 − √tanh 1 = 12.73 %.
        let loss = shoal.loss(100.0);
        assert!((loss - 0.00621 - 0.127308).abs() < 1e-5, "{loss}");
    }

    #[test]
    fn at_the_same_thrust_a_boat_is_slower_by_lackenbys_loss() {
        for (name, depth_m) in [("otter", 0.5), ("skiff", 0.6), ("monohull38", 6.0)] {
            let (deep_mps, shallow_mps) = (speed_mps(name, None), speed_mps(name, Some(depth_m)));
            let hull = Hull::builtin(name).unwrap().shallow_water.unwrap();
            let loss = Shoal::new(&hull, depth_m).loss(deep_mps);
            println!(
                "{name}: {deep_mps:.3} m/s, {shallow_mps:.3} m/s over {depth_m} m ({:.1} %)",
                100.0 * loss
            );
            // The thrust of these drives hardly depends on the speed; what it does gives back a part of the loss.
            assert!(
                loss > 0.01 && (1.0 - shallow_mps / deep_mps - loss).abs() < 0.2 * loss,
                "{name}: {loss}"
            );
        }
    }

    #[test]
    fn deep_water_is_as_no_bottom_at_all_to_the_last_bit() {
        for name in BOATS {
            assert_eq!(speed_mps(name, Some(1000.0)).to_bits(), speed_mps(name, None).to_bits(), "{name}");
        }
    }

    #[test]
    fn the_shallower_the_slower() {
        for name in BOATS {
            let least_m = Hull::builtin(name).unwrap().shallow_water.unwrap().least_depth_m();
            let speeds = [1.0, 1.5, 2.0, 3.0].map(|times| speed_mps(name, Some(times * least_m)));
            assert!(speeds.windows(2).all(|pair| pair[0] < pair[1]), "{name}: {speeds:?}");
            assert!(speeds[3] <= speed_mps(name, None), "{name}: {speeds:?}");
        }
    }

    proptest! {
        /// The ratio undoes the loss, whatever hull, depth and speed.
        #[test]
        fn the_speed_in_deep_water_is_found(area_m2 in 0.001f64..100.0, depth in 1.0f64..100.0, froude in 0.0f64..3.0) {
            let hull = ShallowWater { midship_area_m2: area_m2, draft_m: 0.1 * area_m2.sqrt() };
            let shoal = Shoal::new(&hull, depth * hull.least_depth_m());
            let deep_mps = froude * (GRAVITY_MPS2 * shoal.depth_m).sqrt();
            let speed_mps = deep_mps * (1.0 - shoal.loss(deep_mps));
            let ratio = shoal.speed_ratio(-speed_mps);
            prop_assert!((1.0..1.5).contains(&ratio), "{ratio}");
            prop_assert!((ratio * speed_mps - deep_mps).abs() <= 1e-9 * (1.0 + deep_mps));
        }
    }
}
