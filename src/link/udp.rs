//! UDP: a socket that makes a peer of everyone who speaks to it, and one that speaks to a single remote.
//!
//! Neither socket is connected in the system's sense. So the local address follows the network when it
//! changes under way, and a remote that is not there yet costs nothing: refusals (ICMP) reach connected
//! sockets only.

use std::collections::BTreeMap;
use std::net::{Ipv4Addr, Ipv6Addr, SocketAddr};
use std::sync::Arc;

use tokio::net::UdpSocket;
use tokio::time::{Instant, sleep_until};

use super::address::{name, resolve};
use super::backoff::{Backoff, Complaints};
use super::error::OpenError;
use super::hub::Endpoint;
use super::peer::{HubClosed, Outbox, Peer};
use super::url::{HostPort, LinkUrl};

/// Largest datagram there is: none is ever cut short.
const DATAGRAM_BYTES: usize = 65_535;

/// Binds `at` and makes a peer of each remote that sends to it. Returns the address bound.
pub(super) async fn listen(
    endpoint: Endpoint,
    url: &LinkUrl,
    at: &HostPort,
) -> Result<SocketAddr, OpenError> {
    let addresses = resolve(url, at).await?;
    let bind_error = |error| OpenError::from_bind(url, at, error);
    let socket = UdpSocket::bind(&addresses[..]).await.map_err(bind_error)?;
    let local_address = socket.local_addr().map_err(bind_error)?;
    start(endpoint, Remotes::anyone(socket));
    Ok(local_address)
}

/// Binds any free port for talking to the remote at `to`. Returns the address bound.
pub(super) async fn connect(
    endpoint: Endpoint,
    url: &LinkUrl,
    to: &HostPort,
) -> Result<SocketAddr, OpenError> {
    let remote = resolve(url, to).await?[0];
    let any: SocketAddr = match remote {
        SocketAddr::V4(_) => (Ipv4Addr::UNSPECIFIED, 0).into(),
        SocketAddr::V6(_) => (Ipv6Addr::UNSPECIFIED, 0).into(),
    };
    let refused = |source| OpenError::Refused { url: url.to_string(), source };
    let socket = UdpSocket::bind(any).await.map_err(refused)?;
    let local_address = socket.local_addr().map_err(refused)?;
    start(endpoint, Remotes::only(socket, remote));
    Ok(local_address)
}

fn start(endpoint: Endpoint, mut remotes: Remotes) {
    let tasks = endpoint.clone();
    tasks.spawn(async move {
        let work = async {
            // An error here says only that the hub has been closed.
            _ = remotes.serve(&endpoint).await;
        };
        endpoint.closing.run_until_cancelled(work).await;
        // Dropping the remotes closes their outboxes; their writers then finish what waits.
    });
}

/// The remotes of one socket.
struct Remotes {
    socket: Arc<UdpSocket>,
    known: BTreeMap<SocketAddr, Remote>,
    /// The one remote of an endpoint that has only one.
    only: Option<SocketAddr>,
}

struct Remote {
    peer: Peer,
    last_heard: Instant,
}

impl Remotes {
    fn anyone(socket: UdpSocket) -> Self {
        Self { socket: Arc::new(socket), known: BTreeMap::new(), only: None }
    }

    fn only(socket: UdpSocket, remote: SocketAddr) -> Self {
        Self { only: Some(remote), ..Self::anyone(socket) }
    }

    /// Receives until the hub is closed.
    async fn serve(&mut self, endpoint: &Endpoint) -> Result<(), HubClosed> {
        if let Some(remote) = self.only {
            self.add(endpoint, remote).await?;
        }
        let mut buffer = vec![0; DATAGRAM_BYTES];
        let mut backoff = Backoff::new(endpoint.settings.retry_first, endpoint.settings.retry_longest);
        let mut complaints = Complaints::default();
        let socket = Arc::clone(&self.socket);
        loop {
            let received = tokio::select! {
                received = socket.recv_from(&mut buffer) => received,
                () = sleep_until(self.next_expiry(endpoint)) => {
                    self.forget_silent(endpoint).await?;
                    continue;
                }
            };
            match received {
                Ok((count, remote)) => {
                    backoff.reset();
                    complaints.reset();
                    self.hear(endpoint, remote, &buffer[..count]).await?;
                }
                // Errors on receiving are rare here and pass, but they must not be met in a tight loop.
                Err(error) => {
                    let reason = error.to_string();
                    if complaints.is_news(&reason) {
                        tracing::warn!(%reason, "cannot receive datagrams; trying on");
                    }
                    if !endpoint.pause(backoff.next_delay()).await {
                        return Err(HubClosed);
                    }
                }
            }
        }
    }

    /// Passes on one datagram; whoever sent it is a peer from now on, even when it is empty.
    async fn hear(&mut self, endpoint: &Endpoint, remote: SocketAddr, data: &[u8]) -> Result<(), HubClosed> {
        if self.only.is_some_and(|only| only != remote) {
            return Ok(());
        }
        if !self.known.contains_key(&remote) {
            if self.known.len() >= endpoint.settings.udp_remotes_max.max(1) {
                self.forget_oldest().await?;
            }
            self.add(endpoint, remote).await?;
        }
        if let Some(known) = self.known.get_mut(&remote) {
            known.last_heard = Instant::now();
            known.peer.received(data, true).await?;
        }
        Ok(())
    }

    async fn add(&mut self, endpoint: &Endpoint, remote: SocketAddr) -> Result<(), HubClosed> {
        let peer = Peer::register(endpoint, name(remote), endpoint.settings.queue_bytes);
        peer.announce().await?;
        endpoint.spawn(write_all(
            endpoint.clone(),
            Arc::clone(&self.socket),
            remote,
            Arc::clone(&peer.outbox),
        ));
        self.known.insert(remote, Remote { peer, last_heard: Instant::now() });
        Ok(())
    }

    /// When the next remote will have been silent for too long; far off when there is none to forget.
    fn next_expiry(&self, endpoint: &Endpoint) -> Instant {
        let oldest = self.known.values().map(|remote| remote.last_heard).min();
        oldest.filter(|_| self.only.is_none()).unwrap_or_else(Instant::now) + endpoint.settings.udp_silence
    }

    async fn forget_silent(&mut self, endpoint: &Endpoint) -> Result<(), HubClosed> {
        if self.only.is_some() {
            return Ok(());
        }
        let silence = endpoint.settings.udp_silence;
        let now = Instant::now();
        let silent = |remote: &Remote| now.duration_since(remote.last_heard) >= silence;
        let gone: Vec<_> =
            self.known.iter().filter(|(_, remote)| silent(remote)).map(|(address, _)| *address).collect();
        for address in gone {
            self.forget(address, format!("silent for {silence:?}")).await?;
        }
        Ok(())
    }

    /// Makes room for one more.
    async fn forget_oldest(&mut self) -> Result<(), HubClosed> {
        let oldest = self.known.iter().min_by_key(|(_, remote)| remote.last_heard);
        match oldest.map(|(address, _)| *address) {
            Some(address) => self.forget(address, "silent for longest of too many remotes".to_owned()).await,
            None => Ok(()),
        }
    }

    async fn forget(&mut self, address: SocketAddr, reason: String) -> Result<(), HubClosed> {
        match self.known.remove(&address) {
            Some(remote) => remote.peer.leave(reason).await,
            None => Ok(()),
        }
    }
}

/// Sends what waits for one remote until its outbox is closed and empty.
async fn write_all(endpoint: Endpoint, socket: Arc<UdpSocket>, remote: SocketAddr, outbox: Arc<Outbox>) {
    let writing = async {
        let mut complaints = Complaints::default();
        while let Some(data) = outbox.next().await {
            match socket.send_to(&data, remote).await {
                Ok(_) => {
                    outbox.count_sent(data.len());
                    complaints.reset();
                }
                // A datagram that cannot leave is lost like any other; the next may find the network back.
                Err(error) => {
                    outbox.count_lost(data.len());
                    let reason = error.to_string();
                    if complaints.is_news(&reason) {
                        tracing::warn!(%reason, peer = %name(remote), "cannot send a datagram");
                    }
                }
            }
        }
    };
    let overtime = async {
        endpoint.closing.cancelled().await;
        tokio::time::sleep(endpoint.settings.flush).await;
    };
    tokio::select! {
        biased;
        () = writing => {}
        () = overtime => {}
    }
}

#[cfg(test)]
mod tests;
