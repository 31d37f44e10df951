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
//! SET_ATTITUDE_TARGET that answers it. The echo is a thread that returns those same datagrams and reads the rest.

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
use process::Bridge;
use timing::Latencies;

/// Messages a second.
const RATE: u32 = 1000;

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
    let (cpu_before, _) = bridge.usage()?;
    let answered = boat.run(span)?;
    let (cpu_after, resident_kib) = bridge.usage()?;
    drop(bridge);
    let after = echo(span / 2)?;

    let echoed = before.and(after);
    println!("{:<8}{:>10}{:>10}{:>10}{:>10}", "", "p50 us", "p99 us", "max us", "answers");
    println!("{:<8}{echoed}", "echo");
    println!("{:<8}{answered}", "bridge");
    println!("p99 of the bridge / p99 of the echo   {:.2}", answered.p99_us() / echoed.p99_us());
    let per_thousand = (cpu_after - cpu_before).as_secs_f64() * 1e3 / span.as_secs_f64();
    println!("CPU per 1,000 messages                {per_thousand:.1} ms");
    println!("resident memory                       {:.1} MB", f64::from(resident_kib) / 1024.0);
    Ok(())
}

/// The same traffic against a thread that sends back what the bridge would answer.
fn echo(span: Duration) -> Result<Latencies, Box<dyn Error>> {
    let mut boat = Boat::new()?;
    let port = boat.port()?;
    let socket = UdpSocket::bind((Ipv4Addr::LOCALHOST, 0))?;
    socket.connect((Ipv4Addr::LOCALHOST, port))?;
    socket.send(b"here")?;
    let echo = std::thread::spawn(move || {
        let mut buffer = [0; 512];
        while let Ok(count) = socket.recv(&mut buffer) {
            match &buffer[..count] {
                [] => break,
                datagram if boat::is_position(datagram) => _ = socket.send(datagram),
                _ => {}
            }
        }
    });
    boat.run(Duration::from_millis(500))?;
    let latencies = boat.run(span)?;
    boat.say_goodbye()?;
    echo.join().map_err(|_| "the echo has failed")?;
    Ok(latencies)
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
