//! From telemetry to command: how long the real `helmlink bridge` takes over loopback UDP, next to a bare echo, and
//! what it costs.
//!
//! ```console
//! cargo bench --bench latency
//! cargo bench --bench latency -- --seconds 60
//! cargo bench --bench latency -- --soak            # an hour of simulated and ten minutes of real time
//! ```
//!
//! A made-up flight controller sends 1,000 messages a second, one a datagram, among them ATTITUDE and
//! GLOBAL_POSITION_INT 50 times. The time runs from handing a GLOBAL_POSITION_INT to the system to taking the
//! SET_ATTITUDE_TARGET that answers it. The echo is a thread that returns those same datagrams and reads the rest, one
//! system call a datagram: what it costs is what being woken costs on this machine.

// Printing is what it is for.
#![allow(clippy::print_stdout)]

mod boat;
mod process;
mod soak;
mod timing;

use std::error::Error;
use std::net::{Ipv4Addr, UdpSocket};
use std::path::PathBuf;
use std::time::Duration;

use boat::Boat;
use process::{Bridge, Cost};
use timing::Latencies;

/// Messages a second.
const RATE: u32 = 1000;
/// Time between two GLOBAL_POSITION_INT.
const POSITION_INTERVAL: Duration = Duration::from_millis(20);

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).filter(|argument| argument != "--bench").collect();
    if arguments.iter().any(|argument| argument == "--soak") {
        return soak::run();
    }
    let seconds = match arguments.iter().position(|argument| argument == "--seconds") {
        Some(at) => arguments.get(at + 1).ok_or("--seconds needs a number")?.parse()?,
        None => 10,
    };
    measure(Duration::from_secs(seconds))
}

fn measure(span: Duration) -> Result<(), Box<dyn Error>> {
    let before = echo(span / 2)?;
    let mut boat = Boat::new()?;
    let bridge = Bridge::start(boat.port()?, &mission()?)?;
    boat.wait_until_steered()?;
    // The first seconds of a process are not its usual ones.
    boat.run(Duration::from_secs(2))?;
    let cost_before = bridge.cost()?;
    let times = boat.run(span)?;
    let answered = Run { times, cost: bridge.cost()?.since(cost_before), messages: messages(span) };
    let resident_kib = bridge.resident_kib()?;
    drop(bridge);
    let echoed = before.and(echo(span / 2)?);

    println!(
        "{:<8}{:>10}{:>10}{:>10}{:>10}{:>12}{:>16}{:>15}",
        "", "p50 us", "p99 us", "max us", "answers", "jitter ms", "CPU ms/1,000", "waits/message"
    );
    echoed.print("echo");
    answered.print("bridge");
    let by = |figure: fn(&Run) -> f64| figure(&answered) / figure(&echoed);
    println!("p99, bridge by echo   {:.2}", by(|run| run.times.p99_us()));
    println!("CPU, bridge by echo   {:.2}", by(Run::cpu_ms_per_thousand));
    println!("resident memory       {:.1} MB", resident_kib as f64 / 1024.0);
    Ok(())
}

/// What one side has made of the traffic.
struct Run {
    times: Latencies,
    cost: Cost,
    messages: f64,
}

impl Run {
    fn and(self, other: Self) -> Self {
        Self {
            times: self.times.and(other.times),
            cost: self.cost.and(other.cost),
            messages: self.messages + other.messages,
        }
    }

    fn cpu_ms_per_thousand(&self) -> f64 {
        self.cost.cpu.as_secs_f64() * 1e6 / self.messages
    }

    fn print(&self, name: &str) {
        println!(
            "{name:<8}{}{:>12.2}{:>16.1}{:>15.2}",
            self.times,
            self.times.jitter_ms(POSITION_INTERVAL),
            self.cpu_ms_per_thousand(),
            self.cost.waits as f64 / self.messages
        );
    }
}

/// How many are sent in this time.
fn messages(span: Duration) -> f64 {
    span.as_secs_f64() * f64::from(RATE)
}

/// The same traffic against a thread that sends back what the bridge would answer.
fn echo(span: Duration) -> Result<Run, Box<dyn Error>> {
    let mut boat = Boat::new()?;
    let port = boat.port()?;
    let socket = UdpSocket::bind((Ipv4Addr::LOCALHOST, 0))?;
    socket.connect((Ipv4Addr::LOCALHOST, port))?;
    socket.send(b"here")?;
    let (say_cost, costs) = std::sync::mpsc::channel();
    let echo = std::thread::spawn(move || {
        let mut buffer = [0; 512];
        let mark = || {
            // What cannot be read is missed by the other side.
            Cost::of_this_thread().ok().map(|cost| say_cost.send(cost))
        };
        while let Ok(count) = socket.recv(&mut buffer) {
            match &buffer[..count] {
                boat::GOODBYE => break,
                boat::HOW_MUCH => _ = mark(),
                datagram if boat::is_position(datagram) => _ = socket.send(datagram),
                _ => {}
            }
        }
    });
    boat.run(Duration::from_millis(500))?;
    boat.say(boat::HOW_MUCH)?;
    let before = costs.recv()?;
    let times = boat.run(span)?;
    boat.say(boat::HOW_MUCH)?;
    let cost = costs.recv()?.since(before);
    boat.say(boat::GOODBYE)?;
    echo.join().map_err(|_| "the echo has failed")?;
    Ok(Run { times, cost, messages: messages(span) })
}

/// A mission far longer than any run.
fn mission() -> Result<PathBuf, Box<dyn Error>> {
    let path = std::env::temp_dir().join(format!("helmlink-latency-{}.waypoints", std::process::id()));
    let mut text = "QGC WPL 110\n0\t1\t0\t16\t0\t0\t0\t0\t63.4389\t10.399\t0\t1\n".to_owned();
    for (number, (latitude, longitude)) in
        [(63.4390, 10.399), (63.6, 10.399), (63.6, 10.8)].iter().enumerate()
    {
        text += &format!("{}\t0\t3\t16\t0\t0\t0\t0\t{latitude}\t{longitude}\t0\t1\n", number + 1);
    }
    std::fs::write(&path, text)?;
    Ok(path)
}
