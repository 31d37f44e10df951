//! Whether memory grows: an hour of simulated time, then ten minutes of real time at the full message rate.

use std::error::Error;
use std::net::{Ipv4Addr, UdpSocket};
use std::time::{Duration, Instant};

use crate::boat::Boat;
use crate::process::Bridge;

/// How many times faster than real time the simulated boat runs.
const SPEEDUP: u32 = 20;
const SIMULATED: Duration = Duration::from_secs(3600);
const REAL: Duration = Duration::from_secs(600);
/// Measurements in each part.
const LOOKS: u32 = 10;

pub(crate) fn run() -> Result<(), Box<dyn Error>> {
    let mission = crate::mission()?;
    println!("an hour of simulated time, {SPEEDUP} times real time");
    simulated(&mission.display().to_string())?;
    println!("ten minutes of real time, {} messages a second", crate::RATE);
    let mut boat = Boat::new()?;
    let bridge = Bridge::start(boat.port()?, &mission)?;
    boat.wait_until_steered()?;
    let mut watch = Watch::new(&bridge);
    for _ in 0..LOOKS {
        boat.run(REAL / LOOKS)?;
        watch.look()?;
    }
    watch.judge();
    Ok(())
}

fn simulated(mission: &str) -> Result<(), Box<dyn Error>> {
    // A port that was free a moment ago: the bridge tries again until the boat listens there.
    let port = UdpSocket::bind((Ipv4Addr::LOCALHOST, 0))?.local_addr()?.port();
    let (listen, connect) = (format!("tcpin:127.0.0.1:{port}"), format!("tcp:127.0.0.1:{port}"));
    let _boat = Bridge::run(&[
        "sitl",
        "-q",
        "--listen",
        &listen,
        "--speedup",
        &SPEEDUP.to_string(),
        "--mission",
        mission,
        "--sea",
        "slight",
    ])?;
    let bridge = Bridge::run(&["bridge", "-q", "--connect", &connect, "--engage", "--arm", "--wait", "60"])?;
    std::thread::sleep(Duration::from_secs(10));
    let mut watch = Watch::new(&bridge);
    for _ in 0..LOOKS {
        std::thread::sleep(SIMULATED / SPEEDUP / LOOKS);
        watch.look()?;
    }
    watch.judge();
    Ok(())
}

struct Watch<'a> {
    bridge: &'a Bridge,
    start: Instant,
    resident_kib: Vec<u64>,
}

impl<'a> Watch<'a> {
    fn new(bridge: &'a Bridge) -> Self {
        Self { bridge, start: Instant::now(), resident_kib: Vec::new() }
    }

    fn look(&mut self) -> Result<(), Box<dyn Error>> {
        let (cpu, kib) = (self.bridge.cost()?.cpu, self.bridge.resident_kib()?);
        println!(
            "{:>6.0} s   resident {kib} KiB   CPU {:.1} s",
            self.start.elapsed().as_secs_f64(),
            cpu.as_secs_f64()
        );
        self.resident_kib.push(kib);
        Ok(())
    }

    /// The first look already counts as warmed up.
    fn judge(&self) {
        if let (Some(first), Some(last)) = (self.resident_kib.first(), self.resident_kib.last()) {
            println!("growth from the first look to the last: {} KiB", *last as i64 - *first as i64);
        }
    }
}
