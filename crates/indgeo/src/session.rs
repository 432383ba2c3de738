//! From arguments to an exit status: runs a command, prints its summary, warnings and errors, writes its report.

use crate::args::{Cli, Command, Common};
use crate::commands::{self, Outcome};
use crate::error::Error;
use crate::files;
use crate::interrupt;
use crate::report::Report;
use crate::threads;
use industrial_geometry::io::AtomicFile;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Runs the command that was asked for.
pub(crate) fn run(cli: &Cli) -> ExitCode {
    let common = &cli.common;
    if let Err(error) = ctrlc::set_handler(interrupt::handle) {
        let _ =
            writeln!(std::io::stderr(), "warning: an interrupt will leave temporary files behind: {error}");
    }
    let mut report = Report::of_command(cli.command.name());
    report.no_timings = cli.common.no_timings;
    let json_file = common.json.as_deref().filter(|path| !files::is_stream(path));
    let checked = check_stream(common, &cli.command)
        .and_then(|()| json_file.map_or(Ok(()), |path| check_report(path, &cli.command)));
    if let Err(error) = checked {
        return fail(&error);
    }
    interrupt::watch(common.json.as_deref(), &report);
    let mut ended =
        threads::with_threads(common.threads, || commands::run(&cli.command, common, &mut report));
    // What follows is the end of the command, which an interrupt does not change any more.
    let _ended = interrupt::too_late();
    let is_taken = cli.command.files().1.iter().any(|path| files::is_stream(path));
    if let Ok(outcome) = &ended
        && let Err(error) = tell(common, is_taken, outcome, &report.untold())
    {
        ended = Err(error);
    }
    report.end(&ended);
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

/// Makes sure that one thing at most is written to standard output.
fn check_stream(common: &Common, command: &Command) -> Result<(), Error> {
    let (_, outputs) = command.files();
    let all = outputs.iter().map(PathBuf::as_path).chain(common.json.as_deref());
    if all.filter(|path| files::is_stream(path)).count() > 1 {
        let what = "standard output (`-`) is named twice";
        return Err(Error::usage(what, "write one of the results to a file"));
    }
    Ok(())
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
/// `is_taken` says that a result was written to standard output, where nothing else may stand then.
///
/// # Errors
/// If standard output cannot be written for another reason, such as a full disk.
pub(crate) fn tell(
    common: &Common,
    is_taken: bool,
    outcome: &Outcome,
    warnings: &[String],
) -> Result<(), Error> {
    if common.quiet {
        return Ok(());
    }
    let mut stderr = std::io::stderr().lock();
    for warning in warnings {
        let _ = writeln!(stderr, "warning: {warning}");
    }
    if !is_taken && !common.json.as_deref().is_some_and(files::is_stream) {
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

/// Writes the report to a file or, called `-`, to standard output.
pub(crate) fn write_report(path: &Path, report: &Report) -> Result<(), Error> {
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
