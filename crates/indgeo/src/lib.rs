//! The commands of Industrial Geometry: `indgeo project | inspect | merge | align | register | register-views | fit-curve | parameterize |
//! fit-surface | fit-ruled | fit-subdivision | contour | field | geodesic | morphology | segment | convert | info | demo | selftest`.
//!
//! The program `indgeo` is [`main`]. [`call`] runs a command for another language in the same way, with the same checks, defaults
//! and messages; its inputs and outputs may be in memory.
//!
//! ```
//! use indgeo::{Watch, call, memory_path};
//! use std::collections::BTreeMap;
//! use std::sync::Arc;
//!
//! let scan = b"x,y,z\n1,2,3\n".to_vec();
//! let arguments = ["convert", &memory_path("scan"), &memory_path("scan.xyz")].map(str::to_owned);
//! let called = call(&arguments, BTreeMap::from([("scan".to_owned(), scan)]), &Arc::new(Watch::default()));
//! assert_eq!((called.exit_code, called.outputs["scan.xyz"].as_slice()), (0, b"1 2 3\n".as_slice()));
//! ```

mod aligning;
mod alignment_summary;
mod args;
mod between_vertices;
mod cad;
mod cad_conversion;
mod cad_output;
mod cad_shapes;
mod cad_tessellating;
mod call;
mod commands;
mod contour;
mod converting_pieces;
mod datum_file;
mod demo;
mod error;
mod evolution;
mod field;
mod field_model;
mod files;
mod fit_numbers;
mod fitting_curve;
mod fitting_input;
mod fitting_model;
mod fitting_ruled;
mod fitting_subdivision;
mod fitting_surface;
mod inspecting;
mod interrupt;
mod memory;
mod model;
mod moving;
mod on_surface;
mod output;
mod parameterizing;
mod partials;
mod paths;
mod planar_start;
mod points;
mod poses;
mod progress;
mod projection;
mod projection_pieces;
mod projection_results;
mod registering;
mod registering_views;
mod registration_approach;
mod registration_elsewhere;
mod registration_field;
mod registration_model;
mod registration_near;
mod registration_page;
mod registration_report;
mod registration_runs;
mod registration_sight;
mod registration_starts;
mod registration_step;
mod registration_verdict;
mod report;
mod sampling;
mod scan_files;
mod scan_views;
mod segmenting;
mod selftest;
mod session;
mod staging;
mod summary;
mod surface_conclusion;
mod surface_finish;
mod surface_judgement;
mod surface_start;
mod target;
mod tessellating;
mod threads;
mod transform;
mod views_report;
mod watch;
mod wording;

pub use call::{Called, ErrorKind, call};
pub use memory::memory_path;
pub use watch::Watch;

use std::process::ExitCode;

/// Runs the command that was typed.
#[must_use]
pub fn main() -> ExitCode {
    session::run(&args::Cli::of_command_line())
}
