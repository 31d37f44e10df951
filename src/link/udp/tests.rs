use std::time::Duration;

use tokio::net::UdpSocket;

use crate::link::test_support::{bytes, down, hub_at, open, port, quick, up, within};
use crate::link::{Hub, LinkSettings};

const LOOPBACK: &str = "127.0.0.1:0";

async fn remote_of(hub: &Hub) -> UdpSocket {
    let socket = UdpSocket::bind(LOOPBACK).await.unwrap();
    socket.connect(("127.0.0.1", port(hub))).await.unwrap();
    socket
}

async fn receive(socket: &UdpSocket) -> Vec<u8> {
    let mut buffer = vec![0; 65_535];
    let count = within("a datagram", socket.recv(&mut buffer)).await.unwrap();
    buffer.truncate(count);
    buffer
}

#[tokio::test]
async fn each_of_three_remotes_gets_its_own_replies() {
    let mut hub = hub_at("udpin:127.0.0.1:0", LinkSettings::default()).await;
    let mut remotes = Vec::new();
    for number in 0..3u8 {
        let socket = remote_of(&hub).await;
        socket.send(&[number]).await.unwrap();
        let (link, peer) = up(&mut hub).await;
        assert_eq!(peer, socket.local_addr().unwrap().to_string());
        assert_eq!(bytes(&mut hub).await, (link, vec![number], true));
        remotes.push((link, socket));
    }
    for round in 0..10u8 {
        for (link, _) in &remotes {
            assert!(hub.send(*link, &[link.0 as u8, round]));
        }
    }
    for (link, socket) in &remotes {
        for round in 0..10u8 {
            assert_eq!(receive(socket).await, [link.0 as u8, round]);
        }
    }
    let traffic = hub.traffic(remotes[1].0).unwrap();
    assert_eq!((traffic.received_bytes, traffic.sent_bytes, traffic.lost_writes), (1, 20, 0));
}

#[tokio::test]
async fn every_datagram_is_one_event_whatever_its_size() {
    let mut hub = hub_at("udpin:127.0.0.1:0", LinkSettings::default()).await;
    let socket = remote_of(&hub).await;
    let sizes = [1, 280, 1400, 40_000];
    for size in sizes {
        socket.send(&vec![5; size]).await.unwrap();
    }
    let (link, _) = up(&mut hub).await;
    for size in sizes {
        assert_eq!(bytes(&mut hub).await, (link, vec![5; size], true));
    }
    for size in sizes {
        hub.send(link, &vec![6; size]);
        assert_eq!(receive(&socket).await.len(), size);
    }
}

#[tokio::test]
async fn an_empty_datagram_introduces_its_sender() {
    let mut hub = hub_at("udpin:127.0.0.1:0", LinkSettings::default()).await;
    let socket = remote_of(&hub).await;
    socket.send(&[]).await.unwrap();
    let (link, _) = up(&mut hub).await;
    hub.send(link, b"welcome");
    assert_eq!(receive(&socket).await, b"welcome");
}

#[tokio::test]
async fn a_silent_remote_is_forgotten_and_returns_under_a_new_number() {
    let settings = LinkSettings { udp_silence: Duration::from_millis(30), ..quick() };
    let mut hub = hub_at("udpin:127.0.0.1:0", settings).await;
    let socket = remote_of(&hub).await;
    socket.send(b"a").await.unwrap();
    let (first, _) = up(&mut hub).await;
    bytes(&mut hub).await;
    assert_eq!(down(&mut hub).await, (first, "silent for 30ms".to_owned()));
    assert!(!hub.send(first, b"gone"));
    assert_eq!(hub.traffic(first), None);
    socket.send(b"b").await.unwrap();
    let (second, _) = up(&mut hub).await;
    assert_ne!(first, second);
}

#[tokio::test]
async fn a_remote_too_many_takes_the_place_of_the_longest_silent() {
    let settings = LinkSettings { udp_remotes_max: 2, ..LinkSettings::default() };
    let mut hub = hub_at("udpin:127.0.0.1:0", settings).await;
    let sockets = [remote_of(&hub).await, remote_of(&hub).await, remote_of(&hub).await];
    let mut links = Vec::new();
    for socket in &sockets[..2] {
        socket.send(b"hello").await.unwrap();
        links.push(up(&mut hub).await.0);
        bytes(&mut hub).await;
    }
    sockets[0].send(b"still here").await.unwrap();
    bytes(&mut hub).await;
    sockets[2].send(b"hello").await.unwrap();
    let (gone, reason) = down(&mut hub).await;
    assert_eq!((gone, reason.as_str()), (links[1], "silent for longest of too many remotes"));
    up(&mut hub).await;
    bytes(&mut hub).await;
    assert!(hub.send(links[0], b"x"));
    assert!(!hub.send(links[1], b"x"));
}

#[tokio::test]
async fn udpout_speaks_first_and_outlives_an_absent_remote() {
    let reserved = UdpSocket::bind(LOOPBACK).await.unwrap();
    let address = reserved.local_addr().unwrap();
    drop(reserved);

    let mut hub = hub_at(&format!("udpout:{address}"), quick()).await;
    let (link, peer) = up(&mut hub).await;
    assert_eq!(peer, address.to_string());
    for count in 1..=20 {
        assert!(hub.send(link, b"anyone?"));
        // The writer's turn: each of these meets a closed port.
        within("a send", async {
            while hub.traffic(link).unwrap().sent_bytes < 7 * count {
                tokio::task::yield_now().await;
            }
        })
        .await;
    }

    let remote = UdpSocket::bind(address).await.unwrap();
    hub.send(link, b"now?");
    let mut buffer = [0; 16];
    let (count, from) = within("a datagram", remote.recv_from(&mut buffer)).await.unwrap();
    assert_eq!(&buffer[..count], b"now?");
    remote.send_to(b"yes", from).await.unwrap();
    assert_eq!(bytes(&mut hub).await, (link, b"yes".to_vec(), true));
}

#[tokio::test]
async fn udpout_hears_only_its_remote() {
    let remote = UdpSocket::bind(LOOPBACK).await.unwrap();
    let mut hub = hub_at(&format!("udpout:{}", remote.local_addr().unwrap()), quick()).await;
    let (link, _) = up(&mut hub).await;
    let stranger = remote_of(&hub).await;
    stranger.send(b"spoof").await.unwrap();
    remote.send_to(b"genuine", ("127.0.0.1", port(&hub))).await.unwrap();
    assert_eq!(bytes(&mut hub).await, (link, b"genuine".to_vec(), true));
}

#[tokio::test]
async fn a_datagram_too_long_is_counted_as_lost_and_the_next_one_leaves() {
    let mut hub = hub_at("udpin:127.0.0.1:0", LinkSettings { queue_bytes: 200_000, ..quick() }).await;
    let socket = remote_of(&hub).await;
    socket.send(b"a").await.unwrap();
    let (link, _) = up(&mut hub).await;
    hub.send(link, &[0; 70_000]);
    hub.send(link, b"short");
    assert_eq!(receive(&socket).await, b"short");
    let traffic = hub.traffic(link).unwrap();
    assert_eq!((traffic.lost_writes, traffic.lost_bytes, traffic.sent_bytes), (1, 70_000, 5));
}

#[tokio::test]
async fn works_over_ipv6() {
    let mut hub = hub_at("udpin:[::1]:0", LinkSettings::default()).await;
    let mut other = hub_at(&format!("udpout:[::1]:{}", port(&hub)), quick()).await;
    let (there, _) = up(&mut other).await;
    other.send(there, b"six");
    let (here, peer) = up(&mut hub).await;
    assert!(peer.starts_with("[::1]:"), "{peer}");
    assert_eq!(bytes(&mut hub).await, (here, b"six".to_vec(), true));
}

#[tokio::test]
async fn closing_sends_what_waits_and_frees_the_port() {
    let mut hub = hub_at("udpin:127.0.0.1:0", quick()).await;
    let address = format!("udpin:127.0.0.1:{}", port(&hub));
    let socket = remote_of(&hub).await;
    socket.send(b"a").await.unwrap();
    let (link, _) = up(&mut hub).await;
    for number in 0..50u8 {
        hub.send(link, &[number]);
    }
    within("the hub to close", hub.close()).await;
    for number in 0..50u8 {
        assert_eq!(receive(&socket).await, [number]);
    }
    open(&mut Hub::new(quick()), &address).await;
}

#[tokio::test]
async fn opening_fails_with_cause_and_fix() {
    let holder = UdpSocket::bind(LOOPBACK).await.unwrap();
    let port = holder.local_addr().unwrap().port();
    let cases = [
        (
            format!("udpin:127.0.0.1:{port}"),
            format!(
                "cannot open udpin:127.0.0.1:{port}: port {port} is already in use; end the program that \
                 holds it (`ss -lunp 'sport = :{port}'` names it) or choose another port"
            ),
        ),
        (
            "udpin:192.0.2.1:14550".to_owned(),
            "cannot open udpin:192.0.2.1:14550: 192.0.2.1 is not an address of this machine; listen at \
             0.0.0.0 for all its addresses or at 127.0.0.1 for local programs only"
                .to_owned(),
        ),
    ];
    for (url, expected) in cases {
        let error = Hub::new(quick()).open(&url.parse().unwrap()).await.unwrap_err();
        assert_eq!(error.to_string(), expected);
    }
}

#[tokio::test]
async fn a_host_without_an_address_is_an_error() {
    // A name with an empty part is refused by every resolver without asking the network.
    let error = Hub::new(quick()).open(&"udpout:no..boat:14550".parse().unwrap()).await.unwrap_err();
    let text = error.to_string();
    assert!(
        text.starts_with("cannot open udpout:no..boat:14550: no address is known for `no..boat`"),
        "{text}"
    );
    assert!(text.ends_with("check the name or write the IP address"), "{text}");
}
