//! Industrial Geometry on the command line: `indgeo project | convert | info | demo`.

mod args;
mod commands;
mod demo;
mod error;
mod files;
mod model;
mod output;
mod points;
mod progress;
mod projection;
mod report;
mod session;
mod statistics;
mod summary;
mod target;
mod threads;

use clap::Parser;
use std::process::ExitCode;

fn main() -> ExitCode {
    session::run(&args::Cli::parse())
}
