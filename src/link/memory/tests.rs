use std::time::Duration;

use tokio::time::Instant;

use crate::link::memory::join;
use crate::link::test_support::{bytes, down, up};
use crate::link::{EndpointId, Hub, LinkEvent, LinkSettings};

fn two_hubs() -> (Hub, Hub) {
    (Hub::new(LinkSettings::default()), Hub::new(LinkSettings::default()))
}

#[tokio::test(start_paused = true)]
async fn carries_writes_both_ways_without_time_passing() {
    let start = Instant::now();
    let (mut boat, mut bridge) = two_hubs();
    let link = join(&mut boat, &mut bridge, true);
    // Sending may begin before the link has been seen to come up.
    assert!(boat.send(link.first, b"heartbeat"));
    assert!(bridge.send(link.second, b"command"));
    assert_eq!(up(&mut boat).await.0, link.first);
    assert_eq!(up(&mut bridge).await.0, link.second);
    assert_eq!(bytes(&mut bridge).await, (link.second, b"heartbeat".to_vec(), true));
    assert_eq!(bytes(&mut boat).await, (link.first, b"command".to_vec(), true));
    assert_eq!(start.elapsed(), Duration::ZERO);
}

#[tokio::test(start_paused = true)]
async fn cutting_takes_both_sides_down() {
    let (mut boat, mut bridge) = two_hubs();
    let link = join(&mut boat, &mut bridge, false);
    up(&mut boat).await;
    up(&mut bridge).await;
    link.cut();
    assert_eq!(down(&mut boat).await, (link.first, "the link was cut".to_owned()));
    assert_eq!(down(&mut bridge).await, (link.second, "the link was cut".to_owned()));
    assert!(!boat.send(link.first, b"x"));
    assert!(!bridge.send(link.second, b"x"));
}

#[tokio::test(start_paused = true)]
async fn closing_either_hub_delivers_what_it_had_sent() {
    for closing_first in [true, false] {
        let (mut closing, mut staying) = two_hubs();
        let link = if closing_first {
            join(&mut closing, &mut staying, true)
        } else {
            join(&mut staying, &mut closing, true)
        };
        let (from, to) = if closing_first { (link.first, link.second) } else { (link.second, link.first) };
        up(&mut closing).await;
        for number in 0..100u8 {
            closing.send(from, &[number]);
        }
        let start = Instant::now();
        closing.close().await;
        assert_eq!(start.elapsed(), Duration::ZERO);
        // All of it has arrived by now: there is nothing to wait for.
        let mut arrived = std::iter::from_fn(|| staying.try_next_event());
        assert!(matches!(arrived.next(), Some(LinkEvent::Up { .. })));
        for number in 0..100u8 {
            let expected = LinkEvent::Bytes { link: to, data: vec![number], datagram: true };
            assert_eq!(arrived.next(), Some(expected));
        }
        let reason = "one of the hubs was closed".to_owned();
        assert_eq!(arrived.next(), Some(LinkEvent::Down { link: to, reason }));
    }
}

#[tokio::test(start_paused = true)]
async fn one_hub_joined_to_several_tells_them_apart() {
    let (mut boat, mut bridge) = two_hubs();
    let mut station = Hub::new(LinkSettings::default());
    let to_bridge = join(&mut boat, &mut bridge, true);
    let to_station = join(&mut boat, &mut station, true);
    assert_ne!(to_bridge.first, to_station.first);
    boat.send(to_station.first, b"s");
    boat.send(to_bridge.first, b"b");
    up(&mut bridge).await;
    up(&mut station).await;
    assert_eq!(bytes(&mut bridge).await.1, b"b");
    assert_eq!(bytes(&mut station).await.1, b"s");
    let endpoints = [boat.next_event().await, boat.next_event().await].map(|event| match event {
        LinkEvent::Up { endpoint, .. } => endpoint,
        other => panic!("{other:?}"),
    });
    assert_eq!(endpoints, [EndpointId(0), EndpointId(1)]);
}

/// Two hubs that answer each other, with timers in between: all events of the first, in order.
async fn exchange() -> Vec<LinkEvent> {
    let (mut boat, mut bridge) = two_hubs();
    let link = join(&mut boat, &mut bridge, true);
    let answering = async {
        loop {
            if let LinkEvent::Bytes { link, data, .. } = bridge.next_event().await {
                bridge.send(link, &data);
                bridge.send(link, b"telemetry");
            }
        }
    };
    let asking = async {
        let mut events = Vec::new();
        let mut tick = tokio::time::interval(Duration::from_millis(20));
        for round in 0..200u32 {
            tick.tick().await;
            boat.send(link.first, &round.to_be_bytes());
            while let Some(event) = boat.try_next_event() {
                events.push(event);
            }
        }
        events
    };
    tokio::select! {
        biased;
        events = asking => events,
        () = answering => unreachable!(),
    }
}

#[tokio::test(start_paused = true)]
async fn the_order_of_events_is_the_same_in_every_run() {
    let first = exchange().await;
    assert!(first.len() > 390, "{}", first.len());
    for _ in 0..5 {
        assert_eq!(exchange().await, first);
    }
}
