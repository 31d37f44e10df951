//! Figures for Prometheus: its text format, and an answer over HTTP.

mod page;
mod server;

use std::net::{IpAddr, Ipv4Addr, SocketAddr};
use std::str::FromStr;

pub(super) use page::Page;
pub(super) use server::Server;

/// Where figures are served: `PORT` on this machine only, or `HOST:PORT`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct MetricsAddress(SocketAddr);

impl FromStr for MetricsAddress {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let local = |port: u16| SocketAddr::new(IpAddr::V4(Ipv4Addr::LOCALHOST), port);
        let address = text.parse().map(local).or_else(|_| text.parse());
        address.map(Self).map_err(|_| {
            format!(
                "`{text}` is no place to serve figures at: write a port, or ADDRESS:PORT such as 0.0.0.0:9464"
            )
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_lone_port_is_on_this_machine_only() {
        let read = |text: &str| text.parse::<MetricsAddress>().map(|address| address.0.to_string());
        assert_eq!(read("9464").as_deref(), Ok("127.0.0.1:9464"));
        assert_eq!(read("0.0.0.0:9464").as_deref(), Ok("0.0.0.0:9464"));
        assert_eq!(read("[::1]:1").as_deref(), Ok("[::1]:1"));
        assert!(read("localhost").is_err());
        assert!(read("70000").is_err());
    }
}
