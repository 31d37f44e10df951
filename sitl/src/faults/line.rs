//! Bad lines: frames that are lost, late, doubled, out of order or damaged.

use std::collections::BTreeMap;
use std::time::Duration;

use helmlink_wire::LinkId;
use helmlink_wire::framer::Framer;

use crate::physics::random::{Source, Stream};

/// Frames that may wait on one line in one direction; what exceeds it is lost.
const MAX_WAITING: usize = 20_000;
/// How much later than its turn a reordered frame arrives, s: from, to. Several frames pass it meanwhile.
const REORDERED_BY_S: (f64, f64) = (0.04, 0.2);

/// What the lines do to frames, in both directions.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct LinkWeather {
    /// Share of the frames that are lost.
    pub(crate) loss: f64,
    pub(crate) delay_s: f64,
    pub(crate) jitter_s: f64,
    /// Share of the frames that arrive twice.
    pub(crate) duplication: f64,
    /// Share of the frames that arrive after later ones.
    pub(crate) reordering: f64,
    /// Share of the frames with a wrong byte.
    pub(crate) corruption: f64,
    /// The one link that is concerned; `None` for all.
    pub(crate) only: Option<LinkId>,
}

impl LinkWeather {
    /// Whether a link is as good as it can be.
    pub(crate) fn is_fair(&self, link: LinkId) -> bool {
        let touched = self.only.is_none_or(|only| only == link);
        !touched || Self { only: None, ..*self } == Self::default()
    }
}

/// The lines of all links.
#[derive(Debug, Default)]
pub(crate) struct Lines {
    seed: u64,
    links: BTreeMap<LinkId, Link>,
}

/// Both directions of one link.
#[derive(Debug)]
struct Link {
    framer: Framer,
    stream: Stream,
    inward: Line,
    outward: Line,
}

/// Frames under way in one direction, by the time at which they arrive and then by the order in which they
/// were sent.
#[derive(Debug, Default)]
struct Line {
    waiting: BTreeMap<(Duration, u64), Vec<u8>>,
    sent: u64,
}

impl Lines {
    pub(crate) fn new(seed: u64) -> Self {
        Self { seed, links: BTreeMap::new() }
    }

    /// Whether frames of this link go by here: the weather is bad, or some are still under way.
    pub(crate) fn carries(&self, link: LinkId, weather: &LinkWeather) -> bool {
        !weather.is_fair(link) || self.links.get(&link).is_some_and(Link::is_busy)
    }

    /// Forgets a link.
    pub(crate) fn forget(&mut self, link: LinkId) {
        self.links.remove(&link);
    }

    /// Takes bytes from a client. Bytes that are no frame never arrive.
    pub(crate) fn take_in(&mut self, link: LinkId, bytes: &[u8], now: Duration, weather: &LinkWeather) {
        let seed = self.seed;
        let Link { framer, stream, inward, .. } =
            self.links.entry(link).or_insert_with(|| Link::new(seed, link));
        framer.push(bytes);
        while let Some(frame) = framer.next_any() {
            inward.send(frame.bytes(), now, weather, stream);
        }
    }

    /// Takes whole frames from the boat; they are found as in a datagram.
    pub(crate) fn take_out(&mut self, link: LinkId, bytes: &[u8], now: Duration, weather: &LinkWeather) {
        let seed = self.seed;
        let Link { stream, outward, .. } = self.links.entry(link).or_insert_with(|| Link::new(seed, link));
        let mut framer = Framer::new();
        framer.push(bytes);
        framer.end_of_datagram();
        while let Some(frame) = framer.next_any() {
            outward.send(frame.bytes(), now, weather, stream);
        }
    }

    /// What arrives at the boat now.
    pub(crate) fn arriving(&mut self, now: Duration) -> Vec<(LinkId, Vec<u8>)> {
        self.drain(now, |link| &mut link.inward)
    }

    /// What arrives at the clients now.
    pub(crate) fn leaving(&mut self, now: Duration) -> Vec<(LinkId, Vec<u8>)> {
        self.drain(now, |link| &mut link.outward)
    }

    fn drain(&mut self, now: Duration, line: fn(&mut Link) -> &mut Line) -> Vec<(LinkId, Vec<u8>)> {
        let mut all = Vec::new();
        for (&id, link) in &mut self.links {
            let later = line(link).waiting.split_off(&(now + Duration::from_nanos(1), 0));
            let due = std::mem::replace(&mut line(link).waiting, later);
            all.extend(due.into_values().map(|frame| (id, frame)));
        }
        all
    }
}

impl Link {
    fn new(seed: u64, link: LinkId) -> Self {
        Self {
            framer: Framer::new(),
            stream: Stream::numbered(seed, Source::Link, link.0),
            inward: Line::default(),
            outward: Line::default(),
        }
    }

    fn is_busy(&self) -> bool {
        !self.inward.waiting.is_empty() || !self.outward.waiting.is_empty()
    }
}

impl Line {
    fn send(&mut self, frame: &[u8], now: Duration, weather: &LinkWeather, stream: &mut Stream) {
        if stream.uniform() < weather.loss {
            return;
        }
        let copies = if stream.uniform() < weather.duplication { 2 } else { 1 };
        for _ in 0..copies {
            let mut late_s = weather.delay_s + weather.jitter_s * stream.uniform();
            if stream.uniform() < weather.reordering {
                let (least, most) = REORDERED_BY_S;
                late_s += least + (most - least) * stream.uniform();
            }
            let mut bytes = frame.to_vec();
            if stream.uniform() < weather.corruption {
                damage(&mut bytes, stream);
            }
            self.sent += 1;
            if self.waiting.len() < MAX_WAITING {
                let arrives = now + Duration::try_from_secs_f64(late_s).unwrap_or_default();
                self.waiting.insert((arrives, self.sent), bytes);
            }
        }
    }
}

/// Changes one byte.
fn damage(bytes: &mut [u8], stream: &mut Stream) {
    let place = (stream.uniform() * bytes.len() as f64) as usize;
    let change = 1 + (stream.uniform() * 255.0) as u8 % 255;
    if let Some(byte) = bytes.get_mut(place) {
        *byte ^= change;
    }
}

#[cfg(test)]
mod tests {
    use helmlink_wire::dialect::{Message, PING_DATA};
    use helmlink_wire::{Encoder, Identity};

    use super::*;

    const LINK: LinkId = LinkId(1);
    const FRAMES: u32 = 2000;

    /// The numbers of the pings that come through, one sent every 10 ms; damaged ones are left out.
    fn through(weather: LinkWeather) -> Vec<(u32, Duration)> {
        let mut lines = Lines::new(7);
        let mut encoder = Encoder::new();
        let mut framer = Framer::new();
        let mut arrived = Vec::new();
        for number in 0..FRAMES + 200 {
            let now = Duration::from_millis(10) * number;
            if number < FRAMES {
                let mut bytes = Vec::new();
                let ping = Message::PING(PING_DATA { seq: number, ..PING_DATA::DEFAULT });
                encoder.encode(Identity { system: 1, component: 1 }, &ping, &mut bytes);
                lines.take_out(LINK, &bytes, now, &weather);
            }
            for (link, bytes) in lines.leaving(now) {
                assert_eq!(link, LINK);
                framer.push(&bytes);
                while let Some(frame) = framer.next_frame() {
                    let Message::PING(ping) = frame.decode().unwrap() else { panic!() };
                    arrived.push((ping.seq, now - Duration::from_millis(10) * ping.seq));
                }
            }
        }
        arrived
    }

    #[test]
    fn each_kind_of_weather_does_what_it_says() {
        let share = |count: usize| count as f64 / f64::from(FRAMES);
        let lost = through(LinkWeather { loss: 0.3, ..LinkWeather::default() });
        assert!((share(lost.len()) - 0.7).abs() < 0.04, "{}", lost.len());
        assert!(lost.is_sorted());

        let late = through(LinkWeather { delay_s: 0.2, jitter_s: 0.1, ..LinkWeather::default() });
        assert_eq!(late.len() as u32, FRAMES);
        let (least, most) = (late.iter().map(|each| each.1).min(), late.iter().map(|each| each.1).max());
        assert!(least >= Some(Duration::from_millis(200)) && most <= Some(Duration::from_millis(310)));

        let doubled = through(LinkWeather { duplication: 0.2, ..LinkWeather::default() });
        assert!((share(doubled.len()) - 1.2).abs() < 0.04, "{}", doubled.len());

        let shuffled = through(LinkWeather { reordering: 0.1, ..LinkWeather::default() });
        assert_eq!(shuffled.len() as u32, FRAMES);
        assert!(!shuffled.is_sorted_by_key(|each| each.0));

        let damaged = through(LinkWeather { corruption: 0.25, ..LinkWeather::default() });
        assert!((share(damaged.len()) - 0.75).abs() < 0.05, "{}", damaged.len());

        assert!(through(LinkWeather { loss: 1.0, ..LinkWeather::default() }).is_empty());
    }

    #[test]
    fn the_same_seed_gives_the_same_weather() {
        let weather = LinkWeather { loss: 0.2, jitter_s: 0.3, duplication: 0.1, ..LinkWeather::default() };
        assert_eq!(through(weather), through(weather));
    }

    #[test]
    fn weather_may_concern_one_link_alone() {
        let weather = LinkWeather { loss: 1.0, only: Some(LINK), ..LinkWeather::default() };
        assert!(!weather.is_fair(LINK) && weather.is_fair(LinkId(2)));
        assert!(LinkWeather { only: Some(LINK), ..LinkWeather::default() }.is_fair(LINK));
    }
}
