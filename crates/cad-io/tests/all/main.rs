//! Behaviour of readers and writers on files.

#![allow(clippy::unwrap_used, clippy::panic, reason = "tests may panic")]

#[cfg(feature = "step")]
mod step;
#[cfg(feature = "step")]
mod step_damage;
