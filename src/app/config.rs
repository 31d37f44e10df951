//! Options from a TOML file, merged under those on the command line.
//!
//! The keys are the long options themselves, in a table named after the subcommand, so there is no second list
//! of settings to keep in step:
//!
//! ```toml
//! [bridge]
//! connect = "serial:/dev/ttyAMA0:921600"
//! output = "rc-override"
//! record = "/var/log/helmlink"
//! ```

use std::ffi::OsString;
use std::fmt::Write;
use std::ops::Range;
use std::path::Path;

use clap::parser::ValueSource;
use clap::{ArgMatches, Command};
use toml::de::{DeTable, DeValue};

use super::failure::Failure;

/// Options that make no sense inside a file.
const NOT_IN_A_FILE: [&str; 4] = ["config", "dry_run", "help", "version"];

/// The command line with the file's options put in where the user gave none.
///
/// # Errors
/// The file cannot be read or is no TOML; a table or key that helmlink does not know, with its line.
pub(super) fn merge(
    arguments: &[OsString],
    command: &Command,
    matches: &ArgMatches,
) -> Result<Vec<OsString>, Failure> {
    let Some((name, given)) = innermost(matches) else { return Ok(arguments.to_vec()) };
    let Some(path) = given.get_one::<std::path::PathBuf>("config") else { return Ok(arguments.to_vec()) };
    let text = std::fs::read_to_string(path).map_err(|error| {
        Failure::usage(format!("cannot read the configuration {}: {error}", path.display()))
    })?;
    let file = File { path, text: &text };
    let document = DeTable::parse(&text).map_err(|error| {
        file.error(error.span().unwrap_or(0..0), &format!("is not TOML: {}", error.message()))
    })?;
    let mut merged = arguments.to_vec();
    for (key, value) in document.get_ref() {
        let Some(subcommand) = find(command, key.get_ref()) else {
            return Err(
                file.error(key.span(), &format!("`{}` is not a subcommand of helmlink", key.get_ref()))
            );
        };
        let DeValue::Table(table) = value.get_ref() else {
            return Err(file.error(key.span(), &format!("`{}` must be a table: [{0}]", key.get_ref())));
        };
        let mut options = Vec::new();
        for (key, value) in table {
            let Some(argument) = known_option(subcommand, key.get_ref()) else {
                let text =
                    format!("`{}` is not an option of `helmlink {}`", key.get_ref(), subcommand.get_name());
                return Err(file.error(key.span(), &text));
            };
            let is_mine = subcommand.get_name() == name;
            let overruled = is_mine && given.value_source(argument) == Some(ValueSource::CommandLine);
            if is_mine && !overruled {
                options.extend(as_options(key.get_ref(), value.get_ref()).ok_or_else(|| {
                    file.error(value.span(), &format!("`{}` must be a text, a number or true", key.get_ref()))
                })?);
            }
        }
        merged.extend(options);
    }
    Ok(merged)
}

/// Every setting of the chosen subcommand with where it came from, for `--dry-run`.
pub(super) fn describe(on_command_line: &ArgMatches, merged: &ArgMatches) -> String {
    let mut text = String::new();
    let (Some((name, first)), Some((_, matches))) = (innermost(on_command_line), innermost(merged)) else {
        return text;
    };
    let _ = writeln!(text, "[{name}]");
    for id in matches.ids().filter(|id| !NOT_IN_A_FILE.contains(&id.as_str())) {
        // Groups of options are listed too; only options have a raw value of their own.
        if id.as_str().starts_with(char::is_uppercase) {
            continue;
        }
        let Ok(Some(values)) = matches.try_get_raw(id.as_str()) else { continue };
        let values: Vec<String> = values.map(|value| value.to_string_lossy().into_owned()).collect();
        let source = match (matches.value_source(id.as_str()), first.value_source(id.as_str())) {
            (Some(ValueSource::DefaultValue), _) => "default",
            (_, Some(ValueSource::CommandLine)) => "command line",
            (Some(ValueSource::EnvVariable), _) => "environment",
            _ => "configuration file",
        };
        let _ =
            writeln!(text, "{:<20} = {:<40} # {source}", id.as_str().replace('_', "-"), values.join(", "));
    }
    text
}

/// The subcommand at the end of the chain, and its options.
fn innermost(matches: &ArgMatches) -> Option<(&str, &ArgMatches)> {
    let (mut name, mut inner) = matches.subcommand()?;
    while let Some((next_name, next)) = inner.subcommand() {
        (name, inner) = (next_name, next);
    }
    Some((name, inner))
}

/// A subcommand by name; those of `mission` are found by their own names.
fn find<'a>(command: &'a Command, name: &str) -> Option<&'a Command> {
    command
        .get_subcommands()
        .find_map(|sub| if sub.get_name() == name { Some(sub) } else { find(sub, name) })
        .filter(|sub| !sub.has_subcommands())
}

fn known_option<'a>(command: &'a Command, key: &str) -> Option<&'a str> {
    let argument = command.get_arguments().find(|argument| argument.get_long() == Some(key))?;
    let id = argument.get_id().as_str();
    (!NOT_IN_A_FILE.contains(&id)).then_some(id)
}

/// One key as command-line words; `None` when the value is of a kind that no option takes.
fn as_options(key: &str, value: &DeValue<'_>) -> Option<Vec<OsString>> {
    let option = |text: &str| vec![OsString::from(format!("--{key}={text}"))];
    match value {
        DeValue::String(text) => Some(option(text)),
        DeValue::Integer(number) => Some(option(number.as_str())),
        DeValue::Float(number) => Some(option(number.as_str())),
        DeValue::Boolean(true) => Some(vec![OsString::from(format!("--{key}"))]),
        DeValue::Boolean(false) => Some(Vec::new()),
        DeValue::Array(items) => {
            let words: Option<Vec<_>> = items.iter().map(|item| as_options(key, item.get_ref())).collect();
            Some(words?.concat())
        }
        _ => None,
    }
}

/// A file whose faults are told with their line.
struct File<'a> {
    path: &'a Path,
    text: &'a str,
}

impl File<'_> {
    fn error(&self, span: Range<usize>, fault: &str) -> Failure {
        let start = span.start.min(self.text.len());
        let before = self.text.get(..start).unwrap_or_default();
        let number = before.matches('\n').count() + 1;
        let line = self.text.lines().nth(number - 1).unwrap_or_default().trim();
        Failure::usage(format!("{}, line {number}: {fault}\n    {line}", self.path.display()))
    }
}
