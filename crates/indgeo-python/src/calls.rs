//! Commands called from Python.

use indgeo::{Called, ErrorKind, Watch};
use numpy::IntoPyArray;
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use pyo3::pybacked::PyBackedBytes;
use pyo3::types::PyDict;
use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::mpsc::{RecvTimeoutError, sync_channel};
use std::time::Duration;

/// How often the interpreter is asked whether the user interrupts, and is told how far the work is.
const PULSE: Duration = Duration::from_millis(50);

/// The exit code, the report as JSON, the summary, the warnings, the error with its kind (`"file"` or `"value"`), the outputs as
/// arrays of bytes.
type Ended<'py> = (u8, String, String, Vec<String>, Option<(&'static str, String)>, Bound<'py, PyDict>);

/// Runs a command line without printing.
///
/// Names that begin with a NUL stand for `inputs` in memory, which are not copied, and for outputs that come back. The interpreter
/// is free meanwhile; an interrupt asks the command to stop and is raised when it has. `progress` is called with a text, a count and
/// a total.
#[pyfunction]
#[pyo3(signature = (arguments, inputs, progress=None))]
pub(crate) fn call<'py>(
    python: Python<'py>,
    arguments: Vec<String>,
    inputs: BTreeMap<String, PyBackedBytes>,
    progress: Option<Py<PyAny>>,
) -> PyResult<Ended<'py>> {
    let watch = Arc::new(Watch::default());
    // The receiver learns at once when the command has ended, or broke down.
    let (sender, mut receiver) = sync_channel(1);
    let worker = {
        let watch = Arc::clone(&watch);
        std::thread::Builder::new()
            .name("indgeo".to_owned())
            .spawn(move || {
                // The receiver lives until then.
                let _ = sender.send(indgeo::call(&arguments, inputs, &watch));
            })
            .map_err(|error| PyRuntimeError::new_err(format!("cannot start a thread: {error}")))?
    };
    let mut interrupted = None;
    let called = loop {
        let received;
        (receiver, received) = python.detach(move || {
            let received = receiver.recv_timeout(PULSE);
            (receiver, received)
        });
        match received {
            Ok(called) => break Some(called),
            Err(RecvTimeoutError::Disconnected) => break None,
            Err(RecvTimeoutError::Timeout) => {}
        }
        let told = python.check_signals().and_then(|()| tell(python, progress.as_ref(), &watch));
        if let Err(error) = told {
            watch.cancel();
            interrupted.get_or_insert(error);
        }
    };
    // The inputs belong to the interpreter again when this returns.
    let joined = python.detach(|| worker.join());
    match (interrupted, called, joined) {
        (Some(error), ..) => Err(error),
        (None, Some(called), Ok(())) => of_call(python, called),
        _ => Err(PyRuntimeError::new_err("the command broke down; please report it")),
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
        outputs.set_item(name, bytes.into_pyarray(python))?;
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
