//! Where a pure party meets sockets and the clock.

use std::future::poll_fn;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::pin::pin;
use std::task::Poll;
use std::time::Duration;

use helmlink_wire::LinkId;
use tokio::time::{Instant, Interval, MissedTickBehavior, interval};

use super::failure::Failure;
use crate::bridge::Bridge;
use crate::link::{EndpointId, Hub, LinkEvent, Traffic};

/// Bytes put into one write at the most, so that a datagram stays below the usual path limit.
const WRITE_LIMIT: usize = 1400;
/// Events handled in one turn at the most: time has to pass for the party too.
const EVENTS_PER_TURN: usize = 256;

/// Runs `work` to its end on one thread, as a task.
///
/// The future that a runtime of one thread blocks on is expensive to wake: each time, the runtime writes to a
/// descriptor of its own and goes round once more. A task costs nothing but its place in a queue, which is felt when
/// every datagram wakes it.
pub(super) fn block_on_task<T: Send + 'static>(
    work: impl Future<Output = T> + Send + 'static,
) -> Result<T, Failure> {
    let runtime =
        tokio::runtime::Builder::new_current_thread().enable_all().build().map_err(Failure::failed)?;
    runtime.block_on(async { tokio::spawn(work).await }).map_err(Failure::failed)
}

/// What `work` gives; none when it panics, which must not keep a bridge from letting its boat go.
pub(super) async fn unless_it_panics<T>(work: impl Future<Output = T>) -> Option<T> {
    let mut work = pin!(work);
    poll_fn(|context| {
        // Whoever goes on afterwards does no more than say good-bye.
        match catch_unwind(AssertUnwindSafe(|| work.as_mut().poll(context))) {
            Ok(poll) => poll.map(Some),
            Err(_) => Poll::Ready(None),
        }
    })
    .await
}

/// Something that talks with peers and never looks at a clock.
///
/// `now` is the time since the edge was started.
pub trait Party {
    /// A peer of an endpoint is there.
    fn link_up(&mut self, now: Duration, link: LinkId, endpoint: EndpointId);
    /// A peer is gone.
    fn link_down(&mut self, now: Duration, link: LinkId);
    /// A peer has sent bytes; `is_datagram` when they are one whole datagram.
    fn on_bytes(&mut self, now: Duration, link: LinkId, bytes: &[u8], is_datagram: bool);
    /// Time has passed.
    fn on_tick(&mut self, now: Duration);
    /// The next frame to send.
    fn poll_transmit(&mut self) -> Option<(LinkId, Vec<u8>)>;
    /// Whether the party wants to be ticked without pause.
    fn is_eager(&self) -> bool {
        false
    }
}

impl Party for Bridge {
    fn link_up(&mut self, now: Duration, link: LinkId, endpoint: EndpointId) {
        // The first endpoint that is opened is the flight controller's; the others are ground stations'.
        if endpoint == EndpointId::FIRST {
            Self::link_up(self, now, link);
        } else {
            Self::station_link_up(self, now, link);
        }
    }

    fn link_down(&mut self, now: Duration, link: LinkId) {
        Self::link_down(self, now, link);
    }

    fn on_bytes(&mut self, now: Duration, link: LinkId, bytes: &[u8], is_datagram: bool) {
        Self::on_bytes(self, now, link, bytes, is_datagram);
    }

    fn on_tick(&mut self, now: Duration) {
        Self::on_tick(self, now);
    }

    fn poll_transmit(&mut self) -> Option<(LinkId, Vec<u8>)> {
        Self::poll_transmit(self)
    }
}

/// A party with its links and its clock.
pub struct Edge<P> {
    /// The party.
    pub party: P,
    hub: Hub,
    start: Instant,
    /// When the latest turn had something to do.
    began: Duration,
    ticker: Interval,
    /// Ticks are due this often, however many events there are.
    tick: Duration,
    ticked: Instant,
    /// Whether the latest turn ticked the party.
    has_ticked: bool,
    write: Vec<u8>,
}

/// Something an edge has seen, for the log.
pub enum Seen {
    /// A peer came.
    Up(String),
    /// A peer went, and why.
    Down(String),
}

impl<P: Party> Edge<P> {
    /// An edge whose party is ticked every `tick`.
    pub fn new(party: P, hub: Hub, tick: Duration) -> Self {
        let mut ticker = interval(tick);
        ticker.set_missed_tick_behavior(MissedTickBehavior::Skip);
        let start = Instant::now();
        Self {
            party,
            hub,
            start,
            began: Duration::ZERO,
            ticker,
            tick,
            ticked: start,
            has_ticked: false,
            write: Vec::new(),
        }
    }

    /// Time since the start.
    pub fn now(&self) -> Duration {
        self.start.elapsed()
    }

    /// When the latest turn took its first event or tick, on the same clock.
    pub fn began(&self) -> Duration {
        self.began
    }

    /// Whether the latest turn ticked the party.
    pub fn has_ticked(&self) -> bool {
        self.has_ticked
    }

    /// What every link that is up has carried.
    pub fn traffic(&self) -> Vec<(LinkId, Traffic)> {
        self.hub.all_traffic()
    }

    /// Waits for the next tick or event and lets the party handle it. Nothing is lost when the wait is abandoned.
    pub async fn turn(&mut self) -> Option<Seen> {
        let mut seen = None;
        self.has_ticked = false;
        if self.party.is_eager() && !self.hub.is_crowded() {
            self.began = self.start.elapsed();
            // The sockets' tasks need their turn as well.
            tokio::task::yield_now().await;
            for _ in 0..EVENTS_PER_TURN {
                let Some(event) = self.hub.try_next_event() else { break };
                seen = self.handle(self.start.elapsed(), event).or(seen);
            }
            self.tick_party();
            self.flush();
            return seen;
        }
        tokio::select! {
            biased;
            event = self.hub.next_event() => {
                self.began = self.start.elapsed();
                seen = self.handle(self.began, event);
                for _ in 1..EVENTS_PER_TURN {
                    let Some(event) = self.hub.try_next_event() else { break };
                    seen = self.handle(self.start.elapsed(), event).or(seen);
                }
                // A flood of events must not keep the party from its work.
                if self.ticked.elapsed() >= self.tick && !self.is_crowded() {
                    self.tick_party();
                }
            }
            _ = self.ticker.tick() => {
                self.began = self.start.elapsed();
                if !self.is_crowded() {
                    self.tick_party();
                }
            }
        }
        self.flush();
        seen
    }

    fn tick_party(&mut self) {
        self.ticked = Instant::now();
        self.has_ticked = true;
        self.party.on_tick(self.start.elapsed());
    }

    /// Whether a party without a pace must wait for a peer to read. One that reads nothing at all is dropped
    /// by its link in the end.
    fn is_crowded(&self) -> bool {
        self.party.is_eager() && self.hub.is_crowded()
    }

    /// Sends what the party has to say.
    pub fn flush(&mut self) {
        let mut to = None;
        while let Some((link, frame)) = self.party.poll_transmit() {
            if to != Some(link) || self.write.len() + frame.len() > WRITE_LIMIT {
                self.write_out(to);
                to = Some(link);
            }
            self.write.extend_from_slice(&frame);
        }
        self.write_out(to);
    }

    /// Sends what is waiting and closes all links.
    pub async fn close(mut self) -> P {
        self.flush();
        self.hub.close().await;
        self.party
    }

    fn write_out(&mut self, to: Option<LinkId>) {
        if let Some(link) = to.filter(|_| !self.write.is_empty()) {
            self.hub.send(link, &self.write);
        }
        self.write.clear();
    }

    fn handle(&mut self, now: Duration, event: LinkEvent) -> Option<Seen> {
        match event {
            LinkEvent::Up { link, endpoint, peer } => {
                self.party.link_up(now, link, endpoint);
                Some(Seen::Up(peer))
            }
            LinkEvent::Bytes { link, data, datagram } => {
                self.party.on_bytes(now, link, &data, datagram);
                None
            }
            LinkEvent::Down { link, reason } => {
                self.party.link_down(now, link);
                Some(Seen::Down(reason))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[tokio::test]
    async fn what_panics_gives_nothing_and_what_waits_is_waited_for() {
        let panicking = async {
            tokio::task::yield_now().await;
            panic!("on purpose");
        };
        assert_eq!(unless_it_panics(panicking).await, None::<()>);
        let waiting = async {
            tokio::task::yield_now().await;
            7
        };
        assert_eq!(unless_it_panics(waiting).await, Some(7));
    }
}
