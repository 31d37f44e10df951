//! As much of HTTP as it takes to hand out one page.

use std::net::SocketAddr;
use std::time::Duration;

use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::{TcpListener, TcpStream};
use tokio::sync::watch;
use tokio::time::timeout;

use super::MetricsAddress;
use crate::app::failure::Failure;

/// Whoever takes longer than this to ask and to listen gets nothing.
const PATIENCE: Duration = Duration::from_secs(2);
/// The longest request that is read, bytes.
const LONGEST_REQUEST: usize = 8192;
/// Wait after an error of the system, such as too many open files.
const RECOVERY: Duration = Duration::from_secs(1);

/// Serves the newest page at `/metrics` until dropped.
pub(in crate::app) struct Server {
    page: watch::Sender<String>,
    task: tokio::task::JoinHandle<()>,
    address: SocketAddr,
}

impl Server {
    /// Starts to serve.
    pub(in crate::app) async fn start(at: MetricsAddress) -> Result<Self, Failure> {
        let fault = |error| Failure::usage(format!("--metrics: cannot listen at {}: {error}", at.0));
        let listener = TcpListener::bind(at.0).await.map_err(fault)?;
        let address = listener.local_addr().map_err(fault)?;
        let (page, newest) = watch::channel(String::new());
        let task = tokio::spawn(serve(listener, newest));
        Ok(Self { page, task, address })
    }

    /// Where it listens.
    pub(in crate::app) fn address(&self) -> SocketAddr {
        self.address
    }

    /// Replaces the page.
    pub(in crate::app) fn publish(&self, page: String) {
        self.page.send_replace(page);
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        self.task.abort();
    }
}

/// Answers one client at a time: the boat's time is for other things.
async fn serve(listener: TcpListener, newest: watch::Receiver<String>) {
    loop {
        match listener.accept().await {
            Ok((stream, _)) => {
                let page = newest.borrow().clone();
                // One that asks too slowly or hangs up is its own loss.
                _ = timeout(PATIENCE, answer(stream, &page)).await;
            }
            Err(_) => tokio::time::sleep(RECOVERY).await,
        }
    }
}

async fn answer(mut stream: TcpStream, page: &str) -> std::io::Result<()> {
    let mut request = Vec::new();
    while !request.windows(4).any(|window| window == b"\r\n\r\n") {
        let mut piece = [0; 1024];
        let count = stream.read(&mut piece).await?;
        if count == 0 || request.len() > LONGEST_REQUEST {
            return Ok(());
        }
        request.extend_from_slice(&piece[..count]);
    }
    let (status, body) = match request.split(|&byte| byte == b' ').take(2).collect::<Vec<_>>()[..] {
        [b"GET", path] if path == b"/metrics" || path.starts_with(b"/metrics?") => ("200 OK", page),
        [b"GET", _] => ("404 Not Found", "The figures are at /metrics.\n"),
        _ => ("405 Method Not Allowed", "Only GET is understood.\n"),
    };
    let head = format!(
        "HTTP/1.1 {status}\r\nContent-Type: text/plain; version=0.0.4; charset=utf-8\r\nContent-Length: {}\r\n\
         Connection: close\r\n\r\n",
        body.len()
    );
    stream.write_all(head.as_bytes()).await?;
    stream.write_all(body.as_bytes()).await?;
    stream.shutdown().await
}

#[cfg(test)]
mod tests {
    use super::*;

    async fn ask(server: &Server, request: &str) -> String {
        let mut stream = TcpStream::connect(server.address()).await.unwrap();
        // One that is turned away may find the connection reset.
        stream.write_all(request.as_bytes()).await.ok();
        let mut answer = String::new();
        stream.read_to_string(&mut answer).await.ok();
        answer
    }

    #[tokio::test]
    async fn hands_out_the_newest_page_and_nothing_else() {
        let server = Server::start("0".parse().unwrap()).await.unwrap();
        assert!(server.address().ip().is_loopback());
        for page in ["first 1\n", "second 2\n"] {
            server.publish(page.to_owned());
            let answer = ask(&server, "GET /metrics HTTP/1.1\r\nHost: boat\r\n\r\n").await;
            assert!(answer.starts_with("HTTP/1.1 200 OK\r\n") && answer.ends_with(page), "{answer}");
        }
        assert!(ask(&server, "GET / HTTP/1.1\r\n\r\n").await.starts_with("HTTP/1.1 404"));
        assert!(ask(&server, "POST /metrics HTTP/1.1\r\n\r\n").await.starts_with("HTTP/1.1 405"));
        assert_eq!(ask(&server, &"x".repeat(3 * LONGEST_REQUEST)).await, "");
    }
}
