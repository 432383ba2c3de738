//! All integration tests of `sdm-register` in one binary: linking once is most of what building them costs.

mod bodies;
mod cases;
mod common;
mod covariance;
mod laws;
mod motions;
mod robust;
mod start;
mod targets;
mod views;
