//! Addresses of the network: from a host's name, and for people to read.

use std::io;
use std::net::SocketAddr;

use tokio::net::lookup_host;

use super::error::OpenError;
use super::url::{HostPort, LinkUrl};

/// The addresses of a host, at least one.
pub(super) async fn resolve(url: &LinkUrl, at: &HostPort) -> Result<Vec<SocketAddr>, OpenError> {
    let unknown =
        |source| OpenError::UnknownHost { url: url.to_string(), host: at.host().to_owned(), source };
    let addresses: Vec<_> = lookup_host((at.host(), at.port())).await.map_err(unknown)?.collect();
    if addresses.is_empty() {
        return Err(unknown(io::Error::other("the resolver found none")));
    }
    Ok(addresses)
}

/// A remote's address for people: IPv4 as such even on a socket for both families.
pub(super) fn name(remote: SocketAddr) -> String {
    SocketAddr::new(remote.ip().to_canonical(), remote.port()).to_string()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ipv4_remotes_are_named_as_such_on_a_socket_for_both_families() {
        assert_eq!(name("[::ffff:10.0.0.7]:14550".parse().unwrap()), "10.0.0.7:14550");
        assert_eq!(name("[fe80::1]:14550".parse().unwrap()), "[fe80::1]:14550");
    }
}
