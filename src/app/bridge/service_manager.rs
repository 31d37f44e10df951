//! What systemd is told, if it has started this program; elsewhere nothing happens.

use std::time::Duration;

/// Something for the service manager.
#[derive(Debug, Clone, Copy)]
pub(super) enum News {
    /// All links are open: whoever waits for this service may go on.
    Ready,
    /// The loop goes round.
    Alive,
    /// The bridge's state, for its status line.
    State(&'static str),
    /// It is about to end.
    Stopping,
}

/// How long the service manager waits for a sign of life, if it does.
#[cfg(unix)]
pub(super) fn watchdog() -> Option<Duration> {
    sd_notify::watchdog_enabled()
}

#[cfg(unix)]
pub(super) fn tell(news: News) {
    use sd_notify::NotifyState;
    let state = match news {
        News::Ready => NotifyState::Ready,
        News::Alive => NotifyState::Watchdog,
        News::State(name) => NotifyState::Status(name),
        News::Stopping => NotifyState::Stopping,
    };
    if let Err(error) = sd_notify::notify(&[state]) {
        tracing::debug!("the service manager does not listen: {error}");
    }
}

/// No systemd here.
#[cfg(not(unix))]
pub(super) fn watchdog() -> Option<Duration> {
    None
}

#[cfg(not(unix))]
pub(super) fn tell(_: News) {}
