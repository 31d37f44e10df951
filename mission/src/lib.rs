//! Missions as data, from the file a navigator drew to the curve a boat follows.
//!
//! | module | what it holds |
//! |---|---|
//! | [`angle`] | angles on the circle |
//! | [`geodesy`] | positions on the WGS 84 ellipsoid and in a local north-east plane |
//! | [`plan`] | mission items and the files they are kept in |
//! | [`route`] | what a mission means to a boat: waypoints, speeds, waits |
//! | [`path`] | the curve itself: legs and smooth turns by arc length |
//! | [`track`] | a driven track as a mission |
//! | [`protocol`] | the MAVLink mission protocol, both ends |
//!
//! Nothing here owns a socket, a file handle that outlives a call, or a clock.

pub mod angle;
pub mod geodesy;
pub mod path;
pub mod plan;
pub mod protocol;
pub mod route;
pub mod track;
