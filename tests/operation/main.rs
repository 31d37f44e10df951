//! The bridge in operation, as a program: its links break, it is killed and started again, runs as a service.

#![cfg(unix)]
#![allow(clippy::expect_used, clippy::panic, clippy::unwrap_used)]

mod exits;
mod links;
mod parameters;
mod resume;
mod service;
mod signing;
#[path = "../support/mod.rs"]
mod support;
