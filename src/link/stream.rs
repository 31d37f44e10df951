//! What TCP connections and serial ports have in common: bytes both ways until something ends it.

use std::fmt;
use std::io;
use std::pin::pin;
use std::time::Duration;

use tokio::io::{AsyncRead, AsyncReadExt, AsyncWrite, AsyncWriteExt};
use tokio::time::timeout;

use super::hub::Endpoint;
use super::peer::{Outbox, Peer};

/// Bytes asked for in one read.
const READ_BYTES: usize = 4096;

/// What ended a conversation.
#[derive(Debug)]
pub(super) enum End {
    /// The other side closed it (TCP), or the device hung up (serial).
    ClosedByPeer,
    /// None of the bytes written were taken for this long.
    Stalled(Duration),
    /// The system reported an error.
    Failed(io::Error),
    /// The hub was closed; what waited has been written, as far as time allowed.
    HubClosed,
}

impl fmt::Display for End {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::ClosedByPeer => f.write_str("closed by the other side"),
            Self::Stalled(limit) => write!(f, "took no bytes for {limit:?}"),
            Self::Failed(error) => write!(f, "{error}"),
            Self::HubClosed => f.write_str("closed by this side"),
        }
    }
}

/// Carries bytes between a peer's stream and the hub until one of them ends.
pub(super) async fn converse<R, W>(endpoint: &Endpoint, peer: &Peer, reader: R, writer: W) -> End
where
    R: AsyncRead + Unpin,
    W: AsyncWrite + Unpin,
{
    let mut writing = pin!(write_all(writer, &peer.outbox, endpoint.settings.write_stall));
    let end = tokio::select! {
        end = read_all(reader, peer) => end,
        // The outbox closes below at the earliest, so writing ends only by failing.
        end = &mut writing => return end,
        () = endpoint.closing.cancelled() => End::HubClosed,
    };
    if matches!(end, End::HubClosed) {
        // The write under way is continued, not started anew: its first bytes may be out already.
        peer.outbox.close();
        if timeout(endpoint.settings.flush, writing).await.is_err() {
            tracing::debug!(link = peer.link.0, "closed before everything was written");
        }
    }
    end
}

async fn read_all<R: AsyncRead + Unpin>(mut reader: R, peer: &Peer) -> End {
    let mut buffer = [0; READ_BYTES];
    loop {
        match reader.read(&mut buffer).await {
            Ok(0) => return End::ClosedByPeer,
            Ok(count) => {
                if peer.received(&buffer[..count], false).await.is_err() {
                    return End::HubClosed;
                }
            }
            Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
            Err(error) => return End::Failed(error),
        }
    }
}

/// Writes what the outbox holds until it is closed and empty.
async fn write_all<W: AsyncWrite + Unpin>(mut writer: W, outbox: &Outbox, stall: Duration) -> End {
    while let Some(data) = outbox.next().await {
        let mut rest = &data[..];
        while !rest.is_empty() {
            match timeout(stall, writer.write(rest)).await {
                Err(_) => return End::Stalled(stall),
                Ok(Ok(0)) => return End::ClosedByPeer,
                Ok(Ok(count)) => {
                    outbox.count_sent(count);
                    rest = &rest[count..];
                }
                Ok(Err(error)) if error.kind() == io::ErrorKind::Interrupted => {}
                Ok(Err(error)) => return End::Failed(error),
            }
        }
    }
    End::HubClosed
}
