//! All integration tests of `sdm-fit` in one binary: linking once is most of what building them costs.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "tests may panic")]

mod curve_cases;
mod curve_narrow;
mod curve_search;
mod curve_terms;
mod curve_two_sided;
mod curves;
mod exact;
mod level_sets;
mod primitive_odd;
mod primitive_search;
mod primitives;
mod ruled;
mod subdivision;
mod surface_tolerance;
mod surfaces;
mod teapot;
