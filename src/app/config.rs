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

use clap::error::ErrorKind;
use clap::parser::ValueSource;
use clap::{ArgMatches, Command};
use toml::de::{DeTable, DeValue};

use super::failure::Failure;

/// Options that make no sense inside a file.
pub(super) const NOT_IN_A_FILE: [&str; 4] = ["config", "dry_run", "help", "version"];

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
    let mut merged = arguments.to_vec();
    for table in tables(File { path, text: &text }, command)? {
        let is_mine = table.subcommand == name;
        merged.extend(table.options.into_iter().filter(|_| is_mine).flat_map(|option| {
            let overruled = given.value_source(&option.argument) == Some(ValueSource::CommandLine);
            if overruled { Vec::new() } else { option.words }
        }));
    }
    Ok(merged)
}

/// Checks a file whole: its tables, their keys and values. Returns the tables' names.
///
/// # Errors
/// The first fault, with its line.
pub(super) fn check(path: &Path, text: &str, command: &Command) -> Result<Vec<String>, Failure> {
    Ok(tables(File { path, text }, command)?.into_iter().map(|table| table.subcommand).collect())
}

/// What a file says to one subcommand.
struct Table {
    subcommand: String,
    options: Vec<Setting>,
}

/// One key of a table.
struct Setting {
    argument: String,
    words: Vec<OsString>,
}

fn tables(file: File<'_>, command: &Command) -> Result<Vec<Table>, Failure> {
    let document = DeTable::parse(file.text).map_err(|error| {
        file.error(error.span().unwrap_or(0..0), &format!("is not TOML: {}", error.message()))
    })?;
    let mut tables = Vec::new();
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
            let words = as_options(key.get_ref(), value.get_ref()).ok_or_else(|| {
                file.error(value.span(), &format!("`{}` must be a text, a number or true", key.get_ref()))
            })?;
            try_value(subcommand, &words).map_err(|fault| file.error(value.span(), &fault))?;
            options.push(Setting { argument: argument.to_owned(), words });
        }
        tables.push(Table { subcommand: subcommand.get_name().to_owned(), options });
    }
    Ok(tables)
}

/// Lets the option's own parser judge a value. What else the subcommand needs may come from elsewhere.
fn try_value(subcommand: &Command, words: &[OsString]) -> Result<(), String> {
    let command = subcommand.clone().no_binary_name(true);
    match command.try_get_matches_from(words) {
        Err(error)
            if matches!(error.kind(), ErrorKind::MissingRequiredArgument | ErrorKind::ArgumentConflict) =>
        {
            Ok(())
        }
        Err(error) => {
            let text = error.render().to_string();
            Err(text.lines().next().unwrap_or_default().trim_start_matches("error: ").to_owned())
        }
        Ok(_) => Ok(()),
    }
}

/// One setting in force.
struct InForce {
    key: String,
    values: Vec<String>,
    source: &'static str,
}

/// Every setting of the chosen subcommand with where it came from, for `--dry-run`.
pub(super) fn describe(on_command_line: &ArgMatches, merged: &ArgMatches, as_json: bool) -> String {
    let Some((name, settings)) = in_force(on_command_line, merged) else { return String::new() };
    if as_json {
        let settings: serde_json::Map<String, serde_json::Value> = settings
            .into_iter()
            .map(|setting| {
                (setting.key, serde_json::json!({ "values": setting.values, "source": setting.source }))
            })
            .collect();
        return serde_json::json!({ "command": name, "settings": settings }).to_string();
    }
    let mut text = format!("[{name}]\n");
    for InForce { key, values, source } in settings {
        let _ = writeln!(text, "{key:<20} = {:<40} # {source}", values.join(", "));
    }
    text
}

fn in_force<'a>(on_command_line: &ArgMatches, merged: &'a ArgMatches) -> Option<(&'a str, Vec<InForce>)> {
    let ((_, first), (name, matches)) = (innermost(on_command_line)?, innermost(merged)?);
    let mut settings = Vec::new();
    for id in matches.ids().filter(|id| !NOT_IN_A_FILE.contains(&id.as_str())) {
        // Groups of options are listed too; only options have a raw value of their own.
        if id.as_str().starts_with(char::is_uppercase) {
            continue;
        }
        let Ok(Some(values)) = matches.try_get_raw(id.as_str()) else { continue };
        let source = match (matches.value_source(id.as_str()), first.value_source(id.as_str())) {
            (Some(ValueSource::DefaultValue), _) => "default",
            (_, Some(ValueSource::CommandLine)) => "command line",
            (Some(ValueSource::EnvVariable), _) => "environment",
            _ => "configuration file",
        };
        let values = values.map(|value| value.to_string_lossy().into_owned()).collect();
        settings.push(InForce { key: id.as_str().replace('_', "-"), values, source });
    }
    Some((name, settings))
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

#[cfg(test)]
mod tests {
    use clap::CommandFactory;

    use super::*;
    use crate::app::cli::Cli;

    fn fault(text: &str) -> String {
        check(Path::new("boat.toml"), text, &Cli::command()).unwrap_err().to_string()
    }

    #[test]
    fn faults_are_told_with_their_line() {
        for (text, line, what) in [
            ("[bridge]\nconnect = \"udp:1:2\"\n", 2, "udpin:1:2"),
            ("[bridge]\nrate = 25\noutput = \"sail\"\n", 3, "rc-override"),
            ("[bridge]\nrate = \"fast\"\n", 2, "fast"),
            ("[bridge]\nwait = 0\nrate = 500\n", 3, "choose 2 to 50 Hz"),
            ("[bridge]\nwait = -1\n", 2, "choose 0 to 86400 seconds"),
            ("[bridge]\nspeed = nan\n", 2, "choose 0.1 to 100 m/s"),
            ("[bridge]\nboat = \"tanker\"\n", 2, "otter"),
            ("[bridge]\nfailsafe = [\"battery=20\", \"battery=200\"]\n", 2, "0 to 100"),
            ("[bridge]\nfailsafe = \"batery=20\"\n", 2, "batery"),
            ("[bridge]\nspeeed = 2\n", 2, "speeed"),
            ("[bridge]\n\nallow-system = [255, 0]\n", 3, "0"),
            ("[brigde]\nrate = 25\n", 1, "brigde"),
            ("bridge = 4\n", 1, "must be a table"),
            ("[bridge]\nrate = {}\n", 2, "must be a text"),
            ("[bridge\n", 1, "is not TOML"),
        ] {
            let fault = fault(text);
            assert!(fault.starts_with(&format!("boat.toml, line {line}: ")), "{text}: {fault}");
            assert!(fault.contains(what), "{text}: {fault}");
        }
    }

    #[test]
    fn a_good_file_names_its_tables() {
        let text = "[bridge]\nrate = 20\nengage = true\nallow-system = [255, 254]\n[simulate]\nspeed = 1.5\n";
        let tables = check(Path::new("boat.toml"), text, &Cli::command()).unwrap();
        assert_eq!(tables, ["bridge", "simulate"]);
    }
}
