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
        Self::with_outbox(endpoint, name, Outbox::new(Limit::of(endpoint, queue_bytes)))
    }

    /// The same for one whose writes need not wait for a task when the system takes them at once.
    pub(super) fn register_direct(
        endpoint: &Endpoint,
        name: String,
        queue_bytes: usize,
        write: DirectWrite,
    ) -> Self {
        let limit = Limit::of(endpoint, queue_bytes);
        Self::with_outbox(endpoint, name, Outbox { direct: Some(write), ..Outbox::new(limit) })
    }

    fn with_outbox(endpoint: &Endpoint, name: String, outbox: Outbox) -> Self {
        let outbox = Arc::new(outbox);
        let link = endpoint.registry.insert(Arc::clone(&outbox));
        Self { link, outbox, name, endpoint: endpoint.clone() }
    }

    /// Tells the hub that this peer is there; comes before any other event of it.
    pub(super) async fn announce(&self) -> Result<(), HubClosed> {
        self.tell(self.up()).await
    }

    /// Hands bytes from the peer to the hub; waits while the hub has too many events to take.
    pub(super) async fn received(&self, data: &[u8], datagram: bool) -> Result<(), HubClosed> {
        match self.bytes(data, datagram) {
            Some(event) => self.tell(event).await,
            None => Ok(()),
        }
    }

    /// Tells the hub that this peer is gone; its last event. Writes that still wait are lost.
    pub(super) async fn leave(self, reason: String) -> Result<(), HubClosed> {
        let event = self.down(reason);
        self.tell(event).await
    }

    /// This peer is there; comes before any other event of it.
    pub(super) fn up(&self) -> LinkEvent {
        tracing::debug!(link = self.link.0, peer = %self.name, "link up");
        LinkEvent::Up { link: self.link, endpoint: self.endpoint.id, peer: self.name.clone() }
    }

    /// Bytes have come from the peer; no event when there are none.
    pub(super) fn bytes(&self, data: &[u8], datagram: bool) -> Option<LinkEvent> {
        if data.is_empty() {
            return None;
        }
        self.outbox.count_received(data.len());
        Some(LinkEvent::Bytes { link: self.link, data: data.to_vec(), datagram })
    }

    /// This peer is gone; its last event. Writes that still wait are lost.
    pub(super) fn down(&self, reason: String) -> LinkEvent {
        self.endpoint.registry.remove(self.link);
        self.outbox.discard();
        let traffic = self.outbox.traffic();
        tracing::debug!(link = self.link.0, peer = %self.name, %reason, ?traffic, "link down");
        LinkEvent::Down { link: self.link, reason }
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

/// One write without waiting; true when the system has taken it whole.
pub(super) type DirectWrite = Box<dyn Fn(&[u8]) -> bool + Send + Sync>;

/// Writes that wait for one peer, bounded in bytes.
pub(super) struct Outbox {
    waiting: Mutex<Waiting>,
    changed: Notify,
    limit: Limit,
    direct: Option<DirectWrite>,
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
    fn of(endpoint: &Endpoint, own_bytes: usize) -> Self {
        let total_bytes = endpoint.settings.total_queue_bytes;
        Self { own_bytes, total_bytes, peers: Arc::clone(&endpoint.registry.count) }
    }

    fn bytes(&self) -> usize {
        self.own_bytes.min(self.total_bytes / self.peers.load(Ordering::Relaxed).max(1))
    }
}

#[derive(Debug, Default)]
struct Waiting {
    writes: helmlink_wire::Outbox,
    /// One has been taken out and may not have left yet: nothing may overtake it.
    under_way: bool,
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
        Self { waiting: Mutex::default(), changed: Notify::new(), limit, direct: None }
    }

    /// Writes at once where that is possible. Otherwise queues the write, at the price of older ones where there is
    /// no room; see [`helmlink_wire::outbox`]. False when the outbox is closed.
    pub(super) fn push(&self, data: &[u8]) -> bool {
        let mut waiting = lock(&self.waiting);
        if waiting.closed {
            return false;
        }
        if data.is_empty() {
            return true;
        }
        let is_next = waiting.writes.bytes() == 0 && !waiting.under_way;
        if is_next && self.direct.as_ref().is_some_and(|write| write(data)) {
            waiting.traffic.sent_bytes += data.len() as u64;
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
                waiting.under_way = false;
                if let Some(write) = waiting.writes.pop() {
                    waiting.under_way = true;
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

impl std::fmt::Debug for Outbox {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Outbox").field("waiting", &self.waiting).finish_non_exhaustive()
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
    async fn a_direct_write_never_overtakes_one_that_waits() {
        use std::sync::atomic::AtomicBool;
        let (free, direct) = (Arc::new(AtomicBool::new(true)), Arc::new(Mutex::new(Vec::new())));
        let write: DirectWrite = Box::new({
            let (free, direct) = (Arc::clone(&free), Arc::clone(&direct));
            move |data| {
                let taken = free.load(Ordering::Relaxed);
                lock(&direct).extend(taken.then(|| data.to_vec()));
                taken
            }
        });
        let outbox = Outbox { direct: Some(write), ..outbox(100) };
        outbox.push(b"first");
        free.store(false, Ordering::Relaxed);
        outbox.push(b"second");
        free.store(true, Ordering::Relaxed);
        outbox.push(b"third");
        assert_eq!(outbox.next().await.as_deref(), Some(&b"second"[..]));
        assert_eq!(outbox.next().await.as_deref(), Some(&b"third"[..]));
        outbox.push(b"fourth");
        assert_eq!(*lock(&direct), [b"first"]);
        outbox.close();
        assert_eq!(outbox.next().await.as_deref(), Some(&b"fourth"[..]));
        assert_eq!(outbox.next().await, None);
        assert_eq!(outbox.traffic().sent_bytes, 5);
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
