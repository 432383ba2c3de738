//! Commands called from another language.

use crate::args::Cli;
use crate::commands;
use crate::error::Error;
use crate::report::{Outcome, Report};
use crate::runtime::memory::{Input, Surroundings, without_mark};
use crate::runtime::threads;
use crate::runtime::watch::Watch;
use std::collections::BTreeMap;
use std::sync::Arc;

/// What a message of a command is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ErrorKind {
    /// The operating system refused to read or write a file.
    File,
    /// An option, or the content of a file, cannot be used.
    Value,
}

/// A command that was called and has ended.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Called {
    /// As the exit status of the program: 0 what was asked for holds, 1 it does not or is not proven, 2 bad input or usage, 130
    /// cancelled.
    pub exit_code: u8,
    /// The report (`--json`) as text.
    pub report: String,
    /// For a person to read; empty after an error.
    pub summary: String,
    /// What the user should know.
    pub warnings: Vec<String>,
    /// The message of exit status 2, and what it is about.
    pub error: Option<(ErrorKind, String)>,
    /// What was written to files in memory, by name.
    pub outputs: BTreeMap<String, Vec<u8>>,
}

/// Runs a command as the program `indgeo` does: `arguments` are those of the command line, without the name of the program.
///
/// Paths made by [`memory_path`](crate::memory_path) stand for `inputs`, by name, which are read where they are, and for outputs
/// that come back. Nothing is printed; progress and a request to stop go through `watch`. After such a request nothing more is
/// written.
#[must_use]
pub fn call<B>(arguments: &[String], inputs: BTreeMap<String, B>, watch: &Arc<Watch>) -> Called
where
    B: AsRef<[u8]> + Send + Sync + 'static,
{
    let inputs = inputs.into_iter().map(|(name, bytes)| (name, Box::new(bytes) as Input)).collect();
    call_with(arguments, inputs, watch)
}

fn call_with(arguments: &[String], inputs: BTreeMap<String, Input>, watch: &Arc<Watch>) -> Called {
    let cli = match Cli::of_arguments(arguments) {
        Ok(cli) => cli,
        Err(error) => {
            let text = error.to_string();
            let message = text.split("\n\nFor more information").next().unwrap_or(&text);
            return refused(message.trim_start_matches("error: ").trim_end());
        }
    };
    let mut report = Report::of_command(cli.command.name());
    report.no_timings = cli.common.no_timings;
    let surroundings = Surroundings::new(inputs, Arc::clone(watch));
    let ended = threads::with_threads(cli.common.threads, || {
        surroundings.around(|| commands::run(&cli.command, &cli.common, &mut report))
    });
    report.end(&ended);
    let mut called = of_report(&report, surroundings.take_outputs());
    match ended {
        Ok(Outcome { summary, .. }) => called.summary = without_mark(&summary),
        Err(error) => {
            let kind = if error.is_of_system() { ErrorKind::File } else { ErrorKind::Value };
            called.error = Some((kind, without_mark(&error.to_string())));
        }
    }
    if watch.is_cancelled() {
        called.exit_code = crate::runtime::interrupt::INTERRUPTED;
        called.outputs.clear();
    }
    called
}

fn of_report(report: &Report, outputs: BTreeMap<String, Vec<u8>>) -> Called {
    Called {
        exit_code: report.exit_code,
        report: serde_json::to_string(report).map(|text| text.replace("\\u0000", "")).unwrap_or_default(),
        summary: String::new(),
        warnings: report.warnings.iter().map(|warning| without_mark(warning)).collect(),
        error: None,
        outputs,
    }
}

/// Arguments that are not understood.
fn refused(message: &str) -> Called {
    let mut report = Report::of_command("");
    report.end(&Err(Error::usage(message, "see the documentation of this function")));
    let mut called = of_report(&report, BTreeMap::new());
    called.error = Some((ErrorKind::Value, without_mark(message)));
    called
}
