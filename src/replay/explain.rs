//! What is unusual about a log, in plain words.

use helmlink_wire::Identity;

use super::scan::{Scan, VehicleSummary};

/// Bytes at the end of a log that are no more than a cut record.
const CUT_BYTES: u64 = 300;

/// One line for everything about a log that its reader should know.
pub fn explain(scan: &Scan, vehicle: Identity) -> Vec<String> {
    let mut lines = Vec::new();
    let statistics = &scan.statistics;
    if let Some(summary) = scan.vehicles.get(&vehicle) {
        explain_clock(summary, &mut lines);
    }
    if scan.disordered > 0 {
        lines.push(format!(
            "{} records are stamped earlier than the one before, by up to {:.3} s: they are put in order",
            scan.disordered,
            scan.farthest_us as f64 / 1e6
        ));
    }
    if statistics.crc_errors > 0 || statistics.resynchronised_bytes > CUT_BYTES {
        lines.push(format!(
            "the log is damaged: {} frames with a wrong checksum, {} of {} bytes passed over; every whole frame is used",
            statistics.crc_errors, statistics.resynchronised_bytes, statistics.bytes
        ));
    } else if statistics.resynchronised_bytes > 0 {
        lines.push(format!(
            "the log is cut: {} bytes belong to no whole record",
            statistics.resynchronised_bytes
        ));
    }
    if statistics.unknown_ids > 0 {
        lines.push(format!(
            "{} frames hold messages that helmlink does not know; they are left out",
            statistics.unknown_ids
        ));
    }
    let others: Vec<String> = scan
        .vehicles
        .keys()
        .filter(|identity| **identity != vehicle)
        .map(|identity| identity.system.to_string())
        .collect();
    if !others.is_empty() {
        lines.push(format!(
            "system {} is followed; the log also holds vehicle {} (--system chooses)",
            vehicle.system,
            others.join(", ")
        ));
    }
    if let Some(fault) = &scan.header_fault {
        lines.push(format!("the settings in this recording cannot be used: {}", fault.trim()));
    }
    lines
}

fn explain_clock(summary: &VehicleSummary, lines: &mut Vec<String>) {
    let rate = summary.rate();
    if rate != 1.0 {
        lines.push(format!(
            "recorded at {rate:.2} × real time ({:.1} s of the vehicle in {:.1} s by the stamps): the vehicle's time is used",
            summary.vehicle_s, summary.stamped_s
        ));
    }
    if summary.restarts > 0 {
        lines.push(format!(
            "the flight controller restarted {} times; its times are joined",
            summary.restarts
        ));
    }
}
