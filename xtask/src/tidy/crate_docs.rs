//! Every crate says what it is: a description in its manifest and documentation at the head of its root module.

use super::finding::Finding;
use crate::workspace::{File, Package};

/// Fewest lines of `//!` at the head of a library: a paragraph and an example do not fit into less.
const FEWEST_LINES: usize = 8;

/// Finds packages without a description, and roots without `//!` (libraries need a paragraph and an example).
pub(crate) fn check(packages: &[Package], files: &[File]) -> Vec<Finding> {
    let mut findings = Vec::new();
    for package in packages {
        if package.description.trim().is_empty() {
            findings.push(Finding::error(
                &package.manifest,
                0,
                "no description",
                "add one sentence as `description`",
            ));
        }
        let root_named = |name: &str| {
            let path = format!("{}/src/{name}", package.folder());
            files.iter().find(|file| file.path == path)
        };
        if let Some(library) = root_named("lib.rs") {
            findings.extend(check_library(library));
        } else if let Some(program) = root_named("main.rs") {
            if documentation(program).next().is_none() {
                findings.push(Finding::error(
                    &program.path,
                    1,
                    "no crate documentation",
                    "say in `//!` what the program does",
                ));
            }
        } else {
            findings.push(Finding::error(
                &package.manifest,
                0,
                "neither src/lib.rs nor src/main.rs",
                "add the root module",
            ));
        }
    }
    findings
}

fn check_library(root: &File) -> Option<Finding> {
    let lines = documentation(root).count();
    if lines < FEWEST_LINES {
        return Some(Finding::error(
            &root.path,
            1,
            format!("{lines} line(s) of crate documentation, at least {FEWEST_LINES} are wanted"),
            "say in `//!` what the crate is for, what it holds, and show an example",
        ));
    }
    if !documentation(root).any(|line| line.trim_start().starts_with("```")) {
        return Some(Finding::error(
            &root.path,
            1,
            "the crate documentation shows no example",
            "add a short one that asserts something",
        ));
    }
    None
}

/// The lines of `//!` at the head of a file, without the marker.
fn documentation(root: &File) -> impl Iterator<Item = &str> {
    root.numbered_lines().map_while(|(_, line)| line.strip_prefix("//!"))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn package(description: &str) -> Package {
        Package {
            name: "a".into(),
            description: description.into(),
            manifest: "crates/a/Cargo.toml".into(),
            dependencies: Vec::new(),
        }
    }

    #[test]
    fn a_documented_library_passes() {
        let text = format!("{}//! ```\n//! assert!(true);\n//! ```\n", "//! Words.\n".repeat(6));
        assert!(check(&[package("Words.")], &[File::in_memory("crates/a/src/lib.rs", &text)]).is_empty());
    }

    #[test]
    fn silence_fails() {
        let short = File::in_memory("crates/a/src/lib.rs", "//! Words.\n");
        let findings = check(&[package("")], &[short]);
        assert!(findings[0].what.contains("no description"), "{}", findings[0]);
        assert!(findings[1].what.contains("1 line(s)"), "{}", findings[1]);

        let no_example = File::in_memory("crates/a/src/lib.rs", &"//! Words.\n".repeat(9));
        assert!(check(&[package("Words.")], &[no_example])[0].what.contains("no example"));

        let program = File::in_memory("crates/a/src/main.rs", "fn main() {}\n");
        assert!(check(&[package("Words.")], &[program])[0].what.contains("no crate documentation"));
    }
}
