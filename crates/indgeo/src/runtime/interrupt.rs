//! The end of a program that is told to stop: nothing half-written stays, and the report (`--json`) says `cancelled`.

use crate::report::Report;
use crate::report::write::write_report;
use industrial_geometry::io::remove_unfinished;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError, TryLockError};
use std::time::{Duration, Instant};

/// Exit status of a program that was interrupted, by whatever signal: 128 and the number of SIGINT.
pub(crate) const INTERRUPTED: u8 = 130;
/// How long the handler waits for a command that is writing its last words.
const PATIENCE: Duration = Duration::from_secs(1);

/// What the report would say if the program had to stop now, and where it would say so.
#[derive(Debug)]
pub(crate) struct Running {
    json: Option<PathBuf>,
    report: Report,
}

static RUNNING: Mutex<Option<Running>> = Mutex::new(None);

fn running() -> MutexGuard<'static, Option<Running>> {
    // The state is whole whatever a thread that panicked was doing.
    RUNNING.lock().unwrap_or_else(PoisonError::into_inner)
}

/// From now on an interrupt writes a report.
pub(crate) fn watch(json: Option<&Path>, report: &Report) {
    *running() = Some(Running { json: json.map(Path::to_path_buf), report: report.so_far() });
}

/// What is known by now, for the report of an interrupt.
pub(crate) fn note(report: &Report) {
    // Not of a part of the work that has a report of its own.
    if let Some(running) = running().as_mut().filter(|running| running.report.command == report.command) {
        running.report = report.so_far();
    }
}

/// The command has ended: an interrupt comes too late while this is held, and its report is not written over.
pub(crate) fn too_late() -> MutexGuard<'static, Option<Running>> {
    running()
}

/// Ends the program when the user or the system asks for it.
pub(crate) fn handle() {
    let asked = Instant::now();
    let mut written = 0;
    // A command that has ended holds the lock until the process is gone, unless nobody reads what it writes.
    let held = loop {
        match RUNNING.try_lock() {
            Ok(guard) => break Some(guard),
            Err(TryLockError::Poisoned(error)) => break Some(error.into_inner()),
            Err(TryLockError::WouldBlock) if asked.elapsed() < PATIENCE => {
                std::thread::sleep(Duration::from_millis(5));
            }
            Err(TryLockError::WouldBlock) => break None,
        }
    };
    if let Some(Running { json, report }) = held.as_ref().and_then(|guard| guard.as_ref()) {
        written = report.outputs.len();
        let report = Report { status: "cancelled", exit_code: INTERRUPTED, ..report.so_far() };
        if let Some(path) = json
            && let Err(error) = write_report(path, &report)
        {
            let _ = writeln!(std::io::stderr(), "error: {error}");
        }
    }
    remove_unfinished();
    let _ = match written {
        0 => writeln!(std::io::stderr(), "interrupted: no output was written"),
        1 => writeln!(std::io::stderr(), "interrupted: 1 output was written before"),
        _ => writeln!(std::io::stderr(), "interrupted: {written} outputs were written before"),
    };
    std::process::exit(INTERRUPTED.into());
}
