//! `helmlink config`: what a configuration file may hold, and whether one is right.

use std::ffi::OsString;
use std::fs;
use std::path::{Path, PathBuf};

use clap::{Args, CommandFactory, Subcommand};

use super::cli::{Cli, Common};
use super::failure::Failure;
use super::parameter_list::{self, ParametersArgs};
use super::{config, config_schema, console};

/// `helmlink config`.
#[derive(Debug, Clone, Subcommand)]
pub enum ConfigCommand {
    /// Print the merged settings of a subcommand, and where each came from
    Show(ShowArgs),
    /// Check a configuration file: every table, key and value
    Check(CheckArgs),
    /// Print the JSON schema of configuration files, for editors
    Schema(SchemaArgs),
    /// List the bridge's MAVLink parameters: value, range, unit and meaning of each
    Parameters(ParametersArgs),
}

/// `helmlink config show`.
#[derive(Debug, Clone, Args)]
#[command(after_help = "Example: helmlink config show /etc/helmlink.toml bridge --engage")]
pub struct ShowArgs {
    /// The configuration file
    #[arg(value_name = "FILE")]
    pub file: PathBuf,
    /// The subcommand, and options that overrule the file
    #[arg(
        trailing_var_arg = true,
        allow_hyphen_values = true,
        value_name = "COMMAND",
        default_value = "bridge"
    )]
    pub command: Vec<OsString>,
    #[command(flatten)]
    #[allow(missing_docs)]
    pub common: Common,
}

/// `helmlink config check`.
#[derive(Debug, Clone, Args)]
#[command(after_help = "Example: helmlink config check /etc/helmlink.toml")]
pub struct CheckArgs {
    /// The configuration file
    #[arg(value_name = "FILE")]
    pub file: PathBuf,
    #[command(flatten)]
    #[allow(missing_docs)]
    pub common: Common,
}

/// `helmlink config schema`.
#[derive(Debug, Clone, Args)]
#[command(after_help = "Example: helmlink config schema > helmlink.schema.json")]
pub struct SchemaArgs {
    #[command(flatten)]
    #[allow(missing_docs)]
    pub common: Common,
}

impl ConfigCommand {
    /// The options that every subcommand has.
    pub(super) fn common(&self) -> &Common {
        match self {
            Self::Show(args) => &args.common,
            Self::Check(args) => &args.common,
            Self::Schema(args) => &args.common,
            Self::Parameters(args) => &args.common,
        }
    }
}

pub(super) fn run(command: &ConfigCommand) -> Result<(), Failure> {
    match command {
        ConfigCommand::Show(args) => show(args),
        ConfigCommand::Check(args) => check(args),
        ConfigCommand::Parameters(args) => parameter_list::run(args),
        ConfigCommand::Schema(_) => {
            let schema = config_schema::schema(&Cli::command());
            console::say(&serde_json::to_string_pretty(&schema).map_err(Failure::failed)?);
            Ok(())
        }
    }
}

/// The same as the subcommand's own `--dry-run`.
fn show(args: &ShowArgs) -> Result<(), Failure> {
    let mut words: Vec<OsString> = vec!["helmlink".into()];
    words.extend(args.command.iter().cloned());
    words.extend(["--config".into(), args.file.clone().into(), "--dry-run".into()]);
    if args.common.json {
        words.push("--json".into());
    }
    super::read(&words).map(drop)
}

fn check(args: &CheckArgs) -> Result<(), Failure> {
    let text = read(&args.file)?;
    let tables = config::check(&args.file, &text, &Cli::command())?;
    if args.common.json {
        let said = serde_json::json!({ "file": args.file, "ok": true, "tables": tables });
        console::say(&said.to_string());
    } else {
        console::say(&format!("{}: good; sets {}", args.file.display(), tables.join(", ")));
    }
    Ok(())
}

fn read(path: &Path) -> Result<String, Failure> {
    fs::read_to_string(path)
        .map_err(|error| Failure::usage(format!("cannot read {}: {error}", path.display())))
}
