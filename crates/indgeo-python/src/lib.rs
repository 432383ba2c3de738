//! The native half of the Python package `indgeo`: commands on files in memory, and jets of shapes on arrays.
//!
//! The other half, with everything that a user of Python sees, is in the folder `python`: it turns arrays and keyword arguments
//! into a command line and files in memory, and the report and the files that come back into arrays and data classes.
//!
//! ```python
//! from indgeo import _indgeo
//!
//! exit_code, report, summary, warnings, error, outputs = _indgeo.call(["info", "scan.ply"], {})
//! ```

mod calls;
mod shapes;

use pyo3::prelude::*;

/// The module `indgeo._indgeo`.
#[pymodule]
fn _indgeo(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add_function(wrap_pyfunction!(calls::call, module)?)?;
    module.add_class::<shapes::Curve>()?;
    module.add_class::<shapes::Surface>()?;
    Ok(())
}
