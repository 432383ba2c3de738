//! All integration tests of `nurbs-core` in one binary: linking once is most of what building them costs.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "tests may panic")]

mod analytic;
mod batch;
mod construct;
mod fitting;
mod joined;
mod knot_operations;
mod laws;
mod offset;
mod random;
mod refinement;
mod tessellate;
