//! The bridge as a service: the unit file, the example configuration, systemd's notifications, figures.

use std::fs;
use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::os::unix::net::UnixDatagram;
use std::process::{Child, Command, Stdio};

use crate::support::Folder;
use crate::support::process::PATIENCE;

const HELMLINK: &str = env!("CARGO_BIN_EXE_helmlink");
const UNIT: &str = include_str!("../../packaging/helmlink.service");
const EXAMPLE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/packaging/helmlink.toml");
/// A running bridge, killed when dropped.
struct Bridge(Child);

impl Bridge {
    fn start(arguments: &[&str], environment: &[(&str, &str)]) -> Self {
        let mut command = Command::new(HELMLINK);
        command.arg("bridge").args(arguments).envs(environment.iter().copied());
        Self(command.stdin(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap())
    }

    fn interrupt(&self) {
        let done = Command::new("kill").args(["-INT", &self.0.id().to_string()]).status().unwrap();
        assert!(done.success());
    }
}

impl Drop for Bridge {
    fn drop(&mut self) {
        self.0.kill().ok();
        self.0.wait().ok();
    }
}

fn helmlink(arguments: &[&str]) -> (bool, String) {
    let output = Command::new(HELMLINK).args(arguments).output().unwrap();
    let text = [output.stdout, output.stderr].concat();
    (output.status.success(), String::from_utf8(text).unwrap())
}

/// The lines of the example that are commented out but are settings.
fn with_every_setting(example: &str) -> String {
    let is_setting = |line: &str| line.starts_with("# ") && line[2..].split(' ').nth(1) == Some("=");
    let mut seen = Vec::new();
    let mut lines = Vec::new();
    for line in example.lines() {
        let line = if is_setting(line) { &line[2..] } else { line };
        let key = line.split(' ').next().unwrap_or_default().to_owned();
        // Of alternatives, TOML allows one.
        if !line.contains(" = ") || line.starts_with('#') || !seen.contains(&key) {
            seen.push(key);
            lines.push(line);
        }
    }
    lines.join("\n")
}

#[test]
fn the_example_configuration_is_good_with_every_setting_in_it() {
    let (good, said) = helmlink(&["config", "check", EXAMPLE]);
    assert!(good, "{said}");
    let folder = Folder::new("service-example");
    let full = folder.0.join("full.toml");
    let text = with_every_setting(&fs::read_to_string(EXAMPLE).unwrap());
    assert!(text.contains("\nsigning-key = ") && text.contains("\nmetrics = "), "{text}");
    fs::write(&full, text).unwrap();
    let (good, said) = helmlink(&["config", "check", full.to_str().unwrap()]);
    assert!(good, "{said}");
}

/// Settings that everybody has to choose, or for which a service wants something else than a person does.
const NOT_AT_DEFAULT: [&str; 2] = ["connect", "wait"];

#[test]
fn the_example_fits_the_schema_and_shows_the_defaults() {
    let (good, said) = helmlink(&["config", "schema"]);
    assert!(good, "{said}");
    let schema: serde_json::Value = serde_json::from_str(&said).unwrap();
    let options = &schema["properties"]["bridge"]["properties"];
    let example = fs::read_to_string(EXAMPLE).unwrap();
    let full: toml::Table = with_every_setting(&example).parse().unwrap();
    for (key, value) in full["bridge"].as_table().unwrap() {
        let allowed = options[key].to_string();
        let kind = match value {
            toml::Value::String(_) => "\"string\"",
            toml::Value::Boolean(_) => "\"boolean\"",
            toml::Value::Array(_) => "\"array\"",
            toml::Value::Integer(_) if allowed.contains("\"integer\"") => "\"integer\"",
            toml::Value::Integer(_) | toml::Value::Float(_) => "\"number\"",
            other => panic!("{key}: {other}"),
        };
        assert!(allowed.contains(kind), "{key} = {value}: {allowed}");
    }
    let set: toml::Table = example.parse().unwrap();
    for (key, value) in set["bridge"].as_table().unwrap() {
        if NOT_AT_DEFAULT.contains(&key.as_str()) {
            continue;
        }
        let default = &options[key]["default"];
        let is_default = match value {
            toml::Value::String(text) => default.as_str() == Some(text),
            toml::Value::Integer(number) => default.as_f64() == Some(*number as f64),
            other => panic!("{key}: {other}"),
        };
        assert!(is_default, "{key} = {value}, by default {default}");
    }
}

#[test]
fn a_mistake_in_a_configuration_is_told_with_its_line() {
    let folder = Folder::new("service-mistake");
    let path = folder.0.join("boat.toml");
    fs::write(&path, "[bridge]\nconnect = \"tcp:127.0.0.1:5760\"\nrate = \"fast\"\n").unwrap();
    for arguments in [&["config", "check"][..], &["bridge", "--dry-run", "--config"]] {
        let (good, said) = helmlink(&[arguments, &[path.to_str().unwrap()]].concat());
        assert!(!good && said.contains("line 3: "), "{said}");
    }
}

#[test]
fn settings_in_force_are_shown_with_their_source() {
    let (good, said) = helmlink(&["config", "show", "--json", EXAMPLE, "bridge", "--rate", "20"]);
    assert!(good, "{said}");
    let shown: serde_json::Value = serde_json::from_str(&said).unwrap();
    let of =
        |key: &str| (shown["settings"][key]["values"][0].clone(), shown["settings"][key]["source"].clone());
    assert_eq!(of("rate"), ("20".into(), "command line".into()));
    assert_eq!(of("wait"), ("0".into(), "configuration file".into()));
    assert_eq!(of("sign"), ("all".into(), "default".into()));
}

#[test]
fn systemd_accepts_the_unit_file() {
    let start = UNIT.lines().find_map(|line| line.strip_prefix("ExecStart=/usr/bin/helmlink ")).unwrap();
    let arguments = start.replace("/etc/helmlink/helmlink.toml", EXAMPLE);
    let (good, said) = helmlink(&[&arguments.split(' ').collect::<Vec<_>>()[..], &["--dry-run"]].concat());
    assert!(good && said.contains("921600"), "{said}");
    let folder = Folder::new("service-unit");
    let unit = folder.0.join("helmlink.service");
    fs::write(&unit, UNIT.replace("/usr/bin/helmlink", HELMLINK)).unwrap();
    match Command::new("systemd-analyze").arg("verify").arg(&unit).output() {
        Ok(output) => {
            let said = String::from_utf8_lossy(&output.stderr);
            // It looks at other units too; what it says about this one names it.
            assert!(output.status.success() && !said.contains("helmlink.service"), "{said}");
        }
        // Written past the capture of test output, to be seen.
        Err(_) => writeln!(std::io::stderr(), "SKIPPED: systemd-analyze is not installed").unwrap(),
    }
}

#[test]
fn systemd_hears_of_readiness_life_and_the_end() {
    let folder = Folder::new("service-notify");
    let address = folder.0.join("notify");
    let socket = UnixDatagram::bind(&address).unwrap();
    socket.set_read_timeout(Some(PATIENCE)).unwrap();
    let bridge = Bridge::start(
        &["--connect", "udpin:127.0.0.1:0", "--wait", "0"],
        &[("NOTIFY_SOCKET", address.to_str().unwrap()), ("WATCHDOG_USEC", "200000")],
    );
    let heard = |wanted: &str| {
        let mut buffer = [0; 256];
        let mut all = Vec::new();
        loop {
            let count =
                socket.recv(&mut buffer).unwrap_or_else(|error| panic!("no {wanted} after {all:?}: {error}"));
            let said = String::from_utf8_lossy(&buffer[..count]).into_owned();
            if said.contains(wanted) {
                return;
            }
            all.push(said);
        }
    };
    heard("READY=1");
    heard("STATUS=waiting-for-link");
    (0..3).for_each(|_| heard("WATCHDOG=1"));
    bridge.interrupt();
    heard("STOPPING=1");
}

#[test]
fn figures_are_served_on_this_machine_only() {
    let arguments =
        ["--connect", "udpin:127.0.0.1:0", "--wait", "0", "--metrics", "0", "--log-format", "json"];
    let mut bridge = Bridge::start(&arguments, &[]);
    let mut log = BufReader::new(bridge.0.stderr.take().unwrap()).lines();
    let place = loop {
        let line: serde_json::Value = serde_json::from_str(&log.next().unwrap().unwrap()).unwrap();
        if let Some(url) = line["message"].as_str().unwrap().strip_prefix("figures at http://") {
            break url.trim_end_matches("/metrics").to_owned();
        }
    };
    assert!(place.starts_with("127.0.0.1:"), "{place}");
    let page = loop {
        let page = get(&place);
        if page.contains("helmlink_state") {
            break page;
        }
    };
    for figure in [
        "helmlink_state{state=\"waiting-for-link\"} 1",
        "helmlink_engaged 0",
        "helmlink_control_steps_total 0",
        "helmlink_controller_errors_total 0",
        "helmlink_failsafe_total{failsafe=\"link-lost\"} 0",
        "helmlink_failsafe_total{failsafe=\"battery\"} 0",
        "process_resident_memory_bytes ",
        "process_cpu_seconds_total ",
    ] {
        assert!(page.contains(figure), "{figure}: {page}");
    }
    assert_well_formed(page.split_once("\r\n\r\n").unwrap().1);
}

fn get(place: &str) -> String {
    let mut stream = TcpStream::connect(place).unwrap();
    stream.set_read_timeout(Some(PATIENCE)).unwrap();
    write!(stream, "GET /metrics HTTP/1.1\r\nHost: {place}\r\n\r\n").unwrap();
    let mut page = String::new();
    stream.read_to_string(&mut page).unwrap();
    page
}

/// By the rules of the text format: each family has one line of help, then one of its type, then its figures and no
/// others; names and labels are as they may be; each figure is a number and there once.
fn assert_well_formed(page: &str) {
    let is_name = |name: &str| {
        name.starts_with(|letter: char| letter.is_ascii_lowercase())
            && name
                .chars()
                .all(|letter| letter.is_ascii_lowercase() || letter.is_ascii_digit() || letter == '_')
    };
    let (mut seen, mut helped, mut family) = (Vec::new(), "", "");
    for line in page.lines() {
        if let Some(help) = line.strip_prefix("# HELP ") {
            let text;
            (helped, text) = help.split_once(' ').unwrap();
            assert!(is_name(helped) && text.ends_with('.'), "{line}");
        } else if let Some(kind) = line.strip_prefix("# TYPE ") {
            let (name, kind) = kind.split_once(' ').unwrap();
            assert_eq!(name, helped, "help comes first");
            let is_total = name.ends_with("_total");
            assert_eq!(kind, if is_total { "counter" } else { "gauge" }, "{line}");
            assert!(!seen.contains(&name), "{line}: twice");
            seen.push(name);
            family = name;
        } else {
            let (figure, value) = line.rsplit_once(' ').unwrap();
            let (name, labels) = figure.split_once('{').unwrap_or((figure, "}"));
            assert_eq!(name, family, "{line}");
            let labels = labels.strip_suffix('}').unwrap();
            for label in labels.split(',').filter(|label| !label.is_empty()) {
                let (label, text) = label.split_once('=').unwrap();
                assert!(is_name(label) && text.starts_with('"') && text.ends_with('"'), "{line}");
            }
            value.parse::<f64>().unwrap();
            assert!(!seen.contains(&figure) || figure == name, "{line}: twice");
            seen.push(figure);
        }
    }
    assert!(page.ends_with('\n') && seen.len() > 20, "{page}");
}
