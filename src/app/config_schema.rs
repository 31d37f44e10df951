//! The JSON schema of configuration files, made from the options themselves.

use std::any::TypeId;

use clap::{Arg, ArgAction, Command};
use serde_json::{Map, Value, json};

use super::config::NOT_IN_A_FILE;

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
        json!({ "enum": choices })
    } else if is(&[TypeId::of::<f64>(), TypeId::of::<f32>()]) {
        json!({ "type": "number" })
    } else if is(&[
        TypeId::of::<u8>(),
        TypeId::of::<u16>(),
        TypeId::of::<u32>(),
        TypeId::of::<u64>(),
        TypeId::of::<usize>(),
    ]) {
        json!({ "type": "integer", "minimum": 0 })
    } else {
        json!({ "type": "string" })
    }
}

#[cfg(test)]
mod tests {
    use clap::CommandFactory;

    use super::*;
    use crate::app::cli::Cli;

    #[test]
    fn every_option_has_a_kind_and_a_description() {
        let schema = schema(&Cli::command());
        let tables = schema["properties"].as_object().unwrap();
        for name in ["bridge", "sitl", "simulate", "check"] {
            assert!(tables.contains_key(name), "{name}");
        }
        let bridge = tables["bridge"]["properties"].as_object().unwrap();
        assert!(!bridge.contains_key("config") && !bridge.contains_key("dry-run"));
        for (key, option) in bridge {
            assert!(option["description"].is_string(), "{key}");
        }
        assert_eq!(
            bridge["rate"],
            json!({ "type": "number", "default": 25.0, "description": bridge["rate"]["description"] })
        );
        assert_eq!(bridge["engage"]["type"], "boolean");
        assert_eq!(bridge["gcs-system"]["type"], "integer");
        assert_eq!(bridge["output"]["type"], "string");
        assert_eq!(bridge["gcs"]["anyOf"][1]["type"], "array");
    }
}
