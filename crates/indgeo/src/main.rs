//! Industrial Geometry on the command line: `indgeo project | inspect | align | register | register-views | fit-curve | parameterize |
//! fit-surface | fit-ruled | fit-subdivision | field | geodesic | morphology | convert | info | demo | selftest`.

mod aligning;
mod alignment_summary;
mod args;
mod between_vertices;
mod cad;
mod cad_conversion;
mod cad_output;
mod commands;
mod datum_file;
mod demo;
mod error;
mod evolution;
mod field;
mod files;
mod fit_numbers;
mod fitting_curve;
mod fitting_input;
mod fitting_ruled;
mod fitting_subdivision;
mod fitting_surface;
mod inspecting;
mod inspecting_pieces;
mod inspection_results;
mod interrupt;
mod model;
mod moving;
mod on_surface;
mod output;
mod parameterizing;
mod paths;
mod planar_start;
mod points;
mod poses;
mod progress;
mod projection;
mod registering;
mod registering_views;
mod registration_field;
mod registration_model;
mod registration_report;
mod registration_verdict;
mod report;
mod selftest;
mod session;
mod staging;
mod summary;
mod surface_judgement;
mod surface_start;
mod target;
mod tessellating;
mod threads;
mod transform;
mod views_report;
mod wording;

use std::process::ExitCode;

fn main() -> ExitCode {
    session::run(&args::Cli::of_command_line())
}
