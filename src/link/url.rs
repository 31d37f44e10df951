//! Link URLs: one line of text that says how bytes travel.
//!
//! | form | meaning |
//! |---|---|
//! | `udpin:HOST:PORT` | listen for datagrams; every sender becomes a peer |
//! | `udpout:HOST:PORT` | send datagrams to one remote and hear its answers |
//! | `tcpin:HOST:PORT` | accept any number of TCP clients |
//! | `tcpout:HOST:PORT`, `tcp:HOST:PORT` | connect to a TCP server |
//! | `serial:usb-VENDOR:PRODUCT[:BAUD]` | the serial port of a USB device, such as `usb-1209:5740`, under whatever name |
//! | `serial:DEVICE[:BAUD]` | a serial port, 8N1; the rate is [`DEFAULT_BAUD`] when it is left out |
//!
//! `scheme://` means the same as `scheme:`. An IPv6 address stands in brackets: `udpin:[::]:14550`.

use std::fmt;
use std::net::{Ipv4Addr, Ipv6Addr};
use std::str::FromStr;

use thiserror::Error;

use super::usb::{self, UsbDevice};

/// Rate of a serial port whose URL gives none, bit/s. USB ports ignore it; companion-computer ports of
/// autopilots usually run at this rate, telemetry radios at 57600.
pub const DEFAULT_BAUD: u32 = 115_200;
/// Lowest serial rate accepted, bit/s.
pub const MIN_BAUD: u32 = 300;
/// Highest serial rate accepted, bit/s.
pub const MAX_BAUD: u32 = 12_000_000;

/// Device names under this directory contain colons of their own.
const COLON_NAMES: &str = "/dev/serial/by-path/";

/// How to reach one endpoint. [`FromStr`] reads the forms of the [module](self), [`fmt::Display`] writes
/// the canonical one, and the two are each other's inverse.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub enum LinkUrl {
    /// Listen for datagrams at this local address.
    UdpIn(HostPort),
    /// Send datagrams to this remote address.
    UdpOut(HostPort),
    /// Accept TCP clients at this local address.
    TcpIn(HostPort),
    /// Connect to the TCP server at this remote address.
    TcpOut(HostPort),
    /// Open a serial port.
    Serial {
        /// Path or name of the device, e.g. `/dev/ttyACM0`.
        device: String,
        /// Line rate, bit/s, in [`MIN_BAUD`]..=[`MAX_BAUD`].
        baud: u32,
    },
}

/// A host and a port. Only parsing makes one, so the host is never empty.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct HostPort {
    host: String,
    port: u16,
}

impl HostPort {
    /// A name, an IPv4 address or an IPv6 address without its brackets.
    pub fn host(&self) -> &str {
        &self.host
    }

    /// The port; 0 (listening endpoints only) lets the system choose a free one.
    pub fn port(&self) -> u16 {
        self.port
    }
}

/// Why a text is not a link URL, and what to write instead.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum UrlError {
    /// Nothing was written.
    #[error("the link URL is empty: write for example udpin:0.0.0.0:14550")]
    Empty,
    /// No `scheme:` in front.
    #[error("`{text}` has no scheme: write for example {example}")]
    NoScheme {
        /// What was written.
        text: String,
        /// A URL near to it.
        example: String,
    },
    /// `udp:` may mean either of two things.
    #[error("`udp:` can mean two things: write udpin:{rest} to listen there, or udpout:{rest} to send there")]
    AmbiguousUdp {
        /// What followed `udp:`.
        rest: String,
    },
    /// A word that names no transport.
    #[error("`{scheme}` is not a transport: use udpin, udpout, tcpin, tcpout (or tcp) or serial")]
    UnknownScheme {
        /// The word.
        scheme: String,
    },
    /// The part before the port is empty.
    #[error("the host is missing in `{text}`: write {scheme}:{example}:PORT")]
    MissingHost {
        /// What was written.
        text: String,
        /// Its transport.
        scheme: &'static str,
        /// A host that fits the transport.
        example: &'static str,
    },
    /// The host cannot be a name or an address.
    #[error("`{host}` is neither a host name nor an IP address: {fix}")]
    BadHost {
        /// The host as written.
        host: String,
        /// What to write instead.
        fix: String,
    },
    /// No port.
    #[error("the port is missing in `{text}`: write {scheme}:{host}:PORT, for example {scheme}:{host}:14550")]
    MissingPort {
        /// What was written.
        text: String,
        /// Its transport.
        scheme: &'static str,
        /// Its host.
        host: String,
    },
    /// A port that is not a number in range.
    #[error("`{port}` is not a port: write a whole number from {least} to 65535")]
    BadPort {
        /// The port as written.
        port: String,
        /// 0 where the system may choose, else 1.
        least: u16,
    },
    /// No device after `serial:`.
    #[error("the device is missing in `{text}`: write for example serial:/dev/ttyACM0:115200")]
    MissingDevice {
        /// What was written.
        text: String,
    },
    /// `serial://dev/...` lost a slash.
    #[error("`{device}` lost its leading slash: write serial:/{device}")]
    RelativeDevice {
        /// The device as written.
        device: String,
    },
    /// A USB device that is not named as one.
    #[error(
        "`{device}` does not name a USB device: write usb-VENDOR:PRODUCT with the four digits of each that `lsusb` \
         prints, for example serial:usb-1209:5740:115200"
    )]
    BadUsbDevice {
        /// The device as written.
        device: String,
    },
    /// A rate that is not a number in range.
    #[error(
        "`{baud}` is not a serial rate: write bits per second from {MIN_BAUD} to {MAX_BAUD}, for example 57600"
    )]
    BadBaud {
        /// The rate as written.
        baud: String,
    },
}

impl LinkUrl {
    /// Whether others come to this endpoint, rather than it going to them.
    pub fn listens(&self) -> bool {
        matches!(self, Self::UdpIn(_) | Self::TcpIn(_))
    }
}

impl FromStr for LinkUrl {
    type Err = UrlError;

    fn from_str(text: &str) -> Result<Self, UrlError> {
        let text = text.trim();
        if text.is_empty() {
            return Err(UrlError::Empty);
        }
        let (scheme, rest) = text.split_once(':').ok_or_else(|| no_scheme(text))?;
        let rest = rest.strip_prefix("//").unwrap_or(rest);
        match scheme.to_ascii_lowercase().as_str() {
            "udpin" => host_port("udpin", text, rest).map(Self::UdpIn),
            "udpout" => host_port("udpout", text, rest).map(Self::UdpOut),
            "tcpin" => host_port("tcpin", text, rest).map(Self::TcpIn),
            "tcpout" | "tcp" => host_port("tcpout", text, rest).map(Self::TcpOut),
            "serial" => serial(text, rest),
            "udp" => Err(UrlError::AmbiguousUdp { rest: or_placeholder(rest, "HOST:PORT") }),
            word if word.contains(['/', '.', '[']) || word.is_empty() => Err(no_scheme(text)),
            _ => Err(UrlError::UnknownScheme { scheme: scheme.to_owned() }),
        }
    }
}

fn no_scheme(text: &str) -> UrlError {
    let example = if text.starts_with('/') || text.to_ascii_uppercase().starts_with("COM") {
        format!("serial:{text}")
    } else if text.contains(':') {
        format!("tcpout:{}", text.trim_start_matches([':', '/']))
    } else {
        "udpin:0.0.0.0:14550".to_owned()
    };
    UrlError::NoScheme { text: text.to_owned(), example }
}

fn or_placeholder(text: &str, placeholder: &str) -> String {
    if text.is_empty() { placeholder.to_owned() } else { text.to_owned() }
}

/// Reads `HOST:PORT`; `text` is the whole URL, for messages.
fn host_port(scheme: &'static str, text: &str, rest: &str) -> Result<HostPort, UrlError> {
    let listens = scheme.ends_with("in");
    let example = if listens { "0.0.0.0" } else { "127.0.0.1" };
    let (host, port) = match rest.strip_prefix('[') {
        Some(bracketed) => split_bracketed(rest, bracketed)?,
        None => split_plain(scheme, rest)?,
    };
    if host.is_empty() {
        return Err(UrlError::MissingHost { text: text.to_owned(), scheme, example });
    }
    let Some(port) = port.filter(|port| !port.is_empty()) else {
        // A lone number is far more often a port without its host than the reverse.
        if host.bytes().all(|byte| byte.is_ascii_digit()) {
            return Err(UrlError::MissingHost { text: text.to_owned(), scheme, example });
        }
        return Err(UrlError::MissingPort { text: text.to_owned(), scheme, host: bracket_ipv6(host) });
    };
    let least = u16::from(!listens);
    let bad_port = || UrlError::BadPort { port: port.to_owned(), least };
    if !port.bytes().all(|byte| byte.is_ascii_digit()) {
        return Err(bad_port());
    }
    let number: u16 = port.parse().map_err(|_| bad_port())?;
    if number < least {
        return Err(bad_port());
    }
    Ok(HostPort { host: host.to_owned(), port: number })
}

/// `[IPV6]` or `[IPV6]:PORT`, an interface such as `%eth0` allowed.
fn split_bracketed<'a>(rest: &str, bracketed: &'a str) -> Result<(&'a str, Option<&'a str>), UrlError> {
    let bad = |fix: &str| UrlError::BadHost { host: rest.to_owned(), fix: fix.to_owned() };
    let (host, after) =
        bracketed.split_once(']').ok_or_else(|| bad("close the bracket, as in [::1]:14550"))?;
    let (address, zone) = match host.split_once('%') {
        Some((address, zone)) => (address, Some(zone)),
        None => (host, None),
    };
    let zone_is_plain = zone.is_none_or(|zone| !zone.is_empty() && zone.bytes().all(is_name_byte));
    if address.parse::<Ipv6Addr>().is_err() || !zone_is_plain {
        return Err(bad("brackets hold an IPv6 address, as in [::1]:14550"));
    }
    match after.strip_prefix(':') {
        Some(port) => Ok((host, Some(port))),
        None if after.is_empty() => Ok((host, None)),
        None => Err(bad("a colon and the port follow the bracket, as in [::1]:14550")),
    }
}

/// `HOST` or `HOST:PORT`.
fn split_plain<'a>(scheme: &str, rest: &'a str) -> Result<(&'a str, Option<&'a str>), UrlError> {
    let (host, port) = match rest.rsplit_once(':') {
        Some((host, port)) => (host, Some(port)),
        None => (rest, None),
    };
    let bad = |fix: String| UrlError::BadHost { host: host.to_owned(), fix };
    if host.contains(':') {
        let port = or_placeholder(port.unwrap_or_default(), "PORT");
        return Err(bad(format!("put an IPv6 address in brackets, as in {scheme}:[{host}]:{port}")));
    }
    if !host.bytes().all(is_name_byte) {
        return Err(bad("use letters, digits, dots and hyphens".to_owned()));
    }
    let numeric = host.contains('.') && host.bytes().all(|byte| byte.is_ascii_digit() || byte == b'.');
    if numeric && host.parse::<Ipv4Addr>().is_err() {
        return Err(bad("an IPv4 address has four numbers from 0 to 255".to_owned()));
    }
    Ok((host, port))
}

fn is_name_byte(byte: u8) -> bool {
    byte.is_ascii_alphanumeric() || matches!(byte, b'.' | b'-' | b'_')
}

/// Reads `DEVICE[:BAUD]`; `text` is the whole URL, for messages.
///
/// Leading slashes shrink to one: `serial:////dev/x` and `serial:/dev/x` are the same port.
fn serial(text: &str, rest: &str) -> Result<LinkUrl, UrlError> {
    let (device, baud) = match rest.rsplit_once(':') {
        Some((device, baud)) if !is_part_of_name(rest, baud) => (device, parse_baud(baud)?),
        _ => (rest, DEFAULT_BAUD),
    };
    let device = device.trim();
    if device.is_empty() {
        return Err(UrlError::MissingDevice { text: text.to_owned() });
    }
    if device.starts_with(usb::PREFIX) && UsbDevice::parse(device).is_none() {
        return Err(UrlError::BadUsbDevice { device: device.to_owned() });
    }
    if device.starts_with("dev/") {
        return Err(UrlError::RelativeDevice { device: device.to_owned() });
    }
    let surplus_slashes = device.len() - device.trim_start_matches('/').len();
    let device = &device[surplus_slashes.saturating_sub(1)..];
    Ok(LinkUrl::Serial { device: device.to_owned(), baud })
}

/// Whether what follows the last colon belongs to the device's name rather than being a rate. Elsewhere
/// than among names with colons it is taken for a rate, so that a mistyped rate is an error and not a
/// device for which the program would wait forever.
fn is_part_of_name(rest: &str, last: &str) -> bool {
    // Behind the vendor of a USB device comes its product, which may look like a rate.
    let is_product = UsbDevice::parse(rest).is_some();
    is_product || rest.starts_with(COLON_NAMES) && parse_baud(last).is_err()
}

fn parse_baud(text: &str) -> Result<u32, UrlError> {
    let bad = || UrlError::BadBaud { baud: text.to_owned() };
    if !text.bytes().all(|byte| byte.is_ascii_digit()) {
        return Err(bad());
    }
    let baud = text.parse().map_err(|_| bad())?;
    if (MIN_BAUD..=MAX_BAUD).contains(&baud) { Ok(baud) } else { Err(bad()) }
}

impl fmt::Display for LinkUrl {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::UdpIn(at) => write!(f, "udpin:{at}"),
            Self::UdpOut(to) => write!(f, "udpout:{to}"),
            Self::TcpIn(at) => write!(f, "tcpin:{at}"),
            Self::TcpOut(to) => write!(f, "tcpout:{to}"),
            Self::Serial { device, baud } => write!(f, "serial:{device}:{baud}"),
        }
    }
}

impl fmt::Display for HostPort {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{}", bracket_ipv6(&self.host), self.port)
    }
}

fn bracket_ipv6(host: &str) -> String {
    if host.contains(':') { format!("[{host}]") } else { host.to_owned() }
}

#[cfg(test)]
mod tests;
