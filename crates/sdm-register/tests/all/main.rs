//! All integration tests of `sdm-register` in one binary: linking once is most of what building them costs.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "tests may panic")]

mod bodies;
mod cases;
mod common;
mod correlated;
mod covariance;
mod coverage;
mod ends;
mod laws;
mod motions;
mod noise;
mod rivals;
mod robust;
mod sample;
mod scales;
mod start;
mod symmetry;
mod targets;
mod verdicts;
mod views;
