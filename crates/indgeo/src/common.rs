//! Options of every command.

use crate::error::Error;
use clap::Args;
use std::path::PathBuf;

/// Options of every command.
#[derive(Debug, Args)]
#[command(next_help_heading = "Options of every command")]
pub(crate) struct Common {
    /// Write a machine-readable report (JSON) to FILE; `-` is standard output, where then nothing else is printed
    ///
    /// The report is written on errors too (`"status": "error"`), whenever the command line itself was understood.
    #[arg(long, global = true, value_name = "FILE")]
    pub(crate) json: Option<PathBuf>,
    /// Leave the times out of report and summary, so that equal results are equal to the byte
    #[arg(long, global = true)]
    pub(crate) no_timings: bool,
    /// Number of threads [default: one per core]; results do not depend on it
    #[arg(long, global = true, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub(crate) threads: Option<u16>,
    /// Print errors only: no summary, no warnings, no progress
    #[arg(long, short, global = true)]
    pub(crate) quiet: bool,
}

impl Common {
    /// Makes sure that a fit leaves something behind: a file, or the report.
    pub(crate) fn something_written(&self, any_file: bool, output: &str) -> Result<(), Error> {
        if any_file || self.json.is_some() {
            return Ok(());
        }
        Err(Error::usage(format!("nothing would be written without {output}"), "add it, or --json FILE"))
    }
}

/// Lets `-0.1` after an option be its value: what is wrong with it is then said.
pub(crate) fn with_negative_numbers(command: clap::Command) -> clap::Command {
    command.mut_args(|arg| {
        let takes_values = arg.get_action().takes_values() && !arg.is_positional();
        if takes_values { arg.allow_negative_numbers(true) } else { arg }
    })
}

/// The arguments of one command, from words without its name.
///
/// # Errors
/// Words that the command does not take.
pub(crate) fn parse<A: Args>(words: &[String]) -> Result<A, clap::Error> {
    let command = with_negative_numbers(A::augment_args(clap::Command::new("command")));
    A::from_arg_matches(&command.no_binary_name(true).try_get_matches_from(words)?)
}
