//! From arguments to an exit status: runs a command, prints its summary, warnings and errors, writes its report.

use crate::args::{Cli, Command, Common};
use crate::commands::{self, Outcome};
use crate::error::Error;
use crate::files;
use crate::report::Report;
use crate::threads;
use industrial_geometry::io::{AtomicFile, remove_unfinished};
use std::io::Write;
use std::path::Path;
use std::process::ExitCode;

/// The exit status of a program that was interrupted: 128 and the number of the signal.
const INTERRUPTED: i32 = 130;

/// Runs the command that was asked for.
pub(crate) fn run(cli: &Cli) -> ExitCode {
    let common = &cli.common;
    if let Err(error) = ctrlc::set_handler(interrupted) {
        let _ =
            writeln!(std::io::stderr(), "warning: an interrupt will leave temporary files behind: {error}");
    }
    let mut report =
        Report { command: cli.command.name(), version: env!("CARGO_PKG_VERSION"), ..Report::default() };
    let json_file = common.json.as_deref().filter(|path| !files::is_stream(path));
    let mut ended = match json_file.map_or(Ok(()), |path| check_report(path, &cli.command)) {
        Ok(()) => threads::with_threads(common.threads, || commands::run(&cli.command, common, &mut report)),
        Err(error) => return fail(&error),
    };
    if let Ok(outcome) = &ended
        && let Err(error) = tell(common, outcome, &report.warnings)
    {
        ended = Err(error);
    }
    (report.status, report.exit_code) = match &ended {
        Ok(Outcome { converged: true, .. }) => ("done", 0),
        Ok(Outcome { otherwise, .. }) => (*otherwise, 1),
        Err(_) => ("error", 2),
    };
    report.error = ended.as_ref().err().map(ToString::to_string);
    if let Some(path) = &common.json
        && let Err(error) = write_report(path, &report)
    {
        // The first error is the one to know about.
        ended = ended.and(Err(error));
    }
    match ended {
        Ok(_) => ExitCode::from(report.exit_code),
        Err(error) => fail(&error),
    }
}

/// Ends the program when the user or the system asks for it, without half-written output.
fn interrupted() {
    remove_unfinished();
    let _ = writeln!(std::io::stderr(), "interrupted: no output was written");
    std::process::exit(INTERRUPTED);
}

/// Makes sure that the report can be written and takes the place of no other file of the command.
fn check_report(path: &Path, command: &Command) -> Result<(), Error> {
    let (inputs, outputs) = command.files();
    if outputs.iter().any(|output| files::is_same(path, output)) {
        return Err(Error::content(
            path,
            "this is the output as well",
            "choose another name for the report (`--json`)",
        ));
    }
    files::check_writable(path, &inputs)
}

fn fail(error: &Error) -> ExitCode {
    let _ = writeln!(std::io::stderr(), "error: {error}");
    ExitCode::from(2)
}

/// Prints warnings and the summary. A reader that went away is no reason to fail.
///
/// # Errors
/// If standard output cannot be written for another reason, such as a full disk.
pub(crate) fn tell(common: &Common, outcome: &Outcome, warnings: &[String]) -> Result<(), Error> {
    if common.quiet {
        return Ok(());
    }
    let mut stderr = std::io::stderr().lock();
    for warning in warnings {
        let _ = writeln!(stderr, "warning: {warning}");
    }
    if !common.json.as_deref().is_some_and(files::is_stream) {
        let mut stdout = std::io::stdout().lock();
        let written = writeln!(stdout, "{}", outcome.summary.trim_end()).and_then(|()| stdout.flush());
        if let Err(source) = written
            && source.kind() != std::io::ErrorKind::BrokenPipe
        {
            return Err(Error::write(Path::new("standard output"), source));
        }
    }
    Ok(())
}

fn write_report(path: &Path, report: &Report) -> Result<(), Error> {
    let failed = |source: std::io::Error| Error::write(path, source);
    let mut text = serde_json::to_string_pretty(report).map_err(|error| failed(error.into()))?;
    text.push('\n');
    if files::is_stream(path) {
        return std::io::stdout().write_all(text.as_bytes()).map_err(failed);
    }
    let mut file = AtomicFile::create(path)?;
    file.write_all(text.as_bytes()).map_err(failed)?;
    file.commit()?;
    Ok(())
}
