//! The settings of the autopilot under their ArduPilot names, as ground stations list and change them.

mod packed;
mod service;
pub(super) mod table;

use std::collections::BTreeMap;

use helmlink_wire::enums::{
    MAV_PARAM_TYPE_INT8, MAV_PARAM_TYPE_INT16, MAV_PARAM_TYPE_INT32, MAV_PARAM_TYPE_REAL32,
};

pub(super) use service::Listing;
pub(super) use table::*;

/// The four storage types ArduPilot uses.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    Int8,
    Int16,
    Int32,
    Real32,
}

impl Kind {
    /// MAV_PARAM_TYPE of the storage type.
    pub(super) fn to_wire(self) -> u8 {
        match self {
            Self::Int8 => MAV_PARAM_TYPE_INT8,
            Self::Int16 => MAV_PARAM_TYPE_INT16,
            Self::Int32 => MAV_PARAM_TYPE_INT32,
            Self::Real32 => MAV_PARAM_TYPE_REAL32,
        }
    }

    /// The nearest value the type can hold: integers are cut, with a little slack for values such as 2.999.
    fn cast(self, value: f32) -> f32 {
        const SLACK: f32 = 0.01;
        match self {
            Self::Real32 => value,
            Self::Int8 | Self::Int16 | Self::Int32 => (value + SLACK.copysign(value)).trunc(),
        }
    }
}

/// One parameter, by its place in the table.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Param(pub(super) usize);

/// What a parameter is.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Definition {
    /// Name, at most 16 characters.
    pub(super) name: String,
    pub(super) kind: Kind,
    pub(super) default: f32,
    /// Smallest and largest value that may be set.
    pub(super) range: (f32, f32),
    /// Whether ground stations may not set it.
    pub(super) read_only: bool,
}

/// Why a parameter was not set.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub(super) enum SetError {
    /// No parameter has that name.
    #[error("no such parameter")]
    Unknown,
    /// Outside the range of the table, or not a number.
    #[error("the value is outside the allowed range")]
    OutOfRange,
    /// The autopilot sets it itself.
    #[error("the parameter is read-only")]
    ReadOnly,
}

/// All parameters with their values.
#[derive(Debug, Clone)]
pub(super) struct Parameters {
    definitions: Vec<Definition>,
    values: Vec<f32>,
    /// The values that the user has started from.
    base: Vec<f32>,
    by_name: BTreeMap<String, Param>,
    /// Grows with every change of a value.
    revision: u64,
}

impl Parameters {
    /// Every parameter at its default.
    pub(super) fn new() -> Self {
        let definitions = table::definitions();
        let values: Vec<f32> = definitions.iter().map(|definition| definition.default).collect();
        let by_name =
            definitions.iter().enumerate().map(|(at, each)| (each.name.clone(), Param(at))).collect();
        Self { base: values.clone(), definitions, values, by_name, revision: 0 }
    }

    /// The value of a parameter.
    pub(super) fn get(&self, param: Param) -> f64 {
        f64::from(self.value(param))
    }

    /// The value of an integer parameter.
    pub(super) fn int(&self, param: Param) -> i32 {
        self.value(param) as i32
    }

    fn value(&self, param: Param) -> f32 {
        self.values.get(param.0).copied().unwrap_or_default()
    }

    /// Sets a parameter to its default.
    pub(super) fn reset(&mut self, param: Param) {
        if let Some(default) = self.definitions.get(param.0).map(|definition| definition.default) {
            self.put(param, default);
        }
    }

    /// Counts as a change although no value has changed.
    pub(super) fn touch(&mut self) {
        self.revision += 1;
    }

    /// A number that changes whenever a value does.
    pub(super) fn revision(&self) -> u64 {
        self.revision
    }

    /// Number of parameters.
    pub(super) fn count(&self) -> usize {
        self.values.len()
    }

    /// The parameter called `name`.
    pub(super) fn find(&self, name: &str) -> Option<Param> {
        self.by_name.get(name).copied()
    }

    /// What the parameter at `index` is, with its value.
    pub(super) fn at(&self, index: usize) -> Option<(&Definition, f32)> {
        Some((self.definitions.get(index)?, *self.values.get(index)?))
    }

    /// Sets a parameter on behalf of a user. Integers are cut to whole numbers.
    pub(super) fn set(&mut self, name: &str, value: f32) -> Result<Param, SetError> {
        let param = self.find(name).ok_or(SetError::Unknown)?;
        let definition = self.definitions.get(param.0).ok_or(SetError::Unknown)?;
        if definition.read_only {
            return Err(SetError::ReadOnly);
        }
        let value = definition.kind.cast(value);
        let (least, most) = definition.range;
        // Written so that NaN is refused too.
        if !(least..=most).contains(&value) {
            return Err(SetError::OutOfRange);
        }
        self.put(param, value);
        Ok(param)
    }

    /// Sets a parameter on behalf of the autopilot, cut to its range.
    pub(super) fn put(&mut self, param: Param, value: f32) {
        if let (Some(slot), Some(definition)) = (self.values.get_mut(param.0), self.definitions.get(param.0))
            && value.is_finite()
        {
            let value = definition.kind.cast(value.clamp(definition.range.0, definition.range.1));
            if *slot != value {
                *slot = value;
                self.revision += 1;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn names_are_unique_and_short_and_defaults_lie_in_their_ranges() {
        let parameters = Parameters::new();
        assert_eq!(parameters.by_name.len(), parameters.definitions.len(), "a name is used twice");
        for definition in &parameters.definitions {
            assert!(definition.name.len() <= 16, "{} is too long", definition.name);
            let (least, most) = definition.range;
            assert!((least..=most).contains(&definition.default), "{}", definition.name);
            assert_eq!(definition.kind.cast(definition.default), definition.default, "{}", definition.name);
        }
    }

    #[test]
    fn constants_name_their_rows() {
        let parameters = Parameters::new();
        assert_eq!(parameters.find("WP_RADIUS"), Some(WP_RADIUS));
        assert_eq!(parameters.find("RC1_MIN"), Some(rc(1, RcField::Min)));
        assert_eq!(parameters.find("RC8_DZ"), Some(rc(8, RcField::Dz)));
        assert_eq!(parameters.find("SERVO3_FUNCTION"), Some(servo(3, ServoField::Function)));
        assert_eq!(parameters.find("SERVO8_REVERSED"), Some(servo(8, ServoField::Reversed)));
    }

    #[test]
    fn integers_are_cut_and_nonsense_is_refused() {
        let mut parameters = Parameters::new();
        assert_eq!(parameters.set("SYSID_MYGCS", 42.7), Ok(SYSID_MYGCS));
        assert_eq!(parameters.int(SYSID_MYGCS), 42);
        assert_eq!(parameters.set("SYSID_MYGCS", 2.9999), Ok(SYSID_MYGCS));
        assert_eq!(parameters.int(SYSID_MYGCS), 3);
        assert_eq!(parameters.set("SYSID_MYGCS", f32::NAN), Err(SetError::OutOfRange));
        assert_eq!(parameters.set("WP_RADIUS", -5.0), Err(SetError::OutOfRange));
        assert_eq!(parameters.set("MIS_TOTAL", 3.0), Err(SetError::ReadOnly));
        assert_eq!(parameters.set("NO_SUCH", 3.0), Err(SetError::Unknown));
        assert_eq!(parameters.int(SYSID_MYGCS), 3);
    }

    proptest! {
        #[test]
        fn what_is_accepted_is_read_back_within_its_range(index in 0usize..300, value in any::<f32>()) {
            let mut parameters = Parameters::new();
            let index = index % parameters.count();
            let definition = parameters.definitions[index].clone();
            if parameters.set(&definition.name, value).is_ok() {
                let stored = parameters.values[index];
                prop_assert!((definition.range.0..=definition.range.1).contains(&stored));
                prop_assert!((stored - value).abs() <= 1.0);
            } else {
                prop_assert_eq!(parameters.values[index], definition.default);
            }
        }
    }
}
