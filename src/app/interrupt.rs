//! The ways in which a program is asked to end.

/// Waits for Ctrl-C, the signal with which services are ended, or the terminal going away.
#[cfg(unix)]
pub(super) async fn interrupted() {
    use tokio::signal::unix::SignalKind;

    let hangup = if ignores_hangup() { None } else { Some(SignalKind::hangup()) };
    tokio::select! {
        () = arrival(Some(SignalKind::interrupt())) => {}
        () = arrival(Some(SignalKind::terminate())) => {}
        () = arrival(hangup) => {}
    }
}

/// Elsewhere, Ctrl-C alone.
#[cfg(not(unix))]
pub(super) async fn interrupted() {
    tokio::signal::ctrl_c().await.ok();
}

/// Waits for a signal; for ever where there is none to wait for.
#[cfg(unix)]
async fn arrival(kind: Option<tokio::signal::unix::SignalKind>) {
    if let Some(mut signal) = kind.and_then(|kind| tokio::signal::unix::signal(kind).ok()) {
        signal.recv().await;
    } else {
        std::future::pending::<()>().await;
    }
}

/// Whether whoever started this program wants it to outlive the terminal, as `nohup` does.
#[cfg(unix)]
fn ignores_hangup() -> bool {
    // Signal 1 is the lowest bit. Only Linux tells; elsewhere nobody is taken to want it.
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let ignored = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    ignored.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok()).is_some_and(|mask| mask & 1 != 0)
}
