//! Why an endpoint could not be opened.

use std::io;

use thiserror::Error;

use super::url::{HostPort, LinkUrl};

/// Why an endpoint could not be opened, and what to do about it. Only what no patience can cure is an
/// error: absent servers and serial devices are waited for.
#[derive(Debug, Error)]
pub enum OpenError {
    /// Another program listens there.
    #[error(
        "cannot open {url}: port {port} is already in use; end the program that holds it \
         (`ss {flags} 'sport = :{port}'` names it) or choose another port"
    )]
    PortInUse {
        /// The endpoint.
        url: String,
        /// Its port.
        port: u16,
        /// Options for `ss` that list the right sockets.
        flags: &'static str,
    },
    /// The host is not an address of this machine.
    #[error(
        "cannot open {url}: {host} is not an address of this machine; \
         listen at 0.0.0.0 for all its addresses or at 127.0.0.1 for local programs only"
    )]
    NotLocal {
        /// The endpoint.
        url: String,
        /// Its host.
        host: String,
    },
    /// The system keeps this port for privileged programs.
    #[error("cannot open {url}: the system does not allow port {port}; choose one above 1023")]
    Forbidden {
        /// The endpoint.
        url: String,
        /// Its port.
        port: u16,
    },
    /// The host name has no address.
    #[error(
        "cannot open {url}: no address is known for `{host}` ({source}); check the name or write the IP address"
    )]
    UnknownHost {
        /// The endpoint.
        url: String,
        /// Its host.
        host: String,
        /// What the resolver said.
        source: io::Error,
    },
    /// Anything else the system refuses.
    #[error("cannot open {url}: {source}; check the address and this machine's network")]
    Refused {
        /// The endpoint.
        url: String,
        /// What the system said.
        source: io::Error,
    },
}

impl OpenError {
    /// Sorts what binding a local address at `at` for `url` ended with.
    pub(super) fn from_bind(url: &LinkUrl, at: &HostPort, source: io::Error) -> Self {
        let flags = if matches!(url, LinkUrl::TcpIn(_)) { "-ltnp" } else { "-lunp" };
        let url = url.to_string();
        match source.kind() {
            io::ErrorKind::AddrInUse => Self::PortInUse { url, port: at.port(), flags },
            io::ErrorKind::AddrNotAvailable => Self::NotLocal { url, host: at.host().to_owned() },
            io::ErrorKind::PermissionDenied => Self::Forbidden { url, port: at.port() },
            _ => Self::Refused { url, source },
        }
    }
}
