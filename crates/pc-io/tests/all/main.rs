//! All integration tests of `pc-io` in one binary: linking once is most of what building them costs.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "tests may panic")]

mod common;
mod coordinates;
mod meshes;
mod mutation;
mod nurbs_files;
mod odd_rows;
mod pieces;
mod reference;
mod round_trip;
mod scanner_damage;
mod scanner_writing;
mod scanners;
mod sniffing;
mod tables;
