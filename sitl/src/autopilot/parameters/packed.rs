//! Parameters in bulk: the packed file that ground stations fetch, and the changed ones for a file on disk.

use super::{Definition, Kind, Parameters};

/// First word of the packed file, without and with defaults (ArduPilot, AP_Filesystem_Param.h).
const MAGIC: u16 = 0x671B;
const MAGIC_DEFAULTS: u16 = 0x671C;
/// Flag of an entry whose default follows its value.
const HAS_DEFAULT: u8 = 1 << 4;

impl Parameters {
    /// All parameters as `@PARAM/param.pck`: a header, then per parameter its type, how much of its name is
    /// that of the one before, the rest of its name, its value, and its default where it differs.
    pub(in crate::autopilot) fn packed(&self, with_defaults: bool) -> Vec<u8> {
        let count = u16::try_from(self.count()).unwrap_or(u16::MAX);
        let magic = if with_defaults { MAGIC_DEFAULTS } else { MAGIC };
        let mut file: Vec<u8> = [magic, count, count].iter().flat_map(|word| word.to_le_bytes()).collect();
        let mut last = "";
        for (definition, value) in (0..self.count()).filter_map(|index| self.at(index)) {
            let differs = with_defaults && value != definition.default;
            // A name is never wholly that of the one before: at least one letter is its own.
            let same = last.bytes().zip(definition.name.bytes()).take_while(|(a, b)| a == b).count();
            let common = same.min(15).min(definition.name.len().saturating_sub(1));
            let rest = definition.name.as_bytes().get(common..).unwrap_or_default();
            file.push(kind_number(definition.kind) | if differs { HAS_DEFAULT } else { 0 });
            file.push(common as u8 | (rest.len().saturating_sub(1) as u8) << 4);
            file.extend_from_slice(rest);
            push_value(&mut file, definition, value);
            if differs {
                push_value(&mut file, definition, definition.default);
            }
            last = &definition.name;
        }
        file
    }

    /// Takes the present values as those that [`Parameters::changed`] compares with.
    pub(in crate::autopilot) fn set_base(&mut self) {
        self.base = self.values.clone();
    }

    /// Names and values of what a user has changed. Faults and what the autopilot sets itself are left out: a
    /// boat is not to start with a broken rudder because of yesterday's test.
    pub(in crate::autopilot) fn changed(&self) -> Vec<(String, f32)> {
        let all = self.definitions.iter().zip(&self.values).zip(&self.base);
        all.filter(|((definition, value), base)| {
            value != base && !definition.read_only && !definition.name.starts_with("SIM_")
        })
        .map(|((definition, value), _)| (definition.name.clone(), *value))
        .collect()
    }
}

/// AP_Param's numbers of the types.
fn kind_number(kind: Kind) -> u8 {
    match kind {
        Kind::Int8 => 1,
        Kind::Int16 => 2,
        Kind::Int32 => 3,
        Kind::Real32 => 4,
    }
}

fn push_value(file: &mut Vec<u8>, definition: &Definition, value: f32) {
    match definition.kind {
        Kind::Int8 => file.extend((value as i8).to_le_bytes()),
        Kind::Int16 => file.extend((value as i16).to_le_bytes()),
        Kind::Int32 => file.extend((value as i32).to_le_bytes()),
        Kind::Real32 => file.extend(value.to_le_bytes()),
    }
}
