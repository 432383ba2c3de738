//! Documents that are written by a chore.

use crate::{Failure, workspace};
use std::fs;

/// Reads the arguments of a chore that writes documents: nothing, or `--check`.
pub(crate) fn is_check(arguments: &[String]) -> Result<bool, Failure> {
    match arguments {
        [] => Ok(false),
        [argument] if argument == "--check" => Ok(true),
        [argument, ..] => Err(Failure::Usage(format!("`{argument}` is not understood"))),
    }
}

/// Writes `text` to `path` (from the workspace root); with `check` compares instead.
pub(crate) fn write_or_check(path: &str, text: &str, check: bool, command: &str) -> Result<(), Failure> {
    let full = workspace::root().join(path);
    let found = fs::read_to_string(&full);
    if found.as_ref().is_ok_and(|found| found == text) {
        println!("{path} is up to date");
        return Ok(());
    }
    if check {
        let line = found.map_or(1, |found| {
            let same = found.lines().zip(text.lines()).take_while(|(a, b)| a == b).count();
            same + 1
        });
        return Err(Failure::Failed(format!(
            "{path}:{line}: differs from what the library computes; run `cargo xtask {command}` and look at the difference"
        )));
    }
    if let Some(folder) = full.parent() {
        fs::create_dir_all(folder)
            .map_err(|error| Failure::Failed(format!("{}: {error}", folder.display())))?;
    }
    fs::write(&full, text).map_err(|error| Failure::Failed(format!("{path}: {error}")))?;
    println!("{path} written");
    Ok(())
}
