//! One peer: its number, its bounded queue of writes, its counters.

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicU32, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use helmlink_wire::LinkId;
use helmlink_wire::outbox::Lost;
use tokio::sync::Notify;

use super::hub::{Endpoint, LinkEvent};

/// What one link has carried so far.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Traffic {
    /// Bytes received.
    pub received_bytes: u64,
    /// Bytes handed to the system.
    pub sent_bytes: u64,
    /// Writes given up because the peer did not take them in time or the system refused them.
    pub lost_writes: u64,
    /// Bytes of those writes.
    pub lost_bytes: u64,
}

/// The hub is closed: nobody listens to events any more.
#[derive(Debug)]
pub(super) struct HubClosed;

/// Every peer that is up, by number.
#[derive(Debug, Default)]
pub(super) struct Registry {
    peers: Mutex<BTreeMap<LinkId, Arc<Outbox>>>,
    /// How many there are.
    count: Arc<AtomicUsize>,
    next: AtomicU32,
}

impl Registry {
    pub(super) fn outbox(&self, link: LinkId) -> Option<Arc<Outbox>> {
        lock(&self.peers).get(&link).cloned()
    }

    pub(super) fn traffic(&self) -> Vec<(LinkId, Traffic)> {
        lock(&self.peers).iter().map(|(link, outbox)| (*link, outbox.traffic())).collect()
    }

    /// Whether a peer has a quarter of what may wait for it to read.
    pub(super) fn is_crowded(&self) -> bool {
        lock(&self.peers).values().any(|outbox| outbox.is_crowded())
    }

    fn insert(&self, outbox: Arc<Outbox>) -> LinkId {
        let link = LinkId(self.next.fetch_add(1, Ordering::Relaxed));
        let mut peers = lock(&self.peers);
        peers.insert(link, outbox);
        self.count.store(peers.len(), Ordering::Relaxed);
        link
    }

    fn remove(&self, link: LinkId) {
        let mut peers = lock(&self.peers);
        peers.remove(&link);
        self.count.store(peers.len(), Ordering::Relaxed);
    }
}

/// A panic elsewhere leaves counters and queues usable, so poisoning is ignored.
fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// The transport's hold on one peer. Dropping it takes the peer from the registry.
#[derive(Debug)]
pub(super) struct Peer {
    pub(super) link: LinkId,
    pub(super) outbox: Arc<Outbox>,
    name: String,
    endpoint: Endpoint,
}

impl Peer {
    /// Gives a number to the peer called `name`, for which at most `queue_bytes` may wait.
    pub(super) fn register(endpoint: &Endpoint, name: String, queue_bytes: usize) -> Self {
        let limit = Limit {
            own_bytes: queue_bytes,
            total_bytes: endpoint.settings.total_queue_bytes,
            peers: Arc::clone(&endpoint.registry.count),
        };
        let outbox = Arc::new(Outbox::new(limit));
        let link = endpoint.registry.insert(Arc::clone(&outbox));
        Self { link, outbox, name, endpoint: endpoint.clone() }
    }

    /// Tells the hub that this peer is there; comes before any other event of it.
    pub(super) async fn announce(&self) -> Result<(), HubClosed> {
        tracing::info!(link = self.link.0, peer = %self.name, "link up");
        let event = LinkEvent::Up { link: self.link, endpoint: self.endpoint.id, peer: self.name.clone() };
        self.tell(event).await
    }

    /// Hands bytes from the peer to the hub; waits while the hub has too many events to take.
    pub(super) async fn received(&self, data: &[u8], datagram: bool) -> Result<(), HubClosed> {
        if data.is_empty() {
            return Ok(());
        }
        self.outbox.count_received(data.len());
        self.tell(LinkEvent::Bytes { link: self.link, data: data.to_vec(), datagram }).await
    }

    /// Tells the hub that this peer is gone; its last event. Writes that still wait are lost.
    pub(super) async fn leave(self, reason: String) -> Result<(), HubClosed> {
        self.endpoint.registry.remove(self.link);
        self.outbox.discard();
        let traffic = self.outbox.traffic();
        tracing::info!(link = self.link.0, peer = %self.name, %reason, ?traffic, "link down");
        self.tell(LinkEvent::Down { link: self.link, reason }).await
    }

    async fn tell(&self, event: LinkEvent) -> Result<(), HubClosed> {
        self.endpoint.events.send(event).await.map_err(|_| HubClosed)
    }
}

impl Drop for Peer {
    fn drop(&mut self) {
        self.outbox.close();
        self.endpoint.registry.remove(self.link);
    }
}

/// Writes that wait for one peer, bounded in bytes.
#[derive(Debug)]
pub(super) struct Outbox {
    waiting: Mutex<Waiting>,
    changed: Notify,
    limit: Limit,
}

/// How much may wait for one peer.
#[derive(Debug, Clone)]
struct Limit {
    own_bytes: usize,
    /// For all peers together, who share it alike.
    total_bytes: usize,
    peers: Arc<AtomicUsize>,
}

impl Limit {
    fn bytes(&self) -> usize {
        self.own_bytes.min(self.total_bytes / self.peers.load(Ordering::Relaxed).max(1))
    }
}

#[derive(Debug, Default)]
struct Waiting {
    writes: helmlink_wire::Outbox,
    closed: bool,
    traffic: Traffic,
}

impl Waiting {
    fn count(&mut self, lost: Lost) {
        self.traffic.lost_writes += lost.writes;
        self.traffic.lost_bytes += lost.bytes;
    }
}

impl Outbox {
    fn new(limit: Limit) -> Self {
        Self { waiting: Mutex::default(), changed: Notify::new(), limit }
    }

    /// Queues one write, at the price of older ones where there is no room; see [`helmlink_wire::outbox`]. False
    /// when the outbox is closed.
    pub(super) fn push(&self, data: &[u8]) -> bool {
        let mut waiting = lock(&self.waiting);
        if waiting.closed {
            return false;
        }
        if data.is_empty() {
            return true;
        }
        let lost = waiting.writes.push(data, self.limit.bytes());
        waiting.count(lost);
        drop(waiting);
        self.changed.notify_one();
        true
    }

    /// Whether a quarter of what may wait does.
    fn is_crowded(&self) -> bool {
        lock(&self.waiting).writes.bytes() >= self.limit.bytes() / 4
    }

    /// The next write, or none once the outbox is closed and empty. For one task at a time.
    pub(super) async fn next(&self) -> Option<Vec<u8>> {
        loop {
            {
                let mut waiting = lock(&self.waiting);
                if let Some(write) = waiting.writes.pop() {
                    return Some(write);
                }
                if waiting.closed {
                    return None;
                }
            }
            self.changed.notified().await;
        }
    }

    /// Takes no further writes; those that wait can still be taken.
    pub(super) fn close(&self) {
        lock(&self.waiting).closed = true;
        self.changed.notify_one();
    }

    /// Closes and gives up what waits.
    fn discard(&self) {
        self.close();
        let mut waiting = lock(&self.waiting);
        let lost = waiting.writes.clear();
        waiting.count(lost);
    }

    pub(super) fn count_sent(&self, bytes: usize) {
        lock(&self.waiting).traffic.sent_bytes += bytes as u64;
    }

    /// Counts one write of `bytes` that the system refused.
    pub(super) fn count_lost(&self, bytes: usize) {
        let mut waiting = lock(&self.waiting);
        waiting.traffic.lost_writes += 1;
        waiting.traffic.lost_bytes += bytes as u64;
    }

    fn count_received(&self, bytes: usize) {
        lock(&self.waiting).traffic.received_bytes += bytes as u64;
    }

    pub(super) fn traffic(&self) -> Traffic {
        lock(&self.waiting).traffic
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn outbox(own_bytes: usize) -> Outbox {
        Outbox::new(Limit { own_bytes, total_bytes: 1000, peers: Arc::new(AtomicUsize::new(1)) })
    }

    #[tokio::test]
    async fn a_full_outbox_loses_its_oldest_writes_and_counts_them() {
        let outbox = outbox(10);
        for write in [b"aaaa", b"bbbb", b"cccc", b"dddd"] {
            assert!(outbox.push(write));
        }
        outbox.close();
        assert_eq!(outbox.next().await.as_deref(), Some(&b"cccc"[..]));
        assert_eq!(outbox.next().await.as_deref(), Some(&b"dddd"[..]));
        assert_eq!(outbox.next().await, None);
        assert_eq!(outbox.traffic(), Traffic { lost_writes: 2, lost_bytes: 8, ..Traffic::default() });
    }

    #[tokio::test]
    async fn a_write_larger_than_the_queue_waits_alone() {
        let outbox = outbox(10);
        outbox.push(b"small");
        outbox.push(&[7; 25]);
        assert_eq!(outbox.next().await.map(|write| write.len()), Some(25));
        outbox.push(b"small");
        assert_eq!(outbox.next().await.map(|write| write.len()), Some(5));
    }

    #[tokio::test]
    async fn a_closed_outbox_refuses_writes() {
        let outbox = outbox(10);
        outbox.close();
        assert!(!outbox.push(b"late"));
        assert_eq!(outbox.next().await, None);
    }

    #[tokio::test]
    async fn a_waiting_reader_wakes_for_a_write_and_for_the_close() {
        let outbox = outbox(10);
        let (first, ()) = tokio::join!(outbox.next(), async { assert!(outbox.push(b"x")) });
        assert_eq!(first.as_deref(), Some(&b"x"[..]));
        let (second, ()) = tokio::join!(outbox.next(), async { outbox.close() });
        assert_eq!(second, None);
    }

    #[tokio::test]
    async fn many_peers_share_what_may_wait_for_all() {
        let peers = Arc::new(AtomicUsize::new(1));
        let outbox = Outbox::new(Limit { own_bytes: 600, total_bytes: 1000, peers: Arc::clone(&peers) });
        (0..20).for_each(|_| assert!(outbox.push(&[7; 100])));
        assert_eq!(lock(&outbox.waiting).writes.bytes(), 600);
        peers.store(5, Ordering::Relaxed);
        outbox.push(&[7; 100]);
        assert_eq!(lock(&outbox.waiting).writes.bytes(), 200);
        assert!(outbox.is_crowded());
    }
}
