//! The JSON schema of configuration files, made from the options themselves.

use std::any::TypeId;

use clap::{Arg, ArgAction, Command};
use serde_json::{Map, Value, json};

use super::config::NOT_IN_A_FILE;
use super::ranges::{self, Bounds, Pace, Speedup};
use crate::vehicle::OutputKind;

/// The schema of a file for all subcommands of `command`.
pub(super) fn schema(command: &Command) -> Value {
    let mut tables = Map::new();
    add_tables(command, &mut tables);
    json!({
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "Configuration of helmlink",
        "type": "object",
        "additionalProperties": false,
        "properties": tables,
    })
}

fn add_tables(command: &Command, tables: &mut Map<String, Value>) {
    for subcommand in command.get_subcommands() {
        if subcommand.has_subcommands() {
            add_tables(subcommand, tables);
        } else {
            tables.insert(subcommand.get_name().to_owned(), table(subcommand));
        }
    }
}

fn table(subcommand: &Command) -> Value {
    let options =
        subcommand.get_arguments().filter(|argument| !NOT_IN_A_FILE.contains(&argument.get_id().as_str()));
    let properties: Map<String, Value> =
        options.filter_map(|argument| Some((argument.get_long()?.to_owned(), option(argument)))).collect();
    json!({
        "description": subcommand.get_about().map(ToString::to_string),
        "type": "object",
        "additionalProperties": false,
        "properties": properties,
    })
}

fn option(argument: &Arg) -> Value {
    let mut schema = match argument.get_action() {
        ArgAction::SetTrue => json!({ "type": "boolean", "default": false }),
        ArgAction::Count => json!({ "type": "boolean" }),
        ArgAction::Append => {
            json!({ "anyOf": [kind(argument), { "type": "array", "items": kind(argument) }] })
        }
        _ => kind(argument),
    };
    let Value::Object(fields) = &mut schema else { return schema };
    if let Some(help) = argument.get_help() {
        fields.insert("description".to_owned(), json!(help.to_string()));
    }
    let defaults: Vec<_> =
        argument.get_default_values().iter().map(|value| value.to_string_lossy()).collect();
    if let [default] = &defaults[..] {
        // Numbers are written as such.
        let number = default.parse::<f64>().ok().filter(|_| fields.get("type") != Some(&json!("string")));
        fields
            .entry("default")
            .or_insert_with(|| number.map_or_else(|| json!(default), |number| json!(number)));
    }
    schema
}

/// The kind of one value, as far as the option's parser tells.
fn kind(argument: &Arg) -> Value {
    let parser = argument.get_value_parser();
    let is = |of: &[TypeId]| of.iter().any(|id| parser.type_id() == *id);
    let choices: Vec<String> =
        argument.get_possible_values().iter().map(|value| value.get_name().to_owned()).collect();
    if !choices.is_empty() {
        json!({ "type": "string", "enum": choices })
    } else if is(&[TypeId::of::<OutputKind>()]) {
        json!({ "type": "string", "enum": OutputKind::ALL.map(OutputKind::as_str) })
    } else if let Some(bounds) = ranges::bounds(|kind| is(&[kind])) {
        number(bounds)
    } else if is(&[TypeId::of::<Pace>()]) {
        let speedup = ranges::bounds(|kind| kind == TypeId::of::<Speedup>()).map(number);
        json!({ "anyOf": [speedup, { "const": Pace::MOST }] })
    } else if is(&[TypeId::of::<u64>()]) {
        // Seeds: any will do.
        json!({ "type": "integer", "minimum": 0 })
    } else {
        json!({ "type": "string" })
    }
}

fn number(bounds: Bounds) -> Value {
    let Bounds { least, most, is_whole } = bounds;
    if is_whole {
        json!({ "type": "integer", "minimum": least as i64, "maximum": most as i64 })
    } else {
        json!({ "type": "number", "minimum": least, "maximum": most })
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use clap::CommandFactory;
    use proptest::prelude::*;

    use super::*;
    use crate::app::cli::Cli;
    use crate::app::config;

    /// Table, key and schema of every option that takes a number.
    fn numbers() -> Vec<(String, String, Value)> {
        let schema = schema(&Cli::command());
        let mut numbers = Vec::new();
        for (table, of_table) in schema["properties"].as_object().unwrap() {
            for (key, option) in of_table["properties"].as_object().unwrap() {
                // What may be repeated, or may be a word, is a number all the same.
                let one = if option["anyOf"].is_array() { &option["anyOf"][0] } else { option };
                if one["type"] == "number" || one["type"] == "integer" {
                    numbers.push((table.clone(), key.clone(), one.clone()));
                }
            }
        }
        numbers
    }

    /// Whether an editor that knows the schema lets the number stand.
    fn schema_takes(schema: &Value, value: f64) -> bool {
        let whole = schema["type"] != "integer" || value.fract() == 0.0;
        let beyond = |key: &str| schema[key].as_f64();
        whole
            && beyond("minimum").is_none_or(|least| least <= value)
            && beyond("maximum").is_none_or(|most| value <= most)
    }

    /// Whether helmlink takes it.
    fn check_takes(table: &str, key: &str, schema: &Value, value: f64) -> bool {
        let text = if schema["type"] == "integer" { format!("{value:.0}") } else { format!("{value:?}") };
        let file = format!("[{table}]\n{key} = {text}\n");
        config::check(Path::new("x.toml"), &file, &Cli::command()).is_ok()
    }

    #[test]
    fn every_number_has_its_limits_and_the_schema_and_the_check_draw_them_at_the_same_place() {
        let numbers = numbers();
        assert!(numbers.len() > 40, "{}", numbers.len());
        for (table, key, schema) in &numbers {
            let is_seed = key.ends_with("seed");
            assert!(schema["minimum"].is_number(), "{table}.{key}: {schema}");
            assert!(schema["maximum"].is_number() || is_seed, "{table}.{key}: {schema}");
            let step = if schema["type"] == "integer" { 1.0 } else { 1e-6 };
            for (bound, beyond) in [("minimum", -step), ("maximum", step)] {
                let Some(at) = schema[bound].as_f64() else { continue };
                let beyond = at + beyond * at.abs().max(1.0);
                let beyond = if schema["type"] == "integer" { beyond.round() } else { beyond };
                assert!(check_takes(table, key, schema, at), "{table}.{key} = {at}");
                assert!(!check_takes(table, key, schema, beyond), "{table}.{key} = {beyond}");
                assert!(!schema_takes(schema, beyond), "{table}.{key} = {beyond}");
            }
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(32))]

        #[test]
        fn what_the_schema_refuses_helmlink_refuses_and_the_other_way_round(
            size in -4.0..9.0_f64, sign in prop::sample::select(vec![-1.0, 1.0]), number in any::<prop::sample::Index>(),
        ) {
            let numbers = numbers();
            let (table, key, schema) = &numbers[number.index(numbers.len())];
            let value = sign * 10_f64.powf(size);
            let value = if schema["type"] == "integer" { value.round() + 0.0 } else { value };
            let (by_schema, by_check) = (schema_takes(schema, value), check_takes(table, key, schema, value));
            prop_assert_eq!(by_schema, by_check, "{}.{} = {}", table, key, value);
        }
    }

    #[test]
    fn every_option_has_a_kind_and_a_description() {
        let schema = schema(&Cli::command());
        let tables = schema["properties"].as_object().unwrap();
        for name in ["bridge", "sitl", "simulate", "check"] {
            assert!(tables.contains_key(name), "{name}");
        }
        let bridge = tables["bridge"]["properties"].as_object().unwrap();
        assert!(!bridge.contains_key("config") && !bridge.contains_key("dry-run"));
        for (table, of_table) in tables {
            assert!(of_table["description"].is_string(), "{table}");
            for (key, option) in of_table["properties"].as_object().unwrap() {
                assert!(option["description"].is_string(), "{table}.{key}");
            }
        }
        assert_eq!(
            bridge["rate"],
            json!({
                "type": "number", "minimum": 2.0, "maximum": 50.0, "default": 25.0,
                "description": bridge["rate"]["description"],
            })
        );
        assert_eq!(bridge["engage"]["type"], "boolean");
        assert_eq!(bridge["gcs-system"]["type"], "integer");
        let outputs = bridge["output"]["enum"].as_array().unwrap();
        for output in outputs.iter().map(|output| output.as_str().unwrap()).chain(["sail"]) {
            let is_known = outputs.iter().any(|known| known == output);
            let file = format!("[bridge]\noutput = \"{output}\"\n");
            let is_taken = config::check(Path::new("x.toml"), &file, &Cli::command()).is_ok();
            assert_eq!(is_taken, is_known, "{output}");
        }
        assert_eq!(bridge["gcs"]["anyOf"][1]["type"], "array");
    }
}
