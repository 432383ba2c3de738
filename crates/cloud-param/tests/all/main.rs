//! All integration tests of `cloud-param` in one binary: linking once is most of what building them costs.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "tests may panic")]

mod common;
mod directed;
mod directed_weights;
mod hull;
mod multilevel;
mod parameterise;
mod turntable;
mod visibility;
