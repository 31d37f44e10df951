//! Reads from the flight controller the parameters that the outputs depend on.

use std::time::Duration;

use helmlink_wire::dialect::{CharArray, PARAM_REQUEST_READ_DATA, PARAM_VALUE_DATA};
use helmlink_wire::{Identity, Message};

/// A request is repeated after this long without an answer.
const TIMEOUT: Duration = Duration::from_millis(700);
/// A parameter that has not been answered after this many requests does not exist there: ArduPilot keeps silent
/// about names it does not know.
const ATTEMPTS: u32 = 5;

/// Requests for a parameter that not every vehicle has, before it is no longer waited for.
const OPTIONAL_ATTEMPTS: u32 = 2;

/// A parameter on which it depends whether the boat obeys at all is read again this often: somebody may change it, and
/// the message that says so may be lost.
const RECHECK: Duration = Duration::from_secs(5);

/// One parameter to be read.
#[derive(Debug, Clone)]
struct Wanted {
    name: &'static str,
    value: Option<f32>,
    /// Nothing has to wait for it for long.
    optional: bool,
    /// It is read again from time to time.
    watched: bool,
    attempts: u32,
    last_asked: Option<Duration>,
}

/// Reads a fixed list of parameters by name, and keeps up with changes announced later.
#[derive(Debug, Clone)]
pub struct ParameterReader {
    wanted: Vec<Wanted>,
}

impl ParameterReader {
    /// Will read `names` (at most 16 characters each).
    pub fn new(names: &[&'static str]) -> Self {
        let mut reader = Self { wanted: Vec::new() };
        reader.require(names);
        reader
    }

    /// Will read these too.
    pub fn require(&mut self, names: &[&'static str]) {
        self.add(names, false);
    }

    /// Will read these too, but counts them as missing after the second request without an answer; goes on asking all
    /// the same.
    pub fn wish_for(&mut self, names: &[&'static str]) {
        self.add(names, true);
    }

    /// Will read these of the parameters again every few seconds, where the vehicle has them.
    pub fn watch(&mut self, names: &[&str]) {
        for wanted in &mut self.wanted {
            wanted.watched |= names.contains(&wanted.name);
        }
    }

    fn add(&mut self, names: &[&'static str], optional: bool) {
        for &name in names {
            if self.wanted.iter().all(|wanted| wanted.name != name) {
                let (value, watched, attempts, last_asked) = (None, false, 0, None);
                self.wanted.push(Wanted { name, value, optional, watched, attempts, last_asked });
            }
        }
    }

    /// Takes a PARAM_VALUE; true when it is one of ours and its value is new.
    pub fn on_value(&mut self, data: &PARAM_VALUE_DATA) -> bool {
        let Ok(name) = data.param_id.to_str() else { return false };
        let Some(wanted) = self.wanted.iter_mut().find(|wanted| wanted.name == name) else { return false };
        let is_new = data.param_value.is_finite() && wanted.value != Some(data.param_value);
        if is_new {
            wanted.value = Some(data.param_value);
        }
        is_new
    }

    /// The next request that is due.
    pub fn poll(&mut self, now: Duration, vehicle: Identity) -> Option<Message> {
        let due = self.wanted.iter_mut().find(|wanted| {
            let asked_within = |limit| wanted.last_asked.is_some_and(|then| now.saturating_sub(then) < limit);
            let is_missing = wanted.value.is_none() && wanted.attempts < ATTEMPTS && !asked_within(TIMEOUT);
            is_missing || (wanted.watched && !asked_within(RECHECK))
        })?;
        due.attempts = due.attempts.saturating_add(1);
        due.last_asked = Some(now);
        Some(Message::PARAM_REQUEST_READ(PARAM_REQUEST_READ_DATA {
            target_system: vehicle.system,
            target_component: vehicle.component,
            param_index: -1,
            param_id: CharArray::from(due.name),
        }))
    }

    /// Every parameter has been answered, or has been given up.
    pub fn is_complete(&self) -> bool {
        self.wanted.iter().all(|wanted| {
            let enough = if wanted.optional { OPTIONAL_ATTEMPTS } else { ATTEMPTS };
            wanted.value.is_some() || wanted.attempts >= enough
        })
    }

    /// The value of `name`; `None` while unknown, and for ever when the vehicle does not have it.
    pub fn value(&self, name: &str) -> Option<f64> {
        self.wanted.iter().find(|wanted| wanted.name == name).and_then(|wanted| wanted.value).map(f64::from)
    }

    /// Reads everything anew: after a reboot of the flight controller. Nothing is known until it has answered.
    pub fn ask_again(&mut self) {
        for wanted in &mut self.wanted {
            (wanted.value, wanted.attempts, wanted.last_asked) = (None, 0, None);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const VEHICLE: Identity = Identity { system: 1, component: 1 };

    fn value(name: &str, param_value: f32) -> PARAM_VALUE_DATA {
        PARAM_VALUE_DATA { param_id: CharArray::from(name), param_value, ..PARAM_VALUE_DATA::DEFAULT }
    }

    #[test]
    fn reads_retries_and_gives_up() {
        let mut reader = ParameterReader::new(&["WP_SPEED", "NO_SUCH_PARAM"]);
        let mut requests = 0;
        for tenth in 0..100 {
            let now = Duration::from_millis(tenth * 100);
            while reader.poll(now, VEHICLE).is_some() {
                requests += 1;
            }
            if tenth == 10 {
                assert!(reader.on_value(&value("WP_SPEED", 2.0)));
            }
        }
        assert!(reader.is_complete());
        assert_eq!(requests, 2 + ATTEMPTS);
        assert_eq!(reader.value("WP_SPEED"), Some(2.0));
        assert_eq!(reader.value("NO_SUCH_PARAM"), None);
        assert!(!reader.on_value(&value("WP_SPEED", 2.0)), "nothing new");
        assert!(!reader.on_value(&value("WP_SPEED", f32::NAN)));
        assert!(reader.on_value(&value("WP_SPEED", 3.0)), "changed by somebody else");
        reader.ask_again();
        assert!(!reader.is_complete() && reader.value("WP_SPEED").is_none(), "it may be another one now");
    }

    #[test]
    fn what_the_boat_s_obedience_hangs_on_is_read_again_and_again() {
        let mut reader = ParameterReader::new(&["SYSID_MYGCS", "WP_SPEED"]);
        reader.watch(&["SYSID_MYGCS"]);
        let mut requests = Vec::new();
        for tenth in 0..200 {
            while let Some(Message::PARAM_REQUEST_READ(data)) =
                reader.poll(Duration::from_millis(tenth * 100), VEHICLE)
            {
                let name = data.param_id.to_str().unwrap().to_owned();
                reader.on_value(&value(&name, 255.0));
                requests.push(name);
            }
        }
        assert_eq!(requests.iter().filter(|name| *name == "SYSID_MYGCS").count(), 4, "{requests:?}");
        assert_eq!(requests.len(), 5);
    }
}
