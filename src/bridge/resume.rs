//! Going on after the bridge itself has died.
//!
//! While it drives, the bridge keeps a [`ResumePoint`]. A bridge that is started with it goes on by itself, when
//! every rule of [`ResumePoint::check`] holds; otherwise it says which does not, and waits to be told.

use helmlink_mission::geodesy::Geodetic;
use helmlink_mission::plan::Mission;
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};
use thiserror::Error;

use super::Bridge;
use crate::pilot::MissionRun;
use crate::pilot::supervisor::{Request, State};
use crate::vehicle::Mode;
use helmlink_wire::enums;

/// A drive that was broken off longer ago than this is not taken up again, seconds of the flight controller's clock.
const LONGEST_GAP_S: f64 = 600.0;
/// The boat may be this far from where it was, metres…
const DRIFT_M: f64 = 20.0;
/// …and farther by its largest speed times the time that has passed, times this.
const DRIFT_MARGIN: f64 = 1.2;

/// What is needed to go on. All times are the flight controller's own, so no wall clock matters.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ResumePoint {
    /// SHA-256 of the mission's items.
    pub mission: String,
    /// The mission item that was being driven to.
    pub item: u16,
    /// The flight controller's clock, seconds since its boot.
    pub boot_s: f64,
    /// Where the boat was.
    pub latitude_deg: f64,
    /// Where the boat was.
    pub longitude_deg: f64,
    /// The bridge was driving; false after every orderly end.
    pub driving: bool,
}

/// What a resuming bridge has found.
#[derive(Debug, Clone, PartialEq)]
pub struct Found {
    /// SHA-256 of the mission's items.
    pub mission: String,
    /// The flight controller's clock, seconds since its boot.
    pub boot_s: f64,
    /// Where the boat is.
    pub place: Geodetic,
    /// The motors may turn.
    pub armed: bool,
    /// The mode.
    pub mode: Mode,
    /// The mode that the bridge drives in.
    pub drive_mode: Mode,
    /// The boat's largest speed, m/s.
    pub speed_max_mps: f64,
}

/// Why a drive is not taken up again.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum NotResumed {
    /// It ended in order.
    #[error("the last drive ended in order")]
    Ended,
    /// The mission is another one.
    #[error("the mission is not the one that was being driven")]
    OtherMission,
    /// The flight controller has restarted.
    #[error("the flight controller has restarted since")]
    Rebooted,
    /// Too long ago.
    #[error("that was {0:.0} s ago, longer than {LONGEST_GAP_S:.0} s")]
    TooLongAgo(f64),
    /// The boat is too far away.
    #[error("the boat is {0:.0} m from where it was")]
    Elsewhere(f64),
    /// The motors are disarmed.
    #[error("the motors are disarmed")]
    Disarmed,
    /// Somebody has chosen another mode.
    #[error("somebody has chosen {0}")]
    PilotTookOver(Mode),
}

impl ResumePoint {
    /// Whether the drive may be taken up again.
    ///
    /// The flight controller must be in the mode the bridge drives in, or in HOLD, which is where its own failsafe puts
    /// a boat whose companion has died.
    ///
    /// # Errors
    /// The first rule that does not hold.
    pub fn check(&self, found: &Found) -> Result<(), NotResumed> {
        let gap_s = found.boot_s - self.boot_s;
        let was_at = Geodetic::new(self.latitude_deg, self.longitude_deg);
        let away_m = was_at.distance_m(found.place);
        if !self.driving {
            Err(NotResumed::Ended)
        } else if self.mission != found.mission {
            Err(NotResumed::OtherMission)
        } else if gap_s.is_nan() || gap_s < 0.0 {
            Err(NotResumed::Rebooted)
        } else if gap_s > LONGEST_GAP_S {
            Err(NotResumed::TooLongAgo(gap_s))
        } else if away_m.is_nan() || away_m > DRIFT_M + DRIFT_MARGIN * found.speed_max_mps * gap_s {
            Err(NotResumed::Elsewhere(away_m))
        } else if !found.armed {
            Err(NotResumed::Disarmed)
        } else if found.mode != found.drive_mode && found.mode != Mode::HOLD {
            Err(NotResumed::PilotTookOver(found.mode))
        } else {
            Ok(())
        }
    }
}

/// SHA-256 of a mission's items, as hexadecimal digits. Home is left out: it moves with every arming.
pub fn checksum(mission: &Mission) -> String {
    let mut digest = Sha256::new();
    for item in &mission.items {
        digest.update(item.command.to_le_bytes());
        digest.update([item.frame]);
        for param in item.params {
            // Which not-a-number a parameter is makes no difference.
            digest.update(if param.is_nan() { f32::NAN } else { param }.to_bits().to_le_bytes());
        }
        digest.update(item.x.to_le_bytes());
        digest.update(item.y.to_le_bytes());
    }
    digest.finalize().iter().map(|byte| format!("{byte:02x}")).collect()
}

impl Bridge {
    /// What a later bridge needs to go on, once there is a mission and a position; to be kept on disk.
    pub fn resume_point(&self) -> Option<ResumePoint> {
        let place = self.telemetry.position?.value.place;
        Some(ResumePoint {
            mission: self.mission.checksum()?.to_owned(),
            item: self.run.as_ref().and_then(super::steering::current_item)?,
            boot_s: self.telemetry.boot_s?,
            latitude_deg: place.latitude_deg,
            longitude_deg: place.longitude_deg,
            driving: matches!(self.supervisor.state(), State::Engaging | State::Engaged),
        })
    }

    /// Takes up the drive that an earlier bridge left, if that was asked for and may be done.
    pub(super) fn try_to_resume(&mut self) {
        if self.supervisor.state() != State::Ready || self.settings.resume.is_none() {
            return;
        }
        let Some(found) = self.found() else { return };
        let Some(point) = self.settings.resume.take() else { return };
        if let Err(why) = point.check(&found) {
            return self.event(enums::MAV_SEVERITY_WARNING, format!("not resumed: {why}"));
        }
        let index = |run: &MissionRun| run.route().waypoints.iter().position(|w| w.item == point.item);
        let Some(index) = self.run.as_ref().and_then(index) else {
            return self
                .event(enums::MAV_SEVERITY_WARNING, format!("not resumed: {}", NotResumed::OtherMission));
        };
        if let Some(run) = &mut self.run {
            run.join(index, found.place);
        }
        self.event(enums::MAV_SEVERITY_WARNING, format!("resuming at item {}", point.item));
        let conditions = self.conditions();
        let request = Request::Engage { patient: false };
        // The mission has just been read: it is not read once more, as after other requests.
        if let Err(why) = self.supervisor.request(self.now.as_secs_f64(), request, &conditions) {
            self.event(enums::MAV_SEVERITY_WARNING, format!("not resumed: {why}"));
        }
        self.supervise();
    }

    fn found(&self) -> Option<Found> {
        Some(Found {
            mission: self.mission.checksum()?.to_owned(),
            boot_s: self.telemetry.boot_s?,
            place: self.telemetry.position?.value.place,
            armed: self.telemetry.is_armed(),
            mode: self.telemetry.mode()?,
            drive_mode: self.settings.output.mode(),
            speed_max_mps: self.settings.boat.limits.speed_max_mps,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn point() -> ResumePoint {
        ResumePoint {
            mission: "a".into(),
            item: 3,
            boot_s: 100.0,
            latitude_deg: 63.44,
            longitude_deg: 10.4,
            driving: true,
        }
    }

    fn found() -> Found {
        Found {
            mission: "a".into(),
            boot_s: 105.0,
            place: Geodetic::new(63.4401, 10.4),
            armed: true,
            mode: Mode::MANUAL,
            drive_mode: Mode::MANUAL,
            speed_max_mps: 2.5,
        }
    }

    #[test]
    fn every_rule_is_asked() {
        assert_eq!(point().check(&found()), Ok(()));
        assert_eq!(point().check(&Found { mode: Mode::HOLD, ..found() }), Ok(()));
        let refused = |point: &ResumePoint, found: Found| point.check(&found).unwrap_err();
        assert_eq!(refused(&ResumePoint { driving: false, ..point() }, found()), NotResumed::Ended);
        assert_eq!(refused(&point(), Found { mission: "b".into(), ..found() }), NotResumed::OtherMission);
        assert_eq!(refused(&point(), Found { boot_s: 20.0, ..found() }), NotResumed::Rebooted);
        assert_eq!(refused(&point(), Found { boot_s: 800.0, ..found() }), NotResumed::TooLongAgo(700.0));
        assert_eq!(refused(&point(), Found { armed: false, ..found() }), NotResumed::Disarmed);
        let loiter = Found { mode: Mode::LOITER, ..found() };
        assert_eq!(refused(&point(), loiter), NotResumed::PilotTookOver(Mode::LOITER));
        let far = Found { place: Geodetic::new(63.45, 10.4), ..found() };
        assert!(matches!(refused(&point(), far), NotResumed::Elsewhere(m) if m > 1000.0));
        let nowhere = Found { place: Geodetic::new(f64::NAN, 10.4), ..found() };
        assert!(matches!(refused(&point(), nowhere), NotResumed::Elsewhere(_)));
    }

    #[test]
    fn a_point_survives_the_file() {
        let text = serde_json::to_string(&point()).unwrap();
        assert_eq!(serde_json::from_str::<ResumePoint>(&text).unwrap(), point());
    }
}
