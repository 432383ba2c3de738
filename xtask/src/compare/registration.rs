//! `cargo xtask compare registration [FIXTURES]`: registrations by `Open3D` beside those by `indgeo`.
//!
//! The script `xtask/compare/open3d_registration.py` makes the clouds and takes the times; `PYTHON` names the interpreter, in which
//! open3d must be installed. FIXTURES is a folder with `mesh/bunny.obj`, and with two clouds of a lidar in `registration/small_gicp`
//! if they are to be registered, too; without it the folder `fixtures` of the workspace is taken. It measures
//! `target/release/indgeo`, which must have been built.

use crate::{Failure, workspace};
use std::path::PathBuf;
use std::process::Command;

const INSTALL: &str =
    "install it (`python3 -m venv venv && venv/bin/pip install open3d`) and set PYTHON=venv/bin/python";

/// Runs the command.
pub(crate) fn run(fixtures: Option<&String>) -> Result<(), Failure> {
    let root = workspace::root();
    let program = root.join("target/release").join(format!("indgeo{}", std::env::consts::EXE_SUFFIX));
    if !program.is_file() {
        let what = format!("{} does not exist; run `cargo build --release` first", program.display());
        return Err(Failure::Failed(what));
    }
    let fixtures = fixtures.map_or_else(|| root.join("fixtures"), PathBuf::from);
    let python = std::env::var_os("PYTHON").unwrap_or_else(|| "python3".into());
    let script = root.join("xtask/compare/open3d_registration.py");
    let mut command = Command::new(&python);
    let status = command.arg(script).arg(program).arg(fixtures).status().map_err(|error| {
        Failure::Failed(format!("{} did not start: {error}; {INSTALL}", python.to_string_lossy()))
    })?;
    if status.success() {
        return Ok(());
    }
    Err(Failure::Failed(format!("the script failed ({status}); if open3d is missing, {INSTALL}")))
}
