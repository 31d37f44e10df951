//! The virtual ship of the paper (Eq. 5), led along the path by arc length.
//!
//! Its place is one number, s_d with ṡ_d = u_d; position, heading and turn rate are read off the path in
//! closed form. Integrating Eq. (5) step by step instead moves every later leg by the rounding of each switch.
//! Left to run on time alone it runs away from a boat that cannot keep up, and the boat cuts across the path;
//! so its speed depends on its lead.

/// Shortest lead, as a part of the wanted one: with less, the heading loop goes unstable.
const LEAST_LEAD_PART: f64 = 0.8;
/// Longest lead, as a part of the wanted one.
const MOST_LEAD_PART: f64 = 1.6;
/// The virtual ship never runs faster than this many times the wanted speed.
pub(super) const MOST_SPEED_PART: f64 = 1.5;

/// The virtual ship's place and speed.
#[derive(Debug, Clone, Copy, Default)]
pub struct VirtualShip {
    progress_m: f64,
    speed_mps: f64,
}

impl VirtualShip {
    /// Puts the ship at arc length `progress_m`.
    #[must_use]
    pub fn at(progress_m: f64) -> Self {
        Self { progress_m, speed_mps: 0.0 }
    }

    /// Moves the ship by `dt_s`.
    ///
    /// `boat_m` and `boat_mps` are the boat's own s_p and ṡ_p, `wanted_mps` the wanted speed, `lead_m` the
    /// wanted lead l_d and `softness_m` the l_w of u_d = u_ref·sat(1 − (lead − l_d)/l_w).
    pub fn step(
        &mut self,
        dt_s: f64,
        boat_m: f64,
        boat_mps: f64,
        wanted_mps: f64,
        lead_m: f64,
        softness_m: f64,
    ) {
        let lead = self.progress_m - boat_m;
        let part = (1.0 - (lead - lead_m) / softness_m).clamp(0.0, MOST_SPEED_PART);
        self.speed_mps = wanted_mps * part;
        let free = self.progress_m + self.speed_mps * dt_s;
        self.progress_m = free.clamp(boat_m + LEAST_LEAD_PART * lead_m, boat_m + MOST_LEAD_PART * lead_m);
        if self.progress_m != free {
            // Held at a limit of the lead the ship moves as the boat does.
            self.speed_mps = boat_mps;
        }
    }

    /// Arc length s_d, m.
    #[must_use]
    pub fn progress_m(&self) -> f64 {
        self.progress_m
    }

    /// Speed u_d along the path, m/s.
    #[must_use]
    pub fn speed_mps(&self) -> f64 {
        self.speed_mps
    }
}
