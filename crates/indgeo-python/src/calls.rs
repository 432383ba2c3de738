//! Commands called from Python.

use indgeo::{Called, ErrorKind, Watch};
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};
use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::Duration;

/// How often the interpreter is asked whether the user interrupts, and is told how far the work is.
const PULSE: Duration = Duration::from_millis(50);

/// The exit code, the report as JSON, the summary, the warnings, the error with its kind (`"file"` or `"value"`), the outputs.
type Ended<'py> = (u8, String, String, Vec<String>, Option<(&'static str, String)>, Bound<'py, PyDict>);

/// Runs a command line without printing.
///
/// Names that begin with a NUL stand for `inputs` in memory and for outputs that come back. The interpreter is free meanwhile;
/// an interrupt asks the command to stop and is raised when it has. `progress` is called with a text, a count and a total.
#[pyfunction]
#[pyo3(signature = (arguments, inputs, progress=None))]
pub(crate) fn call<'py>(
    python: Python<'py>,
    arguments: Vec<String>,
    inputs: BTreeMap<String, Vec<u8>>,
    progress: Option<Py<PyAny>>,
) -> PyResult<Ended<'py>> {
    let watch = Arc::new(Watch::default());
    let worker = {
        let watch = Arc::clone(&watch);
        std::thread::Builder::new()
            .name("indgeo".to_owned())
            .spawn(move || indgeo::call(&arguments, inputs, &watch))
            .map_err(|error| PyRuntimeError::new_err(format!("cannot start a thread: {error}")))?
    };
    let mut interrupted = None;
    while !worker.is_finished() {
        python.detach(|| wait(&worker));
        let told = python.check_signals().and_then(|()| tell(python, progress.as_ref(), &watch));
        if let Err(error) = told {
            watch.cancel();
            interrupted.get_or_insert(error);
        }
    }
    let called = python.detach(|| worker.join());
    let called = called.map_err(|_| PyRuntimeError::new_err("the command broke down; please report it"))?;
    match interrupted {
        Some(error) => Err(error),
        None => Ok(of_call(python, called)?),
    }
}

/// Waits for the end of a thread, at most for a pulse.
fn wait(worker: &std::thread::JoinHandle<Called>) {
    // Short commands are not made to wait for a whole pulse.
    let mut pause = Duration::from_micros(50);
    let mut waited = Duration::ZERO;
    while !worker.is_finished() && waited < PULSE {
        std::thread::sleep(pause);
        waited += pause;
        pause = (pause * 2).min(PULSE / 10);
    }
}

fn tell(python: Python<'_>, progress: Option<&Py<PyAny>>, watch: &Watch) -> PyResult<()> {
    if let Some(progress) = progress {
        progress.call1(python, watch.progress())?;
    }
    Ok(())
}

fn of_call(python: Python<'_>, called: Called) -> PyResult<Ended<'_>> {
    let outputs = PyDict::new(python);
    for (name, bytes) in called.outputs {
        outputs.set_item(name, PyBytes::new(python, &bytes))?;
    }
    let error = called.error.map(|(kind, message)| {
        let kind = match kind {
            ErrorKind::File => "file",
            ErrorKind::Value => "value",
        };
        (kind, message)
    });
    Ok((called.exit_code, called.report, called.summary, called.warnings, error, outputs))
}
