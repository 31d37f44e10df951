//! UDP: a socket that makes a peer of everyone who speaks to it, and one that speaks to a single remote.
//!
//! Neither socket is connected in the system's sense. So the local address follows the network when it
//! changes under way, and a remote that is not there yet costs nothing: refusals (ICMP) reach connected
//! sockets only.

use std::collections::{BTreeMap, VecDeque};
use std::io;
use std::net::{Ipv4Addr, Ipv6Addr, SocketAddr};
use std::pin::Pin;
use std::sync::Arc;
use std::task::{Context, Poll, ready};

use tokio::io::ReadBuf;
use tokio::net::UdpSocket;
use tokio::time::{Instant, Sleep, sleep};

use super::address::{name, resolve};
use super::backoff::{Backoff, Complaints};
use super::error::OpenError;
use super::hub::{Endpoint, LinkEvent};
use super::peer::{Outbox, Peer};
use super::url::{HostPort, LinkUrl};

/// Largest datagram there is: none is ever cut short.
const DATAGRAM_BYTES: usize = 65_535;

/// One socket and its remotes.
#[derive(Debug)]
pub(super) struct Remotes {
    endpoint: Endpoint,
    socket: Arc<UdpSocket>,
    known: BTreeMap<SocketAddr, Remote>,
    /// The one remote of an endpoint that has only one.
    only: Option<SocketAddr>,
    /// What has happened and has not been taken yet.
    events: VecDeque<LinkEvent>,
    buffer: Vec<u8>,
    /// When to look for remotes that have fallen silent. Set anew only when it has run out, not with every datagram.
    expiry: Pin<Box<Sleep>>,
    /// After an error the socket is left alone until then.
    pause: Option<Pin<Box<Sleep>>>,
    backoff: Backoff,
    complaints: Complaints,
}

#[derive(Debug)]
struct Remote {
    peer: Peer,
    last_heard: Instant,
}

impl Remotes {
    /// Binds `at`; each remote that sends there becomes a peer. Returns the address bound, too.
    pub(super) async fn listen(
        endpoint: Endpoint,
        url: &LinkUrl,
        at: &HostPort,
    ) -> Result<(Self, SocketAddr), OpenError> {
        let addresses = resolve(url, at).await?;
        let bind_error = |error| OpenError::from_bind(url, at, error);
        let socket = UdpSocket::bind(&addresses[..]).await.map_err(bind_error)?;
        let local_address = socket.local_addr().map_err(bind_error)?;
        Ok((Self::new(endpoint, socket, None), local_address))
    }

    /// Binds any free port for talking to the remote at `to`. Returns the address bound, too.
    pub(super) async fn connect(
        endpoint: Endpoint,
        url: &LinkUrl,
        to: &HostPort,
    ) -> Result<(Self, SocketAddr), OpenError> {
        let remote = resolve(url, to).await?[0];
        let any: SocketAddr = match remote {
            SocketAddr::V4(_) => (Ipv4Addr::UNSPECIFIED, 0).into(),
            SocketAddr::V6(_) => (Ipv6Addr::UNSPECIFIED, 0).into(),
        };
        let refused = |source| OpenError::Refused { url: url.to_string(), source };
        let socket = UdpSocket::bind(any).await.map_err(refused)?;
        let local_address = socket.local_addr().map_err(refused)?;
        let mut remotes = Self::new(endpoint, socket, Some(remote));
        remotes.add(remote);
        Ok((remotes, local_address))
    }

    fn new(endpoint: Endpoint, socket: UdpSocket, only: Option<SocketAddr>) -> Self {
        let settings = &endpoint.settings;
        Self {
            socket: Arc::new(socket),
            known: BTreeMap::new(),
            only,
            events: VecDeque::new(),
            buffer: vec![0; DATAGRAM_BYTES],
            expiry: Box::pin(sleep(settings.udp_silence)),
            pause: None,
            backoff: Backoff::new(settings.retry_first, settings.retry_longest),
            complaints: Complaints::default(),
            endpoint,
        }
    }

    /// The next event; asks to be woken when there is none.
    pub(super) fn poll_event(&mut self, context: &mut Context<'_>) -> Poll<LinkEvent> {
        loop {
            if let Some(event) = self.events.pop_front() {
                return Poll::Ready(event);
            }
            if self.expiry.as_mut().poll(context).is_ready() {
                self.forget_silent();
                let next = self.next_expiry();
                self.expiry.as_mut().reset(next);
                continue;
            }
            if let Some(pause) = &mut self.pause {
                ready!(pause.as_mut().poll(context));
                self.pause = None;
            }
            let mut buffer = ReadBuf::new(&mut self.buffer);
            let received = ready!(self.socket.poll_recv_from(context, &mut buffer));
            let count = buffer.filled().len();
            self.take(received.map(|remote| (count, remote)));
        }
    }

    /// The next event if one waits.
    pub(super) fn try_event(&mut self) -> Option<LinkEvent> {
        loop {
            if self.events.front().is_some() || self.pause.is_some() {
                return self.events.pop_front();
            }
            match self.socket.try_recv_from(&mut self.buffer) {
                Err(error) if error.kind() == io::ErrorKind::WouldBlock => return None,
                received => self.take(received),
            }
        }
    }

    /// What an attempt to receive has come to.
    fn take(&mut self, received: io::Result<(usize, SocketAddr)>) {
        match received {
            Ok((count, remote)) => {
                self.backoff.reset();
                self.complaints.reset();
                self.hear(remote, count);
            }
            // Errors on receiving are rare here and pass, but they must not be met in a tight loop.
            Err(error) => {
                let reason = error.to_string();
                if self.complaints.is_news(&reason) {
                    tracing::warn!(%reason, "cannot receive datagrams; trying on");
                }
                self.pause = Some(Box::pin(sleep(self.backoff.next_delay())));
            }
        }
    }

    /// Passes on the datagram in the buffer; whoever sent it is a peer from now on, even when it is empty.
    fn hear(&mut self, remote: SocketAddr, count: usize) {
        if self.only.is_some_and(|only| only != remote) {
            return;
        }
        if !self.known.contains_key(&remote) {
            if self.known.len() >= self.endpoint.settings.udp_remotes_max.max(1) {
                self.forget_oldest();
            }
            self.add(remote);
        }
        if let Some(known) = self.known.get_mut(&remote) {
            if self.only.is_none() {
                known.last_heard = Instant::now();
            }
            self.events.extend(known.peer.bytes(&self.buffer[..count], true));
        }
    }

    fn add(&mut self, remote: SocketAddr) {
        let socket = Arc::clone(&self.socket);
        // What the system does not take at once, for whatever reason, is the writer's to send and to complain of.
        let write = Box::new(move |data: &[u8]| socket.try_send_to(data, remote).is_ok());
        let queue_bytes = self.endpoint.settings.queue_bytes;
        let peer = Peer::register_direct(&self.endpoint, name(remote), queue_bytes, write);
        self.events.push_back(peer.up());
        self.endpoint.spawn(write_all(
            self.endpoint.clone(),
            Arc::clone(&self.socket),
            remote,
            Arc::clone(&peer.outbox),
        ));
        self.known.insert(remote, Remote { peer, last_heard: Instant::now() });
    }

    /// When the next remote will have been silent for too long; far off when there is none to forget.
    fn next_expiry(&self) -> Instant {
        let oldest = self.known.values().map(|remote| remote.last_heard).min();
        let since = oldest.filter(|_| self.only.is_none()).unwrap_or_else(Instant::now);
        since + self.endpoint.settings.udp_silence
    }

    fn forget_silent(&mut self) {
        if self.only.is_some() {
            return;
        }
        let silence = self.endpoint.settings.udp_silence;
        let now = Instant::now();
        let silent = |remote: &Remote| now.duration_since(remote.last_heard) >= silence;
        let gone: Vec<_> =
            self.known.iter().filter(|(_, remote)| silent(remote)).map(|(address, _)| *address).collect();
        for address in gone {
            self.forget(address, format!("silent for {silence:?}"));
        }
    }

    /// Makes room for one more.
    fn forget_oldest(&mut self) {
        let oldest = self.known.iter().min_by_key(|(_, remote)| remote.last_heard);
        if let Some(address) = oldest.map(|(address, _)| *address) {
            self.forget(address, "silent for longest of too many remotes".to_owned());
        }
    }

    fn forget(&mut self, address: SocketAddr, reason: String) {
        if let Some(remote) = self.known.remove(&address) {
            self.events.push_back(remote.peer.down(reason));
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
