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

mod args;
mod commands;
mod common;
mod error;
mod files;
mod fits;
mod input;
mod on_surface;
mod output;
mod paths;
mod report;
mod runtime;

pub use runtime::call::{Called, ErrorKind, call};
pub use runtime::memory::memory_path;
pub use runtime::watch::Watch;

use std::process::ExitCode;

/// Runs the command that was typed.
#[must_use]
pub fn main() -> ExitCode {
    runtime::session::run(&args::Cli::of_command_line())
}
