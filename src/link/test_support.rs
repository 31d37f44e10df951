//! What the tests of the transports share.

use std::time::Duration;

use super::{EndpointId, Hub, LinkEvent, LinkId, LinkSettings};

/// Nothing in these tests takes this long unless it is broken.
const PATIENCE: Duration = Duration::from_secs(20);

/// Awaits `future`, failing with `what` when it takes too long.
pub(super) async fn within<T>(what: &str, future: impl Future<Output = T>) -> T {
    match tokio::time::timeout(PATIENCE, future).await {
        Ok(value) => value,
        Err(_) => panic!("waited too long for {what}"),
    }
}

/// Settings that retry quickly; closing a hub that has nothing left to write must not use up the time it has
/// for that, which is beyond all patience here.
pub(super) fn quick() -> LinkSettings {
    LinkSettings {
        retry_first: Duration::from_millis(1),
        retry_longest: Duration::from_millis(20),
        flush: 10 * PATIENCE,
        ..LinkSettings::default()
    }
}

/// A hub with one endpoint.
pub(super) async fn hub_at(url: &str, settings: LinkSettings) -> Hub {
    let mut hub = Hub::new(settings);
    open(&mut hub, url).await;
    hub
}

pub(super) async fn open(hub: &mut Hub, url: &str) -> EndpointId {
    hub.open(&url.parse().unwrap()).await.unwrap()
}

/// The port of the hub's first endpoint.
pub(super) fn port(hub: &Hub) -> u16 {
    hub.local_address(EndpointId(0)).unwrap().port()
}

pub(super) async fn up(hub: &mut Hub) -> (LinkId, String) {
    match within("a link to come up", hub.next_event()).await {
        LinkEvent::Up { link, peer, .. } => (link, peer),
        other => panic!("expected Up, got {other:?}"),
    }
}

pub(super) async fn bytes(hub: &mut Hub) -> (LinkId, Vec<u8>, bool) {
    match within("bytes", hub.next_event()).await {
        LinkEvent::Bytes { link, data, datagram } => (link, data, datagram),
        other => panic!("expected Bytes, got {other:?}"),
    }
}

pub(super) async fn down(hub: &mut Hub) -> (LinkId, String) {
    match within("a link to go down", hub.next_event()).await {
        LinkEvent::Down { link, reason } => (link, reason),
        other => panic!("expected Down, got {other:?}"),
    }
}

/// Joins the pieces that a stream arrives in.
pub(super) async fn gather(hub: &mut Hub, from: LinkId, count: usize) -> Vec<u8> {
    let mut gathered = Vec::new();
    while gathered.len() < count {
        let (link, data, datagram) = bytes(hub).await;
        assert_eq!((link, datagram), (from, false));
        gathered.extend(data);
    }
    gathered
}
