//! `helmlink sitl --ardupilot-json`: the physics behind a real ArduPilot.

use std::net::SocketAddr;

use helmlink_mission::geodesy::Geodetic;
use helmlink_sitl::ardupilot::{ArduPilotPhysics, PacketKind};
use tokio::net::UdpSocket;

use super::console;
use super::failure::Failure;
use super::interrupt::interrupted;
use super::scenario;
use super::world::World;

/// Longer than any packet of the protocol.
const LONGEST_DATAGRAM: usize = 2048;

/// The boat in its world.
pub(super) fn physics(world: &World) -> ArduPilotPhysics {
    ArduPilotPhysics::new(world.hull.clone(), &world.sea, world.seed, heading_deg(world).to_radians())
}

/// Answers servo packets with the boat's motion until interrupted, or until the scenario is over.
///
/// # Errors
/// The address cannot be bound; an expectation of the scenario has not come true.
pub(super) async fn serve(
    address: SocketAddr,
    mut physics: ArduPilotPhysics,
    world: &World,
    home: Geodetic,
    json: bool,
) -> Result<(), Failure> {
    let socket = UdpSocket::bind(address).await.map_err(|error| {
        Failure::usage(format!("--ardupilot-json {address}: {error}; choose another address or port"))
    })?;
    let bound = socket.local_addr().map_err(Failure::failed)?;
    tracing::info!(
        "physics of the {} at {bound}: start ArduPilot with --model JSON:{} and --home {:.7},{:.7},0,{:.0}",
        world.hull.name,
        bound.ip(),
        home.latitude_deg,
        home.longitude_deg,
        heading_deg(world)
    );
    if json {
        console::say(&serde_json::json!({ "ardupilot_json": bound.to_string() }).to_string());
    }
    let mut interrupt = std::pin::pin!(interrupted());
    let mut datagram = [0; LONGEST_DATAGRAM];
    while !physics.is_scenario_over() {
        let received = tokio::select! {
            () = &mut interrupt => break,
            received = socket.recv_from(&mut datagram) => received,
        };
        // An ArduPilot that is gone shows as an error of the next read; the next one will come.
        let Ok((length, from)) = received else { continue };
        match physics.on_packet(&datagram[..length]) {
            Ok((kind, answer)) => {
                match kind {
                    PacketKind::Reset => {
                        tracing::info!("ArduPilot at {from} has started: the boat is at its start")
                    }
                    PacketKind::AfterLoss(frames) => tracing::debug!("{frames} packets of {from} were lost"),
                    PacketKind::Next | PacketKind::Repeated => {}
                }
                if let Err(error) = socket.send_to(answer.as_bytes(), from).await {
                    tracing::debug!("cannot answer {from}: {error}");
                }
            }
            Err(fault) => tracing::warn!("from {from}: {fault}"),
        }
    }
    physics.end_scenario();
    let verdicts = physics.verdicts();
    if json && !verdicts.is_empty() {
        console::say(&serde_json::json!({ "expectations": scenario::json(verdicts) }).to_string());
    } else if !verdicts.is_empty() {
        console::say(&scenario::text(verdicts));
    }
    scenario::check(verdicts)
}

fn heading_deg(world: &World) -> f64 {
    world.home.and_then(|(_, heading)| heading).unwrap_or(0.0).to_degrees()
}
