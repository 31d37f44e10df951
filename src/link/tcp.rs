//! TCP: a server for any number of clients, and a client that connects again and again.

use std::io;
use std::net::SocketAddr;
use std::time::Duration;

use socket2::{SockRef, TcpKeepalive};
use tokio::net::{TcpListener, TcpStream};
use tokio::time::timeout;

use super::address::{name, resolve};
use super::backoff::{Backoff, Complaints};
use super::error::OpenError;
use super::hub::Endpoint;
use super::peer::Peer;
use super::stream::{End, converse};
use super::url::{HostPort, LinkUrl};

/// Unanswered probes after which an idle connection counts as dead. Half of
/// [`write_stall`](super::LinkSettings::write_stall) passes before the first, the rest between them.
const KEEPALIVE_PROBES: u32 = 3;
/// Shortest time the system accepts between probes.
const KEEPALIVE_LEAST: Duration = Duration::from_secs(1);

/// Binds `at` and serves every client that connects. Returns the address bound.
pub(super) async fn listen(
    endpoint: Endpoint,
    url: &LinkUrl,
    at: &HostPort,
) -> Result<SocketAddr, OpenError> {
    let addresses = resolve(url, at).await?;
    let bind_error = |error| OpenError::from_bind(url, at, error);
    let listener = TcpListener::bind(&addresses[..]).await.map_err(bind_error)?;
    let local_address = listener.local_addr().map_err(bind_error)?;
    let tasks = endpoint.clone();
    tasks.spawn(accept_all(endpoint, listener));
    Ok(local_address)
}

async fn accept_all(endpoint: Endpoint, listener: TcpListener) {
    let mut backoff = Backoff::new(endpoint.settings.retry_first, endpoint.settings.retry_longest);
    loop {
        let accepted = match endpoint.closing.run_until_cancelled(listener.accept()).await {
            Some(accepted) => accepted,
            None => return,
        };
        match accepted {
            Ok((stream, remote)) => {
                backoff.reset();
                let client = endpoint.clone();
                endpoint.spawn(async move {
                    serve(&client, stream, name(remote)).await;
                });
            }
            // Such as too many open files: the next attempt would fail as quickly.
            Err(error) => {
                tracing::warn!(%error, "cannot accept a TCP client");
                if !endpoint.pause(backoff.next_delay()).await {
                    return;
                }
            }
        }
    }
}

/// Connects to the server at `to`, and again whenever the connection cannot be made or is lost.
pub(super) fn connect(endpoint: Endpoint, to: HostPort) {
    let tasks = endpoint.clone();
    tasks.spawn(stay_connected(endpoint, to));
}

async fn stay_connected(endpoint: Endpoint, to: HostPort) {
    let mut backoff = Backoff::new(endpoint.settings.retry_first, endpoint.settings.retry_longest);
    let mut complaints = Complaints::default();
    loop {
        let attempt = timeout(endpoint.settings.connect_timeout, TcpStream::connect((to.host(), to.port())));
        let result = match endpoint.closing.run_until_cancelled(attempt).await {
            Some(result) => result.unwrap_or_else(|_| Err(io::ErrorKind::TimedOut.into())),
            None => return,
        };
        match result.and_then(refuse_itself) {
            Ok(stream) => {
                complaints.reset();
                // A server that says nothing before it hangs up may do so each time.
                if serve(&endpoint, stream, to.to_string()).await {
                    backoff.reset();
                }
            }
            Err(error) => {
                let reason = error.to_string();
                if complaints.is_news(&reason) {
                    tracing::warn!(%reason, server = %to, "no TCP server there yet; trying on");
                }
            }
        }
        if !endpoint.pause(backoff.next_delay()).await {
            return;
        }
    }
}

/// Where no server listens on a port of this machine, the system may pick that very port for the outgoing
/// connection, which is then joined to itself and would hear its own words.
fn refuse_itself(stream: TcpStream) -> io::Result<TcpStream> {
    if stream.local_addr()? == stream.peer_addr()? {
        return Err(io::ErrorKind::ConnectionRefused.into());
    }
    Ok(stream)
}

/// Carries one connection to its end; true when the peer has said anything.
async fn serve(endpoint: &Endpoint, mut stream: TcpStream, name: String) -> bool {
    if let Err(error) = tune(&stream, endpoint) {
        tracing::debug!(%error, peer = %name, "socket options refused");
    }
    let peer = Peer::register(endpoint, name, endpoint.settings.queue_bytes);
    if peer.announce().await.is_err() {
        return false;
    }
    let (reader, writer) = stream.split();
    let end = match converse(endpoint, &peer, reader, writer).await {
        // The system's own watch over unacknowledged bytes, set to the same time, may come first.
        End::Failed(error) if error.kind() == io::ErrorKind::TimedOut => {
            End::Stalled(endpoint.settings.write_stall)
        }
        end => end,
    };
    match end {
        End::HubClosed => discard_unread(&stream),
        // Nobody will take what the system still holds for this peer.
        End::Stalled(_) => _ = stream.set_zero_linger(),
        End::ClosedByPeer | End::Failed(_) => {}
    }
    drop(stream);
    let heard = peer.outbox.traffic().received_bytes > 0;
    // Without a listener for events there is nobody to tell.
    _ = peer.leave(end.to_string()).await;
    heard
}

/// Sends at once, and notices a peer whose machine has vanished: by probes while the line is idle, by
/// missing acknowledgements while it is not.
fn tune(stream: &TcpStream, endpoint: &Endpoint) -> io::Result<()> {
    stream.set_nodelay(true)?;
    let socket = SockRef::from(stream);
    let limit = endpoint.settings.write_stall;
    let probing = TcpKeepalive::new()
        .with_time((limit / 2).max(KEEPALIVE_LEAST))
        .with_interval((limit / 2 / KEEPALIVE_PROBES).max(KEEPALIVE_LEAST))
        .with_retries(KEEPALIVE_PROBES);
    socket.set_tcp_keepalive(&probing)?;
    #[cfg(target_os = "linux")]
    socket.set_tcp_user_timeout(Some(limit))?;
    Ok(())
}

/// Closing a socket with unread bytes resets the connection and takes with it what was written last.
fn discard_unread(stream: &TcpStream) {
    let mut buffer = [0; 4096];
    while matches!(stream.try_read(&mut buffer), Ok(count) if count > 0) {}
}

#[cfg(test)]
mod tests;
