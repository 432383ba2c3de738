//! Industrial Geometry on the command line: `indgeo project | inspect | convert | info | demo`.

mod args;
mod commands;
mod demo;
mod error;
mod files;
mod inspecting;
mod model;
mod output;
mod points;
mod poses;
mod progress;
mod projection;
mod registering;
mod registration_model;
mod registration_report;
mod report;
mod session;
mod summary;
mod target;
mod threads;
mod transform;

use clap::Parser;
use std::process::ExitCode;

fn main() -> ExitCode {
    session::run(&args::Cli::parse())
}
