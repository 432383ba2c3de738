//! From arguments to an exit status: runs a command, prints its summary, warnings and errors, writes its report.

use crate::args::{Cli, Command};
use crate::common::Common;
use crate::error::Error;
use crate::report::write::{print, write_report};
use crate::report::{self, Report};
use crate::runtime::{interrupt, threads};
use crate::{commands, files};
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
    report::observe(interrupt::note);
    interrupt::watch(common.json.as_deref(), &report);
    let mut ended =
        threads::with_threads(common.threads, || commands::run(&cli.command, common, &mut report));
    // What follows is the end of the command, which an interrupt does not change any more.
    let _ended = interrupt::too_late();
    let is_taken = cli.command.files().1.iter().any(|path| files::is_stream(path));
    if let Ok(outcome) = &ended
        && let Err(error) = print(common, is_taken, outcome, &report.untold())
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
