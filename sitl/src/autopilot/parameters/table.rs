//! The parameter table: names, types, defaults and ranges after ArduRover 4.6.
//!
//! Tuning defaults (`CRUISE_...`, `ATC_...`, `WP_...`) are those of no boat in particular; the simulator
//! replaces them with values found for its hull.

use super::{Definition, Kind, Param};

/// Channels and outputs that have parameters.
pub(in crate::autopilot) const CHANNELS: usize = 8;

macro_rules! parameters {
    ($($name:ident: $kind:ident = $default:literal in $least:literal .. $most:literal $(, $access:ident)?;)*) => {
        #[allow(non_camel_case_types, clippy::upper_case_acronyms)]
        enum Row { $($name),* }

        $(pub(in crate::autopilot) const $name: Param = Param(Row::$name as usize);)*

        /// The rows that belong to no channel.
        fn single() -> Vec<Definition> {
            vec![$(Definition {
                name: stringify!($name).to_owned(),
                kind: Kind::$kind,
                default: $default as f32,
                range: ($least as f32, $most as f32),
                read_only: parameters!(@access $($access)?),
            }),*]
        }

        const SINGLE_ROWS: usize = [$(Row::$name as usize),*].len();
    };
    (@access read_only) => { true };
    (@access) => { false };
}

#[allow(dead_code)] // rows that ground stations expect to see but that this autopilot has no use for
mod rows {
    use super::{Definition, Kind, Param};

    parameters! {
        // Identity and links.
        FORMAT_VERSION: Int16 = 16 in 0 .. 32767, read_only;
        SYSID_THISMAV: Int16 = 1 in 1 .. 255;
        SYSID_MYGCS: Int16 = 255 in 1 .. 255;
        SYSID_ENFORCE: Int8 = 0 in 0 .. 1;
        TELEM_DELAY: Int8 = 0 in 0 .. 30;
        SERIAL0_PROTOCOL: Int8 = 2 in -1 .. 50;
        SERIAL0_BAUD: Int32 = 115 in 1 .. 2000000;
        SR0_RAW_SENS: Int16 = 1 in 0 .. 50;
        SR0_EXT_STAT: Int16 = 1 in 0 .. 50;
        SR0_RC_CHAN: Int16 = 1 in 0 .. 50;
        SR0_RAW_CTRL: Int16 = 1 in 0 .. 50;
        SR0_POSITION: Int16 = 1 in 0 .. 50;
        SR0_EXTRA1: Int16 = 1 in 0 .. 50;
        SR0_EXTRA2: Int16 = 1 in 0 .. 50;
        SR0_EXTRA3: Int16 = 1 in 0 .. 50;
        SR0_PARAMS: Int16 = 10 in 0 .. 50;
        SCHED_LOOP_RATE: Int16 = 50 in 50 .. 50, read_only;
        STAT_RUNTIME: Int32 = 0 in 0 .. 2147483000, read_only;
        STAT_BOOTCNT: Int16 = 1 in 0 .. 32767, read_only;

        // Frame, modes and arming.
        FRAME_CLASS: Int8 = 2 in 0 .. 3;
        FRAME_TYPE: Int8 = 0 in 0 .. 5;
        INITIAL_MODE: Int8 = 0 in 0 .. 16;
        MODE_CH: Int8 = 8 in 0 .. 16;
        MODE1: Int8 = 0 in 0 .. 16;
        MODE2: Int8 = 0 in 0 .. 16;
        MODE3: Int8 = 0 in 0 .. 16;
        MODE4: Int8 = 0 in 0 .. 16;
        MODE5: Int8 = 0 in 0 .. 16;
        MODE6: Int8 = 0 in 0 .. 16;
        ARMING_CHECK: Int32 = 1 in 0 .. 1048575;
        ARMING_REQUIRE: Int8 = 1 in 0 .. 2;

        // Radio control and failsafes.
        RCMAP_ROLL: Int8 = 1 in 1 .. 8;
        RCMAP_THROTTLE: Int8 = 3 in 1 .. 8;
        RC_OVERRIDE_TIME: Real32 = 3 in -1 .. 120;
        RC_OPTIONS: Int32 = 32 in 0 .. 65535;
        SIM_RC_FAIL: Int8 = 0 in 0 .. 2;
        FS_ACTION: Int8 = 2 in 0 .. 6;
        FS_TIMEOUT: Real32 = 1.5 in 1 .. 100;
        FS_THR_ENABLE: Int8 = 1 in 0 .. 2;
        FS_THR_VALUE: Int16 = 910 in 800 .. 1100;
        FS_GCS_ENABLE: Int8 = 0 in 0 .. 2;
        FS_GCS_TIMEOUT: Real32 = 5 in 2 .. 120;
        FS_OPTIONS: Int32 = 0 in 0 .. 3;
        FS_CRASH_CHECK: Int8 = 0 in 0 .. 2;
        FS_EKF_ACTION: Int8 = 1 in 0 .. 3;
        FS_EKF_THRESH: Real32 = 0.8 in 0 .. 1;

        // Speed and steering control.
        CRUISE_SPEED: Real32 = 2 in 0.05 .. 100;
        CRUISE_THROTTLE: Int8 = 50 in 1 .. 100;
        TURN_RADIUS: Real32 = 0.9 in 0 .. 1000;
        ACRO_TURN_RATE: Real32 = 180 in 0 .. 360;
        ATC_STR_RAT_FF: Real32 = 0.2 in 0 .. 1000;
        ATC_STR_RAT_P: Real32 = 0.2 in 0 .. 1000;
        ATC_STR_RAT_I: Real32 = 0.2 in 0 .. 1000;
        ATC_STR_RAT_D: Real32 = 0 in 0 .. 100;
        ATC_STR_RAT_IMAX: Real32 = 0.5 in 0 .. 1;
        ATC_STR_RAT_MAX: Real32 = 120 in 0 .. 1000;
        ATC_STR_ANG_P: Real32 = 2 in 0.001 .. 20;
        ATC_SPEED_P: Real32 = 0.2 in 0 .. 100;
        ATC_SPEED_I: Real32 = 0.2 in 0 .. 100;
        ATC_SPEED_IMAX: Real32 = 1 in 0 .. 1;
        ATC_ACCEL_MAX: Real32 = 1 in 0 .. 10;
        ATC_DECEL_MAX: Real32 = 0.5 in 0.001 .. 10;
        ATC_TURN_MAX_G: Real32 = 0.6 in 0.001 .. 10;
        ATC_STOP_SPEED: Real32 = 0.1 in 0 .. 1;
        MOT_SLEWRATE: Int16 = 100 in 0 .. 1000;
        MOT_THR_MIN: Int8 = 0 in 0 .. 20;
        MOT_THR_MAX: Int8 = 100 in 5 .. 100;
        MOT_STR_THR_MIX: Real32 = 0.5 in 0.2 .. 1;
        MOT_SAFE_DISARM: Int8 = 0 in 0 .. 1;

        // Navigation.
        WP_SPEED: Real32 = 2 in 0 .. 100;
        WP_RADIUS: Real32 = 2 in 0.1 .. 1000;
        WP_LOOKAHEAD: Real32 = 10 in 0.5 .. 1000;
        RTL_SPEED: Real32 = 0 in 0 .. 100;
        SRTL_ACCURACY: Real32 = 2 in 0.1 .. 100;
        SRTL_POINTS: Int16 = 300 in 0 .. 500;
        LOIT_TYPE: Int8 = 0 in 0 .. 2;
        LOIT_RADIUS: Real32 = 2 in 0.1 .. 1000;
        LOIT_SPEED_GAIN: Real32 = 0.5 in 0 .. 5;
        CIRC_RADIUS: Real32 = 20 in 0.5 .. 10000;
        CIRC_SPEED: Real32 = 0 in 0 .. 100;
        CIRC_DIR: Int8 = 0 in 0 .. 1;
        MIS_TOTAL: Int16 = 0 in 0 .. 32767, read_only;
        MIS_RESTART: Int8 = 0 in 0 .. 1;
        MIS_OPTIONS: Int16 = 0 in 0 .. 15;
        MIS_DONE_BEHAVE: Int8 = 0 in 0 .. 3;
        FENCE_ENABLE: Int8 = 0 in 0 .. 1;
        FENCE_ACTION: Int8 = 1 in 0 .. 5;
        FENCE_TYPE: Int8 = 6 in 0 .. 7;
        FENCE_RADIUS: Real32 = 300 in 1 .. 10000;
        FENCE_MARGIN: Real32 = 2 in 0 .. 100;
        RALLY_LIMIT_KM: Real32 = 0.5 in 0 .. 100;
        RALLY_INCL_HOME: Int8 = 1 in 0 .. 1;
        FENCE_TOTAL: Int8 = 0 in 0 .. 127, read_only;
        RALLY_TOTAL: Int16 = 0 in 0 .. 32767, read_only;

        // Sensors, battery, log.
        AHRS_EKF_TYPE: Int8 = 3 in 0 .. 11;
        EK3_ENABLE: Int8 = 1 in 0 .. 1;
        GPS1_TYPE: Int8 = 1 in 0 .. 26;
        COMPASS_ENABLE: Int8 = 1 in 0 .. 1;
        COMPASS_DEC: Real32 = 0 in -3.2 .. 3.2;
        COMPASS_USE: Int8 = 1 in 0 .. 1;
        BATT_MONITOR: Int8 = 4 in 0 .. 32;
        BATT_CAPACITY: Int32 = 100000 in 1 .. 2000000;
        BATT_LOW_VOLT: Real32 = 0 in 0 .. 120;
        BATT_LOW_MAH: Real32 = 0 in 0 .. 2000000;
        BATT_LOW_TIMER: Int8 = 10 in 0 .. 120;
        BATT_CRT_VOLT: Real32 = 0 in 0 .. 120;
        BATT_CRT_MAH: Real32 = 0 in 0 .. 2000000;
        BATT_ARM_VOLT: Real32 = 0 in 0 .. 120;
        BATT_ARM_MAH: Int32 = 0 in 0 .. 2000000;
        BATT_FS_LOW_ACT: Int8 = 0 in 0 .. 7;
        BATT_FS_CRT_ACT: Int8 = 0 in 0 .. 7;
        LOG_BITMASK: Int32 = 0 in 0 .. 1048575;
        LOG_DISARMED: Int8 = 0 in 0 .. 3;

        // The simulated world: the sea (tide and wind with the direction they come from), its pace.
        SIM_TIDE_SPEED: Real32 = 0 in 0 .. 10;
        SIM_TIDE_DIR: Real32 = 0 in -360 .. 360;
        SIM_WIND_SPD: Real32 = 0 in 0 .. 60;
        SIM_WIND_DIR: Real32 = 180 in -360 .. 360;
        SIM_GPS_HZ: Int8 = 5 in 1 .. 50;
        SIM_SPEEDUP: Real32 = 1 in 0 .. 1000;

        // Faults of the simulated world (see the module `faults`). Names of ArduPilot's own simulator where
        // it has them.
        SIM_GPS_DISABLE: Int8 = 0 in 0 .. 1;
        SIM_GPS_FREEZE: Int8 = 0 in 0 .. 1;
        SIM_GPS_GLITCH_X: Real32 = 0 in -1 .. 1;
        SIM_GPS_GLITCH_Y: Real32 = 0 in -1 .. 1;
        SIM_GPS_DRIFT_N: Real32 = 0 in -100 .. 100;
        SIM_GPS_DRIFT_E: Real32 = 0 in -100 .. 100;
        SIM_MAG_YAW: Real32 = 0 in -180 .. 180;
        SIM_RUD_STUCK: Int8 = 0 in 0 .. 2;
        SIM_RUD_AT: Real32 = 0 in -1 .. 1;
        SIM_RUD_MUL: Real32 = 1 in 0 .. 1;
        SIM_ENGINE_FAIL: Int8 = 0 in 0 .. 3;
        SIM_ENGINE_MUL: Real32 = 1 in 0 .. 1;
        SIM_ENG_STUCK: Int8 = 0 in 0 .. 3;
        SIM_BATT_VOLTAGE: Real32 = 12.6 in 0 .. 100;
        SIM_BATT_LEFT: Real32 = -1 in -1 .. 100;
        SIM_EKF_FAIL: Int8 = 0 in 0 .. 1;
        SIM_REBOOT: Int8 = 0 in 0 .. 1;
        SIM_LNK_LOSS: Real32 = 0 in 0 .. 100;
        SIM_LNK_DELAY: Real32 = 0 in 0 .. 60000;
        SIM_LNK_JITTER: Real32 = 0 in 0 .. 60000;
        SIM_LNK_DUP: Real32 = 0 in 0 .. 100;
        SIM_LNK_REORDER: Real32 = 0 in 0 .. 100;
        SIM_LNK_CORRUPT: Real32 = 0 in 0 .. 100;
        SIM_LNK_OUTAGE: Real32 = 0 in 0 .. 3600;
        SIM_LNK_NUMBER: Int32 = -1 in -1 .. 2147483000;
    }

    pub(super) fn definitions() -> Vec<Definition> {
        single()
    }

    pub(super) const COUNT: usize = SINGLE_ROWS;
}

pub(in crate::autopilot) use rows::*;

/// What can be set of an input channel, in table order.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::autopilot) enum RcField {
    /// Pulse at one end, µs.
    Min,
    /// Neutral pulse, µs.
    Trim,
    /// Pulse at the other end, µs.
    Max,
    /// 1 to swap the direction.
    Reversed,
    /// Dead zone to either side of neutral, µs.
    Dz,
}

/// What can be set of an output, in table order.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::autopilot) enum ServoField {
    /// Pulse at one end, µs.
    Min,
    /// Neutral pulse, µs.
    Trim,
    /// Pulse at the other end, µs.
    Max,
    /// 1 to swap the direction.
    Reversed,
    /// What the output drives (ArduPilot's SERVOn_FUNCTION).
    Function,
}

const RC_FIELDS: [(&str, Kind, f32, (f32, f32)); 6] = [
    ("MIN", Kind::Int16, 1000.0, (800.0, 2200.0)),
    ("TRIM", Kind::Int16, 1500.0, (800.0, 2200.0)),
    ("MAX", Kind::Int16, 2000.0, (800.0, 2200.0)),
    ("REVERSED", Kind::Int8, 0.0, (0.0, 1.0)),
    ("DZ", Kind::Int16, 30.0, (0.0, 200.0)),
    // Auxiliary function: none is simulated, but ground stations expect to see it.
    ("OPTION", Kind::Int16, 0.0, (0.0, 400.0)),
];

const SERVO_FIELDS: [(&str, Kind, f32, (f32, f32)); 5] = [
    ("MIN", Kind::Int16, 1000.0, (500.0, 2200.0)),
    ("TRIM", Kind::Int16, 1500.0, (500.0, 2200.0)),
    ("MAX", Kind::Int16, 2000.0, (800.0, 2200.0)),
    ("REVERSED", Kind::Int8, 0.0, (0.0, 1.0)),
    ("FUNCTION", Kind::Int16, 0.0, (-1.0, 200.0)),
];

/// A parameter of input channel `channel`, 1 to [`CHANNELS`].
pub(in crate::autopilot) fn rc(channel: usize, field: RcField) -> Param {
    Param(COUNT + (channel - 1) * RC_FIELDS.len() + field as usize)
}

/// A parameter of output `output`, 1 to [`CHANNELS`].
pub(in crate::autopilot) fn servo(output: usize, field: ServoField) -> Param {
    let rc_rows = CHANNELS * RC_FIELDS.len();
    Param(COUNT + rc_rows + (output - 1) * SERVO_FIELDS.len() + field as usize)
}

/// The whole table.
pub(super) fn definitions() -> Vec<Definition> {
    let mut all = rows::definitions();
    for (prefix, fields) in [("RC", &RC_FIELDS[..]), ("SERVO", &SERVO_FIELDS[..])] {
        for number in 1..=CHANNELS {
            all.extend(fields.iter().map(|&(suffix, kind, default, range)| Definition {
                name: format!("{prefix}{number}_{suffix}"),
                kind,
                default,
                range,
                read_only: false,
            }));
        }
    }
    all
}
