//! The parameters as ground stations read them from a file: names, ranges, meanings.
//!
//! The form is MAVLink's `parameter.schema.json`, version 3
//! (<https://github.com/mavlink/mavlink/tree/master/component_metadata>).

use serde_json::{Map, Value, json};

use super::store::{Tunables, decimal};
use super::table::{PARAMETERS, Parameter, Place};
use crate::pilot::failsafe::Action;

/// Version of the form.
const FORM: u32 = 3;
/// Decimals that ground stations show of anything that is not counted.
const DECIMAL_PLACES: u32 = 4;

/// All parameters: their values at `factory`, and what they may be while the others are as in `tunables`.
pub(in crate::bridge) fn parameter_file(factory: &Tunables, tunables: &Tunables) -> Value {
    let described = |(index, parameter): (usize, &Parameter)| {
        let mut entry = described(parameter, tunables);
        if let Some(value) = factory.value(index) {
            entry.insert("default".to_owned(), json!(decimal(value)));
        }
        Value::Object(entry)
    };
    let parameters: Vec<Value> = PARAMETERS.iter().enumerate().map(described).collect();
    json!({ "version": FORM, "parameters": parameters })
}

fn described(parameter: &Parameter, tunables: &Tunables) -> Map<String, Value> {
    let (least, most) = parameter.range(tunables);
    let (group, short, long) = words(parameter);
    let mut entry = Map::new();
    let mut put = |key: &str, value: Value| entry.insert(key.to_owned(), value);
    put("name", json!(parameter.name));
    put("type", json!("Float"));
    put("shortDesc", json!(short));
    put("longDesc", json!(long));
    put("min", json!(least));
    put("max", json!(most));
    put("group", json!(group));
    if let Place::Action(failsafe) = parameter.place {
        let allowed = failsafe.definition().allowed;
        let numbered = Action::ALL.iter().enumerate().filter(|(_, action)| allowed.contains(action));
        let values =
            numbered.map(|(number, action)| json!({ "value": number, "description": action.name() }));
        put("values", values.collect());
        put("decimalPlaces", json!(0));
    } else {
        put("units", json!(parameter.unit));
        put("decimalPlaces", json!(DECIMAL_PLACES));
    }
    entry
}

/// Group, short and long description.
fn words(parameter: &Parameter) -> (&'static str, String, String) {
    let meaning = parameter.meaning;
    match parameter.place {
        Place::Gain(key, _) => {
            let group = match key.split('.').next() {
                Some("guidance") => "Guidance",
                Some("limits") => "Limits",
                _ => "Control",
            };
            (group, meaning.to_owned(), format!("`{key}` of the boat file"))
        }
        Place::Speed => ("Limits", "usual speed over ground".to_owned(), meaning.to_owned()),
        Place::Limit(failsafe) => {
            let key = failsafe.definition().key;
            ("Failsafes", format!("{key}: limit"), format!("Limit of the failsafe `{key}`: {meaning}"))
        }
        Place::Action(failsafe) => {
            let key = failsafe.definition().key;
            ("Failsafes", format!("{key}: action"), format!("What the failsafe `{key}` does: {meaning}"))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::control::Boat;
    use crate::pilot::failsafe::FailsafeSettings;

    #[test]
    fn what_the_file_allows_can_be_set_and_what_it_does_not_is_refused() {
        for boat in ["otter", "motorboat", "monohull38", "skiff"] {
            let boat = Boat::embedded(boat).unwrap();
            let factory = Tunables { boat, failsafes: FailsafeSettings::default(), speed_mps: 0.0 };
            let file = parameter_file(&factory, &factory);
            let entries = file["parameters"].as_array().unwrap();
            assert_eq!(entries.len(), PARAMETERS.len());
            for entry in entries {
                let name = entry["name"].as_str().unwrap();
                let number = |key: &str| entry[key].as_f64().unwrap_or_else(|| panic!("{name}: no {key}"));
                let set = |value: f64| factory.clone().set(name, value as f32);
                set(number("default")).unwrap();
                set(number("min") - 0.5).unwrap_err();
                set(number("max") * 1.001 + 0.5).unwrap_err();
                assert!(!entry["shortDesc"].as_str().unwrap().is_empty(), "{name}");
                assert!(!entry["longDesc"].as_str().unwrap().is_empty(), "{name}");
                let Some(values) = entry.get("values").and_then(Value::as_array) else { continue };
                let listed: Vec<f64> = values.iter().map(|value| value["value"].as_f64().unwrap()).collect();
                for number in 0..Action::ALL.len() {
                    let number = number as f64;
                    assert_eq!(set(number).is_ok(), listed.contains(&number), "{name} {number}");
                }
            }
        }
    }
}
