//! All integration tests of `indgeo` in one binary: linking once is most of what building them costs.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "tests may panic")]

mod align;
mod browser;
#[cfg(feature = "step")]
mod cad;
mod cad_output;
mod common;
mod contour;
mod degenerate;
mod demo;
mod errors;
mod exit_status;
mod field;
mod files;
mod fit_curve;
mod fit_edges;
mod fit_ruled;
mod fit_subdivision;
mod fit_surface;
mod fit_surface_outline;
mod fits_at_limits;
mod fits_both_ways;
mod geodesic;
mod in_pieces;
mod inspect;
mod interrupts;
mod magnitudes;
mod memory;
mod options;
mod parameterize;
mod partials;
mod project;
mod reading;
mod register;
mod register_doubts;
mod register_features;
mod register_places;
mod register_verdicts;
mod register_views;
mod report;
mod scanners;
mod segment;
mod selftest;
mod tessellate;
mod thin_parts;
mod thin_walls;
