//! One pass over a log: which vehicle, which missions, which clock, and what is wrong with it.

use std::collections::BTreeMap;
use std::io::{self, Read};

use helmlink_mission::plan::{Fence, RallyPoint};
use helmlink_mission::protocol::MissionType;
use helmlink_wire::dialect::PARAM_VALUE_DATA;
use helmlink_wire::tlog::TlogReader;
use helmlink_wire::{Identity, LinkStatistics, Message};

use super::missions::{MissionListener, Transferred};
use crate::record::settings::HeaderParts;
use crate::record::{Header, RECORDER, SETTINGS};
use crate::vehicle::output::PARAMETERS;
use crate::vehicle::telemetry::{Sender, classify};

/// Wall and vehicle time that differ by less than this share agree.
const CLOCK_TOLERANCE: f64 = 0.02;
/// A vehicle time that falls back by more than this is a restart, seconds; less is disorder.
const RESTART_S: f64 = 20.0;

/// What one vehicle has sent.
#[derive(Debug, Clone, Default)]
pub struct VehicleSummary {
    /// Messages.
    pub messages: u64,
    /// ATTITUDE messages.
    pub attitudes: u64,
    /// GLOBAL_POSITION_INT messages.
    pub positions: u64,
    /// MISSION_ITEM_REACHED messages.
    pub reached: u64,
    /// A heartbeat of a boat or rover run by ArduPilot.
    pub is_boat: bool,
    /// It runs in ArduPilot's own simulator (SIMSTATE).
    pub is_simulated: bool,
    /// Vehicle time that has passed, seconds, restarts not counted.
    pub vehicle_s: f64,
    /// Time by the stamps between its first and last timed message, seconds.
    pub stamped_s: f64,
    /// How often it has restarted.
    pub restarts: u32,
    first_us: Option<u64>,
    last_boot_s: Option<f64>,
}

/// A log at a glance.
#[derive(Debug, Clone, Default)]
pub struct Scan {
    /// Records with a verified frame.
    pub records: u64,
    /// First time stamp, microseconds since 1970 UTC.
    pub first_us: u64,
    /// Latest time stamp.
    pub last_us: u64,
    /// Records stamped earlier than the one before.
    pub disordered: u64,
    /// The farthest that a stamp lies behind the latest, microseconds.
    pub farthest_us: u64,
    /// Every flight controller.
    pub vehicles: BTreeMap<Identity, VehicleSummary>,
    /// Missions transferred, in order, of the vehicle chosen.
    pub missions: Vec<Transferred>,
    /// The fence of the same vehicle, as it was transferred last.
    pub fence: Fence,
    /// Its rally points.
    pub rally: Vec<RallyPoint>,
    /// The last value of the parameters that the outputs depend on.
    pub parameters: Vec<PARAM_VALUE_DATA>,
    /// What stands at the head of a recording of helmlink's.
    pub header: Option<Header>,
    /// Why the head of a recording cannot be understood.
    pub header_fault: Option<String>,
    /// What the log holds and lacks.
    pub statistics: LinkStatistics,
}

impl Scan {
    /// Reads a whole log.
    ///
    /// # Errors
    /// Those of the source.
    pub fn of(source: impl Read) -> io::Result<Self> {
        let mut reader = TlogReader::new(source);
        let (mut scan, mut parts) = (Self::default(), HeaderParts::default());
        let mut listeners: BTreeMap<u8, [MissionListener; 3]> = BTreeMap::new();
        let mut plans: Vec<(u8, MissionType, Transferred)> = Vec::new();
        let mut previous_us = 0;
        while let Some(record) = reader.next_record()? {
            let (time_us, from) = (record.time_us, record.frame.identity());
            scan.on_stamp(time_us, &mut previous_us);
            let Ok(message) = record.frame.decode() else { continue };
            if from == RECORDER {
                scan.on_note(&message, &mut parts);
                continue;
            }
            scan.on_message(time_us, from, &message);
            for (system, listeners) in &mut listeners {
                for (kind, listener) in MissionType::ALL.into_iter().zip(listeners) {
                    if let Some(transferred) = listener.on_message(time_us, from, &message) {
                        plans.push((*system, kind, transferred));
                    }
                }
            }
            if scan.vehicles.contains_key(&from) {
                let listen = |kind| MissionListener::of(kind, from.system);
                listeners.entry(from.system).or_insert_with(|| MissionType::ALL.map(listen));
            }
        }
        scan.statistics = *reader.statistics();
        let system = scan.vehicle(None).map(|vehicle| vehicle.system);
        for (_, kind, transferred) in plans.into_iter().filter(|(of, ..)| Some(*of) == system) {
            scan.on_plan(kind, transferred);
        }
        Ok(scan)
    }

    /// A plan of the vehicle chosen. Fences and rally points that make no sense are not drawn.
    fn on_plan(&mut self, kind: MissionType, transferred: Transferred) {
        let items = &transferred.mission.items;
        match kind {
            MissionType::Mission => self.missions.push(transferred),
            MissionType::Fence => self.fence = Fence::from_items(items).unwrap_or_default(),
            MissionType::Rally => {
                self.rally = items.iter().filter_map(|item| RallyPoint::from_item(item).ok()).collect();
            }
        }
    }

    fn on_stamp(&mut self, time_us: u64, previous_us: &mut u64) {
        if self.records == 0 {
            (self.first_us, self.last_us) = (time_us, time_us);
        }
        self.records += 1;
        if time_us < *previous_us {
            self.disordered += 1;
            self.farthest_us = self.farthest_us.max(self.last_us.saturating_sub(time_us));
        }
        *previous_us = time_us;
        self.first_us = self.first_us.min(time_us);
        self.last_us = self.last_us.max(time_us);
    }

    fn on_note(&mut self, message: &Message, parts: &mut HeaderParts) {
        if let Message::TUNNEL(data) = message
            && data.payload_type == SETTINGS
            && self.header.is_none()
            && let Some(text) = parts.push(&data.payload[..usize::from(data.payload_length).min(128)])
        {
            match Header::from_text(&text) {
                Ok(header) => self.header = Some(header),
                Err(fault) => self.header_fault = Some(fault.to_string()),
            }
        }
    }

    fn on_message(&mut self, time_us: u64, from: Identity, message: &Message) {
        if let Message::HEARTBEAT(heartbeat) = message {
            match classify(from, heartbeat) {
                Sender::Boat => self.vehicles.entry(from).or_default().is_boat = true,
                Sender::WrongVehicle(..) => drop(self.vehicles.entry(from).or_default()),
                Sender::NotAVehicle => {}
            }
        }
        let Some(vehicle) = self.vehicles.get_mut(&from) else { return };
        vehicle.messages += 1;
        match message {
            Message::ATTITUDE(data) => {
                vehicle.attitudes += 1;
                vehicle.on_boot_time(time_us, f64::from(data.time_boot_ms) / 1000.0);
            }
            Message::GLOBAL_POSITION_INT(data) => {
                vehicle.positions += 1;
                vehicle.on_boot_time(time_us, f64::from(data.time_boot_ms) / 1000.0);
            }
            Message::MISSION_ITEM_REACHED(_) => vehicle.reached += 1,
            Message::SIMSTATE(_) => vehicle.is_simulated = true,
            Message::PARAM_VALUE(data) => self.on_parameter(data),
            _ => {}
        }
    }

    fn on_parameter(&mut self, data: &PARAM_VALUE_DATA) {
        if !data.param_id.to_str().is_ok_and(|name| PARAMETERS.contains(&name)) {
            return;
        }
        match self.parameters.iter_mut().find(|known| known.param_id == data.param_id) {
            Some(known) => *known = data.clone(),
            None => self.parameters.push(data.clone()),
        }
    }

    /// The vehicle of this system id, or the boat with the most positions.
    pub fn vehicle(&self, system: Option<u8>) -> Option<Identity> {
        self.vehicles
            .iter()
            .filter(|(identity, _)| system.is_none_or(|system| identity.system == system))
            .max_by_key(|(_, vehicle)| (vehicle.is_boat, vehicle.positions, vehicle.attitudes))
            .map(|(identity, _)| *identity)
    }
}

impl VehicleSummary {
    fn on_boot_time(&mut self, time_us: u64, boot_s: f64) {
        let first_us = *self.first_us.get_or_insert(time_us);
        self.stamped_s = self.stamped_s.max(time_us.saturating_sub(first_us) as f64 / 1e6);
        match self.last_boot_s {
            Some(last_s) if boot_s < last_s - RESTART_S => {
                self.restarts += 1;
                self.last_boot_s = Some(boot_s);
            }
            Some(last_s) if boot_s < last_s => {}
            Some(last_s) => {
                self.vehicle_s += boot_s - last_s;
                self.last_boot_s = Some(boot_s);
            }
            None => self.last_boot_s = Some(boot_s),
        }
    }

    /// Vehicle seconds per second of the stamps; 1 where the two agree, or nobody can tell.
    pub fn rate(&self) -> f64 {
        let rate = self.vehicle_s / self.stamped_s;
        if rate.is_finite() && rate > 0.0 && (rate - 1.0).abs() > CLOCK_TOLERANCE { rate } else { 1.0 }
    }

    /// Time between two attitudes, vehicle seconds.
    pub fn interval_s(&self) -> f64 {
        let interval_s = self.vehicle_s / self.attitudes.saturating_sub(1).max(1) as f64;
        interval_s.clamp(0.005, 1.0)
    }
}
