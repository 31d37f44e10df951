use std::time::Duration;

use helmlink_wire::dialect::{ATTITUDE_DATA, COMMAND_ACK_DATA, Message};
use helmlink_wire::{Encoder, Framer, Identity};
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::{TcpListener, TcpStream};

use crate::link::test_support::{bytes, down, gather, hub_at, open, port, quick, up, within};
use crate::link::{Hub, LinkId, LinkSettings};

async fn client_of(hub: &mut Hub) -> (LinkId, TcpStream) {
    let stream = TcpStream::connect(("127.0.0.1", port(hub))).await.unwrap();
    let (link, peer) = up(hub).await;
    assert_eq!(peer, stream.local_addr().unwrap().to_string());
    (link, stream)
}

async fn receive(stream: &mut TcpStream, count: usize) -> Vec<u8> {
    let mut buffer = vec![0; count];
    within("bytes from the hub", stream.read_exact(&mut buffer)).await.unwrap();
    buffer
}

#[tokio::test]
async fn five_clients_each_hold_their_own_conversation() {
    let mut hub = hub_at("tcpin:127.0.0.1:0", LinkSettings::default()).await;
    let mut clients = Vec::new();
    for _ in 0..5 {
        clients.push(client_of(&mut hub).await);
    }
    for (link, stream) in &mut clients {
        stream.write_all(&[link.0 as u8; 9]).await.unwrap();
        assert_eq!(gather(&mut hub, *link, 9).await, [link.0 as u8; 9]);
        assert!(hub.send(*link, &[100 + link.0 as u8; 5]));
    }
    for (link, stream) in &mut clients {
        assert_eq!(receive(stream, 5).await, [100 + link.0 as u8; 5]);
    }
    let (gone, stream) = clients.remove(2);
    drop(stream);
    assert_eq!(down(&mut hub).await, (gone, "closed by the other side".to_owned()));
    assert!(!hub.send(gone, b"x"));
    for (link, _) in &clients {
        assert!(hub.send(*link, b"x"));
    }
}

#[tokio::test]
async fn tcpout_waits_for_its_server_and_returns_after_losing_it() {
    let reserved = TcpListener::bind("127.0.0.1:0").await.unwrap();
    let address = reserved.local_addr().unwrap();
    drop(reserved);
    let mut hub = hub_at(&format!("tcp:{address}"), quick()).await;
    // Several refusals go by first: the hub's task runs while this one sleeps on the runtime's clock.
    assert!(tokio::time::timeout(Duration::from_millis(50), hub.next_event()).await.is_err());

    let mut seen = Vec::new();
    for _ in 0..3 {
        let server = TcpListener::bind(address).await.unwrap();
        let (mut stream, _) = within("the hub to connect", server.accept()).await.unwrap();
        let (link, peer) = up(&mut hub).await;
        assert_eq!(peer, address.to_string());
        assert!(!seen.contains(&link));
        seen.push(link);
        stream.write_all(b"hello").await.unwrap();
        assert_eq!(gather(&mut hub, link, 5).await, b"hello");
        hub.send(link, b"hi");
        assert_eq!(receive(&mut stream, 2).await, b"hi");
        drop((stream, server));
        assert_eq!(down(&mut hub).await.0, link);
    }
}

#[tokio::test]
async fn a_server_that_hangs_up_without_a_word_is_tried_ever_more_rarely() {
    let server = TcpListener::bind("127.0.0.1:0").await.unwrap();
    let settings = LinkSettings {
        retry_first: Duration::from_millis(10),
        retry_longest: Duration::from_secs(60),
        ..LinkSettings::default()
    };
    let mut hub = hub_at(&format!("tcp:{}", server.local_addr().unwrap()), settings).await;
    let start = tokio::time::Instant::now();
    for _ in 0..5 {
        drop(within("the hub to connect", server.accept()).await.unwrap());
        up(&mut hub).await;
        down(&mut hub).await;
    }
    // 10 + 20 + 40 + 80 ms lie between the five connections.
    assert!(start.elapsed() >= Duration::from_millis(150), "{:?}", start.elapsed());
}

#[tokio::test]
async fn a_client_that_never_reads_loses_writes_and_holds_up_nobody() {
    let mut hub = hub_at("tcpin:127.0.0.1:0", LinkSettings::default()).await;
    let (deaf, deaf_stream) = client_of(&mut hub).await;
    let (one, mut one_stream) = client_of(&mut hub).await;
    let (two, mut two_stream) = client_of(&mut hub).await;
    let write = [7; 16 * 1024];
    let mut rounds = 0u64;
    // In step with the readers: were they held up, this would not end.
    while hub.traffic(deaf).unwrap().lost_writes < 100 {
        for link in [deaf, one, two] {
            assert!(hub.send(link, &write));
        }
        receive(&mut one_stream, write.len()).await;
        receive(&mut two_stream, write.len()).await;
        rounds += 1;
    }
    for link in [one, two] {
        let traffic = hub.traffic(link).unwrap();
        assert_eq!((traffic.lost_writes, traffic.sent_bytes), (0, rounds * write.len() as u64));
    }
    drop(deaf_stream);
    assert_eq!(down(&mut hub).await.0, deaf);
}

fn ten_of(message: &Message) -> Vec<u8> {
    let (mut encoder, mut bytes) = (Encoder::new(), Vec::new());
    (0..10).for_each(|_| encoder.encode(Identity { system: 1, component: 1 }, message, &mut bytes));
    bytes
}

/// Writes until so many writes have been lost.
async fn flood(hub: &Hub, link: LinkId, write: &[u8], lost_writes: u64) {
    while hub.traffic(link).unwrap().lost_writes < lost_writes {
        assert!(hub.send(link, write));
        tokio::task::yield_now().await;
    }
}

#[tokio::test]
async fn a_client_that_reads_again_after_a_flood_finds_the_answer_to_its_question() {
    let mut hub = hub_at("tcpin:127.0.0.1:0", LinkSettings::default()).await;
    let (deaf, mut stream) = client_of(&mut hub).await;
    let attitudes = ten_of(&Message::ATTITUDE(ATTITUDE_DATA { yawspeed: 1.0, ..ATTITUDE_DATA::DEFAULT }));
    let answers =
        ten_of(&Message::COMMAND_ACK(COMMAND_ACK_DATA { command: 400, ..COMMAND_ACK_DATA::DEFAULT }));
    // What the system holds and the queue are full before the answers come, and the queue is renewed after them.
    flood(&hub, deaf, &attitudes, 100).await;
    assert!(hub.send(deaf, &answers));
    flood(&hub, deaf, &attitudes, 2000).await;
    let (mut framer, mut buffer, mut found) = (Framer::new(), vec![0; 65_536], 0);
    while found < 10 {
        let count = within("the answers", stream.read(&mut buffer)).await.unwrap();
        framer.push(&buffer[..count]);
        while let Some(frame) = framer.next_frame() {
            found += u32::from(frame.message_id() == 77);
        }
    }
}

#[tokio::test]
async fn a_client_that_takes_nothing_for_too_long_is_dropped_and_the_others_stay() {
    let settings = LinkSettings { write_stall: Duration::from_millis(100), ..quick() };
    let mut hub = hub_at("tcpin:127.0.0.1:0", settings).await;
    let (deaf, _deaf_stream) = client_of(&mut hub).await;
    let (other, mut stream) = client_of(&mut hub).await;
    let filling = within("the deaf client to be dropped", async {
        while hub.send(deaf, &[0; 16 * 1024]) {
            tokio::task::yield_now().await;
        }
    });
    filling.await;
    assert_eq!(down(&mut hub).await, (deaf, "took no bytes for 100ms".to_owned()));
    hub.send(other, b"still here");
    assert_eq!(receive(&mut stream, 10).await, b"still here");
}

#[tokio::test]
async fn a_hub_that_takes_no_events_slows_a_talkative_client_and_loses_nothing() {
    let settings = LinkSettings { event_capacity: 2, ..LinkSettings::default() };
    let mut hub = hub_at("tcpin:127.0.0.1:0", settings).await;
    let (link, mut stream) = client_of(&mut hub).await;
    let sent: Vec<u8> = (0..2_000_000u32).map(|index| (index % 251) as u8).collect();
    let (received, written) = tokio::join!(gather(&mut hub, link, sent.len()), stream.write_all(&sent));
    written.unwrap();
    assert!(received == sent);
}

#[tokio::test]
async fn closing_writes_what_waits_even_with_unread_bytes_and_frees_the_port() {
    let mut hub = hub_at("tcpin:127.0.0.1:0", LinkSettings { event_capacity: 1, ..quick() }).await;
    let url = format!("tcpin:127.0.0.1:{}", port(&hub));
    let (link, mut stream) = client_of(&mut hub).await;
    stream.write_all(&[1; 100_000]).await.unwrap();
    bytes(&mut hub).await;
    for number in 0..100u8 {
        hub.send(link, &[number; 600]);
    }
    within("the hub to close", hub.close()).await;
    let received = receive(&mut stream, 60_000).await;
    assert!(received.chunks(600).enumerate().all(|(index, chunk)| chunk == [index as u8; 600]));
    open(&mut Hub::new(quick()), &url).await;
}

#[tokio::test]
async fn dropping_the_hub_writes_what_waits_and_ends_its_tasks() {
    let mut hub = hub_at("tcpin:127.0.0.1:0", LinkSettings::default()).await;
    let address = ("127.0.0.1", port(&hub));
    let (link, mut stream) = client_of(&mut hub).await;
    hub.send(link, b"last words");
    drop(hub);
    let mut received = Vec::new();
    within("the end of the stream", stream.read_to_end(&mut received)).await.unwrap();
    assert_eq!(received, b"last words");
    assert!(TcpStream::connect(address).await.is_err());
}

#[tokio::test]
async fn closing_does_not_wait_for_a_client_that_never_reads() {
    let settings = LinkSettings { flush: Duration::from_millis(50), ..quick() };
    let mut hub = hub_at("tcpin:127.0.0.1:0", settings).await;
    let (deaf, _deaf_stream) = client_of(&mut hub).await;
    while hub.traffic(deaf).unwrap().lost_writes < 100 {
        hub.send(deaf, &[0; 16 * 1024]);
        tokio::task::yield_now().await;
    }
    let start = tokio::time::Instant::now();
    within("the hub to close", hub.close()).await;
    assert!(start.elapsed() >= Duration::from_millis(50));
}

#[tokio::test]
async fn a_port_in_use_is_an_error_with_cause_and_fix() {
    let holder = TcpListener::bind("127.0.0.1:0").await.unwrap();
    let port = holder.local_addr().unwrap().port();
    let url = format!("tcpin:127.0.0.1:{port}");
    let error = Hub::new(quick()).open(&url.parse().unwrap()).await.unwrap_err();
    assert_eq!(
        error.to_string(),
        format!(
            "cannot open {url}: port {port} is already in use; end the program that holds it \
             (`ss -ltnp 'sport = :{port}'` names it) or choose another port"
        )
    );
}
