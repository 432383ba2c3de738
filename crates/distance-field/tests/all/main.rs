//! All integration tests of `distance-field` in one binary: linking once is most of what building them costs.

mod analytic;
mod cloud;
mod common;
mod curve;
mod d2_tree;
mod level_set;
mod mesh;
mod surface;
mod threads;
