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

/// Writes `text` to `path` (from the workspace root); with `check` compares instead, line by line with
/// `alike`.
pub(crate) fn write_or_check(
    path: &str,
    text: &str,
    check: bool,
    command: &str,
    alike: fn(&str, &str) -> bool,
) -> Result<(), Failure> {
    let full = workspace::root().join(path);
    let found = fs::read_to_string(&full);
    if found.as_ref().is_ok_and(|found| found == text) {
        println!("{path} is up to date");
        return Ok(());
    }
    if check {
        let found = found.unwrap_or_default();
        let (n, same) =
            (text.lines().count(), found.lines().zip(text.lines()).take_while(|(a, b)| alike(a, b)).count());
        if same == n && found.lines().count() == n {
            println!("{path} is up to date");
            return Ok(());
        }
        let line = same + 1;
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

/// Equality, for documents whose every digit is meant.
pub(crate) fn identical(a: &str, b: &str) -> bool {
    a == b
}

/// Equality up to what another rounding of the last bit can do to measured numbers.
///
/// An iteration that wanders before it converges amplifies the last bit, and that one depends on how the
/// processor and the compiler contract a sum. Decimal numbers may differ by 0.2 and a hundredth, integers
/// (extremes of thousands of runs) by 3 and three tenths.
pub(crate) fn alike_as_measured(a: &str, b: &str) -> bool {
    let close = |a: &str, b: &str| {
        let (Ok(p), Ok(q)) = (a.parse::<f64>(), b.parse::<f64>()) else { return a == b };
        let size = p.abs().max(q.abs());
        let slack = if a.contains('.') { 0.2 + 0.01 * size } else { 3.0 + 0.3 * size };
        (p - q).abs() <= slack
    };
    a.split_whitespace().count() == b.split_whitespace().count()
        && a.split_whitespace().zip(b.split_whitespace()).all(|(a, b)| close(a, b))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn measured_numbers_may_wander_a_little() {
        assert!(alike_as_measured("| Newton | 2.0 | 100.0 % | 80 |", "| Newton | 2.1 | 99.9 % | 85 |"));
        assert!(!alike_as_measured("| Newton | 2.0 | 100.0 % | 80 |", "| Newton | 2.0 | 97.0 % | 80 |"));
        assert!(!alike_as_measured("| Newton | 2.0 |", "| Newton | 1.0 |"));
        assert!(!alike_as_measured("| Newton | 2.0 |", "| newton | 2.0 |"));
        assert!(!alike_as_measured("a b", "a"));
    }
}
