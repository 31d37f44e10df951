//! What those who run the bridge as a service want to know: figures, readiness, a sign of life.

use std::time::Duration;

use clap::Args;

use super::Live;
use super::figures;
use super::lateness::Lateness;
use super::process::Usage;
use super::service_manager::{self, News};
use super::signing::SigningStore;
use crate::app::failure::Failure;
use crate::app::metrics::{MetricsAddress, Server};
use crate::bridge::Health;

/// Options for running as a service.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Operation")]
pub struct OperationArgs {
    /// Serve figures for Prometheus at http://127.0.0.1:PORT/metrics (or at ADDRESS:PORT)
    #[arg(long, value_name = "PORT|ADDRESS:PORT")]
    pub metrics: Option<MetricsAddress>,
}

/// How often figures and the service manager's status line are renewed.
const RENEWAL: Duration = Duration::from_secs(1);

/// Tells the outside world how the bridge fares.
pub(super) struct Operation {
    lateness: Lateness,
    interval: Duration,
    server: Option<Server>,
    renewed: Option<Duration>,
    /// When the process was last measured, and the processor time that it had used by then, seconds.
    measured: Option<(Duration, f64)>,
    /// How often systemd wants a sign of life, half of what it waits.
    watchdog: Option<Duration>,
    lived: Duration,
    said: &'static str,
    signing: Option<SigningStore>,
}

impl Operation {
    /// Starts to serve figures, if asked to; `interval` is that of the control loop.
    pub(super) async fn start(args: &OperationArgs, interval: Duration) -> Result<Self, Failure> {
        let server = match args.metrics {
            Some(at) => Some(Server::start(at).await?),
            None => None,
        };
        if let Some(server) = &server {
            tracing::info!("figures at http://{}/metrics", server.address());
        }
        let watchdog = service_manager::watchdog().map(|limit| limit / 2);
        let lateness = Lateness::default();
        Ok(Self {
            lateness,
            interval,
            server,
            renewed: None,
            measured: None,
            watchdog,
            lived: Duration::ZERO,
            said: "",
            signing: None,
        })
    }

    /// The time stamps of signatures are to be kept for the next run.
    pub(super) fn keep(&mut self, signing: Option<SigningStore>) {
        self.signing = signing;
    }

    /// All links are open: whoever waits for this service may go on.
    pub(super) fn ready(&self) {
        service_manager::tell(News::Ready);
    }

    /// After each turn of the loop.
    pub(super) fn after_turn(&mut self, edge: &Live) {
        let steps = edge.party.steps();
        if self.lateness.is_news(steps) {
            self.lateness.on_turn(edge.began(), edge.now(), steps, self.interval);
        }
    }

    /// After each tick. A loop that hangs no longer comes here, and the service manager restarts it.
    pub(super) fn after_tick(&mut self, edge: &Live) {
        let now = edge.now();
        let status = edge.party.status();
        if self.watchdog.is_some_and(|interval| now.saturating_sub(self.lived) >= interval) {
            self.lived = now;
            service_manager::tell(News::Alive);
        }
        if let Some(store) = &mut self.signing {
            store.save_when_due(now, edge.party.gate.timestamp());
        }
        if self.renewed.is_some_and(|then| now.saturating_sub(then) < RENEWAL) {
            return;
        }
        self.renewed = Some(now);
        if status.state.name() != self.said {
            self.said = status.state.name();
            service_manager::tell(News::State(self.said));
        }
        if let Some(server) = &self.server {
            server.publish(figures::page(edge, &self.lateness));
        }
    }

    /// How the process is, for the ground station: once a second, where the system tells.
    pub(super) fn health(&mut self, now: Duration) -> Option<Health> {
        if self.measured.is_some_and(|(then, _)| now.saturating_sub(then) < RENEWAL) {
            return None;
        }
        let usage = Usage::now()?;
        let (then, before_s) = self.measured.replace((now, usage.cpu_s))?;
        let elapsed_s = now.saturating_sub(then).as_secs_f64();
        let late_ms = self.lateness.handling().map_or(0.0, |handling| handling.max_s * 1000.0);
        Some(Health {
            late_ms: late_ms as f32,
            cpu_percent: (100.0 * (usage.cpu_s - before_s) / elapsed_s) as f32,
            memory_mb: (usage.resident_bytes * 1e-6) as f32,
        })
    }

    /// The boat has been let go.
    pub(super) fn end(&mut self, edge: &Live) {
        service_manager::tell(News::Stopping);
        if let Some(store) = &mut self.signing {
            store.save(edge.party.gate.timestamp());
        }
    }
}
