//! `helmlink replay --to URL`: the log out to a link, at any pace.

use std::time::Duration;

use helmlink_wire::LinkId;
use helmlink_wire::tlog::Index;
use tokio::sync::mpsc::{UnboundedReceiver, unbounded_channel};

use super::log_files::Joined;
use super::{LogFiles, ReplayArgs};
use crate::app::console::{self, ProgressLine};
use crate::app::edge::{Edge, Party, Seen};
use crate::app::failure::Failure;
use crate::app::interrupt::interrupted;
use crate::app::recorder::unix_time_us;
use crate::link::{EndpointId, Hub, LinkSettings, LinkUrl};
use crate::replay::play::{PlayFilter, PlaySettings, Player, message_id};

/// How often the player looks at the clock.
const TICK: Duration = Duration::from_millis(2);
/// Frames sent in one go at the most, so that a pace beyond what the link carries does not fill memory.
const FRAMES_PER_TICK: usize = 2000;
/// Time between two updates of the progress line.
const PROGRESS: Duration = Duration::from_millis(250);

pub(super) fn run(args: &ReplayArgs, files: &LogFiles, url: &LinkUrl) -> Result<(), Failure> {
    if !args.yes_send {
        return Err(Failure::usage(format!(
            "this would send recorded frames to {url}; if that is what you want, and no real vehicle obeys there, add --yes-send"
        )));
    }
    let name = files.shown();
    let read = |error: std::io::Error| Failure::usage(format!("cannot read {name}: {error}"));
    let index = Index::build(files.open()).map_err(read)?;
    let Some((first_us, _)) = index.span_us else {
        return Err(Failure::usage(format!("{name} holds no MAVLink frame")));
    };
    let rebase_us = args.rebase.then(|| unix_time_us() as i64 - first_us as i64);
    let settings = PlaySettings {
        speedup: *args.speedup,
        from_s: *args.from,
        until_s: args.until.map(f64::from),
        looped: args.looped,
        filter: filter(args)?,
        rebase_us,
    };
    let player =
        Player::new(files.open_joined().map_err(read)?, index, settings, Duration::ZERO).map_err(read)?;
    let runtime =
        tokio::runtime::Builder::new_current_thread().enable_all().build().map_err(Failure::failed)?;
    runtime.block_on(play(args, url, player))
}

fn filter(args: &ReplayArgs) -> Result<PlayFilter, Failure> {
    let ids = |names: &[String]| {
        names
            .iter()
            .map(|name| {
                message_id(name).ok_or_else(|| {
                    Failure::usage(format!(
                        "`{name}` is no MAVLink message: give names such as ATTITUDE, or numbers"
                    ))
                })
            })
            .collect::<Result<Vec<u32>, _>>()
    };
    Ok(PlayFilter {
        only: ids(&args.only)?,
        except: ids(&args.except)?,
        systems: args.systems.iter().map(|system| **system).collect(),
        commands: args.commands,
    })
}

async fn play(args: &ReplayArgs, url: &LinkUrl, player: Player<Joined>) -> Result<(), Failure> {
    let mut hub = Hub::new(LinkSettings::default());
    let endpoint = hub.open(url).await.map_err(Failure::usage)?;
    tracing::info!("playing {:.1} s at {} × to {url}", player.length_s(), args.speedup);
    if let Some(address) = hub.local_address(endpoint) {
        tracing::info!("listening at {address}");
    }
    let mut edge = Edge::new(
        Station { player, links: Vec::new(), due: Vec::new(), begun: false, error: None },
        hub,
        TICK,
    );
    let mut keys = commands();
    let mut line = ProgressLine::new(&args.common);
    let mut progress = tokio::time::interval(PROGRESS);
    let mut interrupt = std::pin::pin!(interrupted());
    loop {
        tokio::select! {
            biased;
            () = &mut interrupt => break,
            Some(key) = keys.recv() => {
                let now = edge.now();
                match edge.party.obey(now, &key) {
                    Ok(true) => {}
                    Ok(false) => break,
                    Err(text) => { line.clear(); tracing::warn!("{text}"); }
                }
            }
            _ = progress.tick() => line.show(&edge.party.progress(edge.now())),
            seen = edge.turn() => if let Some(Seen::Up(peer)) = seen { line.clear(); tracing::info!("link up: {peer}"); },
        }
        if let Some(error) = edge.party.error.take() {
            return Err(Failure::failed(format!("cannot read the log: {error}")));
        }
        if edge.party.player.is_ended() {
            break;
        }
        if !edge.party.begun && *args.wait > 0.0 && edge.now().as_secs_f64() > *args.wait {
            return Err(Failure::no_link(format!(
                "nobody has come to {url} for {:.0} s (--wait 0 waits for ever)",
                args.wait
            )));
        }
    }
    line.clear();
    let station = edge.close().await;
    let (played, kept_back) = (station.player.played, station.player.kept_back);
    if args.common.json {
        console::say(
            &serde_json::json!({ "frames": played, "kept_back": kept_back, "to": url.to_string() })
                .to_string(),
        );
    } else {
        let hint = if args.commands { "" } else { " (commands among them: --commands sends those too)" };
        console::say(&format!("{played} frames sent, {kept_back} kept back{hint}"));
    }
    Ok(())
}

/// Lines typed by the user: p, +10, -10, @60, x4, q.
fn commands() -> UnboundedReceiver<String> {
    let (sender, receiver) = unbounded_channel();
    // The thread waits in a read that cannot be ended; it goes with the process.
    std::thread::spawn(move || {
        for line in std::io::stdin().lines() {
            let Ok(line) = line else { break };
            if sender.send(line).is_err() {
                break;
            }
        }
        // With the sender kept, the end of the input is no key.
        std::mem::forget(sender);
    });
    receiver
}

/// The side of the link that plays.
struct Station {
    player: Player<Joined>,
    links: Vec<LinkId>,
    due: Vec<(LinkId, Vec<u8>)>,
    begun: bool,
    error: Option<std::io::Error>,
}

impl Station {
    fn progress(&self, now: Duration) -> String {
        let state = match (self.begun, self.player.is_paused()) {
            (false, _) => "waiting for a peer",
            (true, true) => "paused",
            (true, false) => "playing",
        };
        format!(
            "{state}   {:.1} of {:.1} s   {} frames   (p pause, +10 / -10 seek, @60 go to, x4 pace, q end; then Enter)",
            self.player.position_s(now),
            self.player.length_s(),
            self.player.played
        )
    }

    /// Carries out what the user has typed; false to end.
    fn obey(&mut self, now: Duration, key: &str) -> Result<bool, String> {
        let key = key.trim();
        let number = |text: &str| text.parse::<f64>().ok().filter(|number| number.is_finite());
        let seek = match key.chars().next() {
            Some('+' | '-') => number(key).map(|by_s| self.player.position_s(now) + by_s),
            Some('@') => number(&key[1..]),
            _ => None,
        };
        if let Some(to_s) = seek {
            return self.player.seek(now, to_s).map(|()| true).map_err(|error| error.to_string());
        }
        match key {
            "p" | "" => self.player.set_paused(now, !self.player.is_paused()),
            "q" => return Ok(false),
            _ => match key.strip_prefix('x').and_then(number).filter(|pace| *pace > 0.0) {
                Some(pace) => self.player.set_speedup(now, pace),
                None => return Err(format!("`{key}`: type p, +10, -10, @60, x4 or q")),
            },
        }
        Ok(true)
    }
}

impl Party for Station {
    fn link_up(&mut self, now: Duration, link: LinkId, _endpoint: EndpointId) {
        self.links.push(link);
        if !self.begun {
            self.begun = true;
            let at_s = self.player.position_s(Duration::ZERO);
            self.error = self.player.seek(now, at_s).err();
        }
    }

    fn link_down(&mut self, _now: Duration, link: LinkId) {
        self.links.retain(|known| *known != link);
    }

    fn on_bytes(&mut self, _now: Duration, _link: LinkId, _bytes: &[u8], _is_datagram: bool) {}

    fn on_tick(&mut self, now: Duration) {
        if !self.begun {
            return;
        }
        for _ in 0..FRAMES_PER_TICK {
            match self.player.poll(now) {
                Ok(Some(frame)) => self.due.extend(self.links.iter().map(|link| (*link, frame.clone()))),
                Ok(None) => break,
                Err(error) => {
                    self.error = Some(error);
                    break;
                }
            }
        }
        // Handed out from the end.
        self.due.reverse();
    }

    fn poll_transmit(&mut self) -> Option<(LinkId, Vec<u8>)> {
        self.due.pop()
    }
}
