//! `cargo xtask tidy`: the house rules that neither the compiler nor clippy holds.
//!
//! Each check is a function from files (or packages) to findings, in a file of its own, so that it can be tested on a few lines held in memory.

mod algorithms;
mod circles;
mod citations;
mod crate_docs;
mod dependencies;
mod finding;
mod fixtures;
mod forbidden;
mod length;
mod snapshots;
mod wrappers;

use crate::{Failure, workspace};
use finding::Severity;

/// Runs every check over the workspace and prints what was found, errors last.
pub(crate) fn run(arguments: &[String]) -> Result<(), Failure> {
    if let Some(argument) = arguments.first() {
        return Err(Failure::Usage(format!("tidy takes no argument, found `{argument}`")));
    }
    let root = workspace::root();
    let files = workspace::files(&root).map_err(Failure::Failed)?;
    let packages = workspace::packages(&root).map_err(Failure::Failed)?;

    let mut findings = dependencies::check(&packages, &files);
    findings.extend(wrappers::check(&packages, &files));
    findings.extend(circles::check(&packages, &files));
    findings.extend(length::check(&files));
    findings.extend(citations::check(&files));
    findings.extend(algorithms::check(&files));
    findings.extend(forbidden::check(&files));
    findings.extend(snapshots::check(&files));
    findings.extend(crate_docs::check(&packages, &files));
    findings.extend(fixtures::check(&files));
    findings.sort_by_key(|finding| finding.severity);
    for finding in &findings {
        println!("{finding}");
    }

    let errors = findings.iter().filter(|finding| finding.severity == Severity::Error).count();
    if errors > 0 {
        return Err(Failure::Failed(format!("tidy found {errors} thing(s) to mend")));
    }
    println!("tidy: {} files, {} crates, nothing to mend", files.len(), packages.len());
    Ok(())
}
