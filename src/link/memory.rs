//! Links between two hubs of one program, without sockets: for tests of what stands on the hub.
//!
//! Nothing here waits for time to pass, so a paused tokio clock does not disturb it, and on a
//! single-threaded runtime the order of events is the same in every run.

use std::pin::pin;

use helmlink_wire::LinkId;
use tokio::time::timeout;
use tokio_util::sync::CancellationToken;

use super::hub::{Endpoint, Hub};
use super::peer::{HubClosed, Peer};

/// A link between two hubs, as [`join`] makes it. Dropping this does not cut it.
#[derive(Debug)]
pub struct MemoryLink {
    /// What the first hub calls the second.
    pub first: LinkId,
    /// What the second hub calls the first.
    pub second: LinkId,
    cut: CancellationToken,
}

impl MemoryLink {
    /// Ends the link at once, as pulling a cable would: bytes under way are lost, both hubs see it go down.
    pub fn cut(&self) {
        self.cut.cancel();
    }
}

/// Joins two hubs. Every write of one arrives at the other as one event, marked as a datagram when
/// `datagram` is true. Both hubs see the link come up before anything else of it; sending may begin at
/// once. Must be called within a tokio runtime.
pub fn join(first: &mut Hub, second: &mut Hub, datagram: bool) -> MemoryLink {
    let (first, second) = (first.add_endpoint(None), second.add_endpoint(None));
    let ends = [&first, &second]
        .map(|hub| Peer::register(hub, format!("memory {}", hub.id.0), hub.settings.queue_bytes));
    let cut = CancellationToken::new();
    let link = MemoryLink { first: ends[0].link, second: ends[1].link, cut: cut.clone() };
    let task = carry_both([first.clone(), second], ends, cut, datagram);
    first.spawn(task);
    link
}

async fn carry_both(hubs: [Endpoint; 2], ends: [Peer; 2], cut: CancellationToken, datagram: bool) {
    // The first hub waits for this task when it closes; so shall the second.
    let _tracked = hubs[1].tasks.token();
    let [first, second] = &ends;
    let reason = if first.announce().await.is_err() || second.announce().await.is_err() {
        CLOSED
    } else {
        let forth = carry(first, second, datagram);
        let back = carry(second, first, datagram);
        let (mut forth, mut back) = (pin!(forth), pin!(back));
        tokio::select! {
            biased;
            () = cut.cancelled() => "the link was cut",
            () = hubs[0].closing.cancelled() => {
                first.outbox.close();
                _ = timeout(hubs[0].settings.flush, forth).await;
                CLOSED
            }
            () = hubs[1].closing.cancelled() => {
                second.outbox.close();
                _ = timeout(hubs[1].settings.flush, back).await;
                CLOSED
            }
            _ = &mut forth => CLOSED,
            _ = &mut back => CLOSED,
        }
    };
    for end in ends {
        // A hub that has been closed needs no telling.
        _ = end.leave(reason.to_owned()).await;
    }
}

const CLOSED: &str = "one of the hubs was closed";

/// Carries writes one way until the outbox is closed and empty or the receiving hub is closed.
async fn carry(from: &Peer, to: &Peer, datagram: bool) -> Result<(), HubClosed> {
    while let Some(data) = from.outbox.next().await {
        from.outbox.count_sent(data.len());
        to.received(&data, datagram).await?;
    }
    Ok(())
}

#[cfg(test)]
mod tests;
