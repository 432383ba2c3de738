//! All integration tests of `distance-field` in one binary: linking once is most of what building them costs.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "tests may panic")]

mod adaptive;
mod analytic;
mod cloud;
mod common;
mod curve;
mod d2_tree;
mod grid;
mod level_set;
mod mesh;
mod mls;
mod planar_cloud;
mod redistance;
mod surface;
mod threads;
