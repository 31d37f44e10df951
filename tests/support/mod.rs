//! What black-box tests need: the real `helmlink` as a child process, and real ground stations in Python.
//!
//! To test with a client program: put a script into `tests/clients/` (`boat.py` has the helpers for pymavlink)
//! that takes addresses as arguments, waits for conditions and never for time, and raises when something is
//! wrong. Run it from a test with [`Script::run`], or start it with [`Script::start`] when the test has to do
//! something between its lines. A Python package that it needs goes into `tests/clients/requirements.txt`,
//! pinned, with whatever that package imports.

// Each test binary uses a part of this.
#![allow(dead_code, unreachable_pub, unused_imports)]
#![allow(clippy::expect_used, clippy::panic, clippy::unwrap_used)]

pub mod correspondent;
pub mod folder;
pub mod helmlink;
pub mod process;
pub mod python;

pub use correspondent::Correspondent;
pub use folder::Folder;
pub use helmlink::Helmlink;
pub use python::Script;
