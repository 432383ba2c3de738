//! All integration tests of `sdm-register` in one binary: linking once is most of what building them costs.

mod bodies;
mod cases;
mod common;
mod laws;
mod robust;
mod start;
mod targets;
mod views;
