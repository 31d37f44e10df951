//! The owner of all endpoints: one stream of events in, one way to send.

use std::future::poll_fn;
use std::net::SocketAddr;
use std::sync::Arc;
use std::task::{Context, Poll};

use helmlink_wire::LinkId;
use tokio::sync::mpsc;
use tokio_util::sync::CancellationToken;
use tokio_util::task::TaskTracker;

use super::error::OpenError;
use super::peer::{Registry, Traffic};
use super::settings::LinkSettings;
use super::udp::Remotes;
use super::url::LinkUrl;
use super::{serial, tcp};

/// One opened URL of a hub, counted from 0 in the order of opening.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct EndpointId(pub usize);

impl EndpointId {
    /// The one that was opened first.
    pub const FIRST: Self = Self(0);
}

/// What happens on the links of a hub. A link's events come in order: `Up`, any number of `Bytes`, `Down`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum LinkEvent {
    /// A peer is there. Sending to it is possible from now on. The remote of a `udpout` endpoint comes up
    /// as soon as the endpoint opens: only its answers can tell whether anybody is there.
    Up {
        /// Its number.
        link: LinkId,
        /// The endpoint it came by.
        endpoint: EndpointId,
        /// Who it is, for people: an address or a device.
        peer: String,
    },
    /// Bytes from a peer, at least one.
    Bytes {
        /// Who sent them.
        link: LinkId,
        /// The bytes.
        data: Vec<u8>,
        /// Whether `data` is exactly one datagram; otherwise it is a piece of a stream, cut anywhere.
        datagram: bool,
    },
    /// A peer is gone for good; should it return, it gets a new number.
    Down {
        /// Its number.
        link: LinkId,
        /// Why, for people.
        reason: String,
    },
}

/// Owner of endpoints and their peers.
///
/// Its tasks run on the tokio runtime in which [`Hub::open`] was called (one thread is enough). They end
/// when the hub is closed or dropped, after at most [`LinkSettings::flush`] of writing what still waits.
#[derive(Debug)]
pub struct Hub {
    events: mpsc::Receiver<LinkEvent>,
    /// What every endpoint gets a copy of; `id` is the number of the next endpoint.
    shared: Endpoint,
    local_addresses: Vec<Option<SocketAddr>>,
    /// Read here and not by tasks: a datagram costs one wake instead of two.
    sockets: Vec<Remotes>,
    /// The socket that is looked at first; one more is everything else.
    first: usize,
}

/// What the tasks of one endpoint share with the hub.
#[derive(Debug, Clone)]
pub(super) struct Endpoint {
    pub(super) id: EndpointId,
    pub(super) settings: Arc<LinkSettings>,
    pub(super) registry: Arc<Registry>,
    pub(super) events: mpsc::Sender<LinkEvent>,
    pub(super) closing: CancellationToken,
    pub(super) tasks: TaskTracker,
}

impl Hub {
    /// A hub without endpoints.
    pub fn new(settings: LinkSettings) -> Self {
        let (sender, events) = mpsc::channel(settings.event_capacity.max(1));
        let shared = Endpoint {
            id: EndpointId(0),
            settings: Arc::new(settings),
            registry: Arc::default(),
            events: sender,
            closing: CancellationToken::new(),
            tasks: TaskTracker::new(),
        };
        Self { events, shared, local_addresses: Vec::new(), sockets: Vec::new(), first: 0 }
    }

    /// Opens an endpoint. Must be called within a tokio runtime with I/O and time enabled.
    ///
    /// A TCP server or serial device that is not there is no error: it is tried again and again, and the
    /// link comes up when it appears.
    ///
    /// # Errors
    /// When a local address cannot be bound, or the host of a UDP or listening endpoint has no address.
    pub async fn open(&mut self, url: &LinkUrl) -> Result<EndpointId, OpenError> {
        let endpoint = self.shared.clone();
        let local_address = match url {
            LinkUrl::UdpIn(at) => Some(self.read(Remotes::listen(endpoint, url, at).await?)),
            LinkUrl::UdpOut(to) => Some(self.read(Remotes::connect(endpoint, url, to).await?)),
            LinkUrl::TcpIn(at) => Some(tcp::listen(endpoint, url, at).await?),
            LinkUrl::TcpOut(to) => {
                tcp::connect(endpoint, to.clone());
                None
            }
            LinkUrl::Serial { device, baud } => {
                serial::open(endpoint, device.clone(), *baud);
                None
            }
        };
        Ok(self.add_endpoint(local_address).id)
    }

    fn read(&mut self, (socket, local_address): (Remotes, SocketAddr)) -> SocketAddr {
        self.sockets.push(socket);
        local_address
    }

    /// Hands out the next endpoint number.
    pub(super) fn add_endpoint(&mut self, local_address: Option<SocketAddr>) -> Endpoint {
        let endpoint = self.shared.clone();
        self.local_addresses.push(local_address);
        self.shared.id = EndpointId(endpoint.id.0 + 1);
        endpoint
    }

    /// The address an endpoint is bound to, with the port that the system chose when the URL said 0. None
    /// for endpoints that bind none (`tcpout`, `serial`).
    pub fn local_address(&self, endpoint: EndpointId) -> Option<SocketAddr> {
        self.local_addresses.get(endpoint.0).copied().flatten()
    }

    /// The next event; waits for one. Nothing is lost when the wait is abandoned.
    pub async fn next_event(&mut self) -> LinkEvent {
        poll_fn(|context| self.poll_event(context)).await
    }

    /// The next event if one waits.
    pub fn try_next_event(&mut self) -> Option<LinkEvent> {
        self.places().find_map(|place| {
            let event = match self.sockets.get_mut(place) {
                Some(socket) => socket.try_event(),
                None => self.events.try_recv().ok(),
            };
            event.inspect(|_| self.first = place + 1)
        })
    }

    fn poll_event(&mut self, context: &mut Context<'_>) -> Poll<LinkEvent> {
        for place in self.places() {
            let event = match self.sockets.get_mut(place) {
                Some(socket) => socket.poll_event(context),
                // The hub itself holds a sender, so the stream never ends while the hub lives.
                None => match self.events.poll_recv(context) {
                    Poll::Ready(Some(event)) => Poll::Ready(event),
                    Poll::Ready(None) | Poll::Pending => Poll::Pending,
                },
            };
            if event.is_ready() {
                self.first = place + 1;
                return event;
            }
        }
        Poll::Pending
    }

    /// Where events come from, in the order in which it is their turn: whoever had one last comes last. The number
    /// behind those of the sockets is that of everything else.
    fn places(&self) -> impl Iterator<Item = usize> + use<> {
        let (first, count) = (self.first, self.sockets.len() + 1);
        (first..first + count).map(move |place| place % count)
    }

    /// Queues `data` for a peer as one write: one datagram on UDP. Never waits; when the peer does not
    /// keep up, its oldest waiting writes are lost and counted, answers last. False when the peer is gone.
    pub fn send(&self, link: LinkId, data: &[u8]) -> bool {
        self.shared.registry.outbox(link).is_some_and(|outbox| outbox.push(data))
    }

    /// What a link has carried so far; none when the peer is gone.
    pub fn traffic(&self, link: LinkId) -> Option<Traffic> {
        self.shared.registry.outbox(link).map(|outbox| outbox.traffic())
    }

    /// What every link that is up has carried so far.
    pub fn all_traffic(&self) -> Vec<(LinkId, Traffic)> {
        self.shared.registry.traffic()
    }

    /// Whether a peer does not keep up: a quarter of what may wait for it does.
    pub fn is_crowded(&self) -> bool {
        self.shared.registry.is_crowded()
    }

    /// Closes every endpoint: waiting bytes are written for at most [`LinkSettings::flush`], then all
    /// sockets and devices are closed and all tasks have ended.
    pub async fn close(mut self) {
        self.events.close();
        // With the sockets go their peers' outboxes, whose writers then finish what waits.
        self.sockets.clear();
        self.shared.closing.cancel();
        self.shared.tasks.close();
        self.shared.tasks.wait().await;
    }
}

impl Drop for Hub {
    fn drop(&mut self) {
        self.shared.closing.cancel();
    }
}

impl Endpoint {
    /// Runs a task until it ends by itself, which it does soon after `closing` is cancelled.
    pub(super) fn spawn(&self, task: impl Future<Output = ()> + Send + 'static) {
        self.tasks.spawn(task);
    }

    /// Waits for `delay`; false when the hub was closed meanwhile.
    pub(super) async fn pause(&self, delay: std::time::Duration) -> bool {
        self.closing.run_until_cancelled(tokio::time::sleep(delay)).await.is_some()
    }
}

#[cfg(test)]
mod tests;
