use std::collections::BTreeSet;

use crate::link::test_support::{bytes, hub_at, open, port, quick, up, within};
use crate::link::{EndpointId, Hub, LinkEvent, LinkId, LinkSettings};

#[tokio::test]
async fn one_hub_serves_endpoints_of_every_kind_at_once() {
    let mut hub = Hub::new(LinkSettings::default());
    let udp = open(&mut hub, "udpin:127.0.0.1:0").await;
    let tcp = open(&mut hub, "tcpin:127.0.0.1:0").await;
    assert_eq!((udp, tcp), (EndpointId(0), EndpointId(1)));
    let address = |endpoint| hub.local_address(endpoint).unwrap();
    let (udp_url, tcp_url) = (format!("udpout:{}", address(udp)), format!("tcpout:{}", address(tcp)));

    let mut other = Hub::new(quick());
    assert!(open(&mut other, &udp_url).await < open(&mut other, &tcp_url).await);
    assert_eq!(other.local_address(EndpointId(1)), None);
    let links = [up(&mut other).await.0, up(&mut other).await.0];
    for link in links {
        assert!(other.send(link, b"hello"));
    }

    let (mut by, mut numbers) = (BTreeSet::new(), BTreeSet::new());
    let mut greetings = 0;
    while greetings < 2 {
        match within("an event", hub.next_event()).await {
            LinkEvent::Up { link, endpoint, .. } => {
                assert!(by.insert(endpoint) && numbers.insert(link));
            }
            LinkEvent::Bytes { link, data, .. } => {
                assert!(numbers.contains(&link));
                assert_eq!(data, b"hello");
                greetings += 1;
            }
            other => panic!("{other:?}"),
        }
    }
    assert_eq!(by, BTreeSet::from([udp, tcp]));
}

#[tokio::test]
async fn an_endpoint_that_cannot_be_opened_uses_up_no_number() {
    let holder = hub_at("tcpin:127.0.0.1:0", quick()).await;
    let mut hub = Hub::new(quick());
    let taken = format!("tcpin:127.0.0.1:{}", port(&holder)).parse().unwrap();
    assert!(hub.open(&taken).await.is_err());
    assert_eq!(open(&mut hub, "tcpin:127.0.0.1:0").await, EndpointId(0));
    assert_eq!(hub.local_address(EndpointId(1)), None);
}

#[tokio::test]
async fn an_unknown_link_takes_nothing() {
    let hub = Hub::new(LinkSettings::default());
    assert!(!hub.send(LinkId(0), b"x"));
    assert_eq!(hub.traffic(LinkId(0)), None);
}

#[tokio::test]
async fn an_abandoned_wait_loses_no_event() {
    let mut hub = hub_at("udpin:127.0.0.1:0", LinkSettings::default()).await;
    let mut other = hub_at(&format!("udpout:127.0.0.1:{}", port(&hub)), quick()).await;
    let (there, _) = up(&mut other).await;
    for number in 0..100u8 {
        other.send(there, &[number]);
    }
    within("the link to come up", async {
        loop {
            tokio::select! {
                biased;
                () = tokio::task::yield_now() => {}
                event = hub.next_event() => break assert!(matches!(event, LinkEvent::Up { .. })),
            }
        }
    })
    .await;
    for number in 0..100u8 {
        assert_eq!(bytes(&mut hub).await.1, [number]);
    }
}

#[tokio::test]
async fn closing_without_taking_events_ends_all_tasks() {
    let settings = LinkSettings { event_capacity: 1, ..quick() };
    let mut hub = hub_at("udpin:127.0.0.1:0", settings).await;
    open(&mut hub, "tcpin:127.0.0.1:0").await;
    open(&mut hub, "tcpout:127.0.0.1:9").await;
    open(&mut hub, "serial:/no/such/device:57600").await;
    let remotes: Vec<_> = (0..5).map(|_| std::net::UdpSocket::bind("127.0.0.1:0").unwrap()).collect();
    for remote in &remotes {
        remote.send_to(b"hello", ("127.0.0.1", port(&hub))).unwrap();
    }
    up(&mut hub).await;
    let tasks = hub.shared.tasks.clone();
    assert!(tasks.len() >= 4);
    within("the hub to close", hub.close()).await;
    assert!(tasks.is_empty());
}
