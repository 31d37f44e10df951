//! The bridge in figures.

use super::Live;
use super::lateness::{Lateness, Quantiles};
use super::process::Usage;
use crate::app::metrics::Page;
use crate::bridge::Bridge;
use crate::link::Traffic;
use crate::pilot::supervisor::State;

/// Everything as it is now.
pub(super) fn page(edge: &Live, lateness: &Lateness) -> String {
    let mut page = Page::default();
    state(&mut page, &edge.party);
    course(&mut page, &edge.party);
    loop_times(&mut page, &edge.party, lateness);
    links(&mut page, edge);
    gate(&mut page, edge);
    process(&mut page);
    page.into_text()
}

fn state(page: &mut Page, bridge: &Bridge) {
    let status = bridge.status();
    page.gauge("helmlink_info", "The version that runs.")
        .with(&[("version", env!("CARGO_PKG_VERSION"))], 1.0);
    page.gauge("helmlink_state", "1 for the state that the bridge is in.")
        .with(&[("state", status.state.name())], 1.0);
    page.gauge("helmlink_vehicle_found", "1 if a flight controller is there.")
        .value(flag(status.vehicle.is_some()));
    page.gauge("helmlink_armed", "1 if the motors may turn.").value(flag(status.armed));
    let is_engaged = matches!(status.state, State::Engaging | State::Engaged | State::HandingBack);
    page.gauge("helmlink_engaged", "1 while the boat is the bridge's.").value(flag(is_engaged));
    let mut failsafes = page.counter(
        "helmlink_failsafe_total",
        "Times that a failsafe has taken the boat out of control or warned.",
    );
    for (key, count) in bridge.counts().failsafes() {
        failsafes.with(&[("failsafe", key)], count as f64);
    }
    page.counter("helmlink_controller_errors_total", "Control steps that gave no command.")
        .value(bridge.counts().controller_errors as f64);
    if let Some(mode) = status.mode {
        page.gauge("helmlink_mode", "The flight controller's mode (custom_mode).").value(f64::from(mode.0));
    }
}

fn course(page: &mut Page, bridge: &Bridge) {
    let status = bridge.status();
    let Some(progress) = status.progress else { return };
    let mut gauge = |name, help, value| page.gauge(name, help).value(value);
    gauge("helmlink_cross_track_m", "Distance to the right of the path.", progress.cross_track_m);
    gauge("helmlink_to_go_m", "Distance still to go.", progress.to_go_m);
    gauge("helmlink_speed_mps", "Speed over ground.", progress.speed_mps);
    gauge("helmlink_wanted_speed_mps", "Speed that the mission wants.", progress.wanted_speed_mps);
    gauge("helmlink_next_waypoint", "Waypoint under way to, counted from 1.", progress.next as f64 + 1.0);
    gauge("helmlink_waypoints", "Waypoints of the mission.", progress.total as f64);
    gauge("helmlink_throttle", "Throttle commanded, -1 to 1.", status.demand.throttle);
    gauge("helmlink_steering", "Steering commanded, -1 to 1.", status.demand.steering);
    let diagnostics = &status.diagnostics;
    let mut saturated = page.gauge("helmlink_saturated", "1 if a limit cuts the command off.");
    saturated.with(&[("axis", "surge")], flag(diagnostics.surge_saturated));
    saturated.with(&[("axis", "yaw")], flag(diagnostics.yaw_saturated));
}

fn loop_times(page: &mut Page, bridge: &Bridge, lateness: &Lateness) {
    let status = bridge.status();
    page.counter("helmlink_control_steps_total", "Steps of the control loop.").value(status.steps as f64);
    let (_, commands) = bridge.commands_digest();
    page.counter("helmlink_commands_total", "Steering frames sent.").value(commands as f64);
    page.gauge("helmlink_command_rate_hz", "Steering frames a second.").value(status.pace.rate_hz());
    let mut delays = page.gauge(
        "helmlink_loop_delay_seconds",
        "Delay of the control loop: of the messages there and back, as the boat's answer to its steering shows it, \
         and as the controller predicts across.",
    );
    if let Some(round_trip_s) = status.round_trip_s {
        delays.with(&[("of", "messages")], round_trip_s);
    }
    if let Some(answer) = status.answer_delay {
        delays.with(&[("of", "answer")], answer.delay_s);
        delays.with(&[("of", "answer_deviation")], answer.deviation_s);
    }
    delays.with(&[("of", "prediction")], status.delay_s);
    if let Some(compass) = status.compass {
        let mut error = page.gauge(
            "helmlink_compass_error_radians",
            "What the heading is too large by, and how well that is known. It is not used for steering.",
        );
        error.with(&[("of", "offset")], compass.offset_rad);
        error.with(&[("of", "deviation")], compass.deviation_rad);
    }
    let mut quantiles = |name, help, times: Option<Quantiles>| {
        let Some(times) = times else { return };
        let mut family = page.gauge(name, help);
        family.with(&[("quantile", "0.5")], times.p50_s);
        family.with(&[("quantile", "0.99")], times.p99_s);
        family.with(&[("quantile", "1")], times.max_s);
    };
    quantiles(
        "helmlink_loop_lateness_seconds",
        "By how much the latest 1000 intervals between control steps missed the usual one.",
        lateness.jitter(),
    );
    quantiles(
        "helmlink_loop_handling_seconds",
        "From taking telemetry to handing over the command, latest 1000 control steps.",
        lateness.handling(),
    );
}

fn links(page: &mut Page, edge: &Live) {
    let links: Vec<_> =
        edge.traffic().into_iter().map(|(link, traffic)| (link.0.to_string(), link, traffic)).collect();
    let mut each = |name, help, value: fn(&Traffic) -> u64| {
        let mut family = page.counter(name, help);
        for (label, _, traffic) in &links {
            family.with(&[("link", label)], value(traffic) as f64);
        }
    };
    each("helmlink_link_received_bytes_total", "Bytes received.", |traffic| traffic.received_bytes);
    each("helmlink_link_sent_bytes_total", "Bytes sent.", |traffic| traffic.sent_bytes);
    each("helmlink_link_lost_writes_total", "Writes given up.", |traffic| traffic.lost_writes);
    let mut each = |name, help, value: fn(&helmlink_wire::LinkStatistics) -> u64| {
        let mut family = page.counter(name, help);
        for (label, link, _) in &links {
            if let Some(statistics) = edge.party.gate.statistics(*link) {
                family.with(&[("link", label)], value(statistics) as f64);
            }
        }
    };
    each("helmlink_link_frames_total", "Frames received.", |link| link.frames);
    each("helmlink_link_missing_frames_total", "Frames that never arrived.", |link| link.sequence_gaps);
    each("helmlink_link_crc_errors_total", "Frames with a wrong checksum.", |link| link.crc_errors);
    each("helmlink_link_unknown_frames_total", "Frames of unknown messages.", |link| link.unknown_ids);
}

fn gate(page: &mut Page, edge: &Live) {
    let refused = edge.party.gate.refused();
    let mut family = page.counter("helmlink_refused_frames_total", "Frames not let in or out, by reason.");
    family.with(&[("reason", "signature")], refused.signature as f64);
    family.with(&[("reason", "order")], refused.orders as f64);
    family.with(&[("reason", "secret")], refused.secrets as f64);
    if let Some(signing) = edge.party.gate.signing_statistics() {
        let mut family =
            page.counter("helmlink_signed_frames_total", "Signed frames sent, and received and accepted.");
        family.with(&[("direction", "sent")], signing.signed_sent as f64);
        family.with(&[("direction", "received")], signing.accepted as f64);
    }
}

/// The process itself, under the names that Prometheus has for that.
fn process(page: &mut Page) {
    let Some(usage) = Usage::now() else { return };
    page.counter("process_cpu_seconds_total", "Processor time, user and system.").value(usage.cpu_s);
    page.gauge("process_resident_memory_bytes", "Resident memory.").value(usage.resident_bytes);
}

fn flag(condition: bool) -> f64 {
    f64::from(u8::from(condition))
}
