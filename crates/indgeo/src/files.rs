//! Paths of files to be written, checked before any work is done.

use crate::error::Error;
use industrial_geometry::io::AtomicFile;
use std::fs;
use std::path::Path;

/// Makes sure that `path` can be written and is none of the inputs, and leaves everything as it was.
pub(crate) fn check_writable(path: &Path, inputs: &[&Path]) -> Result<(), Error> {
    if let Ok(target) = fs::canonicalize(path)
        && inputs.iter().any(|input| fs::canonicalize(input).is_ok_and(|input| input == target))
    {
        return Err(Error::content(
            path,
            "this would overwrite an input",
            "choose another name for the output",
        ));
    }
    // Opening a target that is no ordinary file has effects (a pipe waits for its reader), so this is left to the writer.
    let is_special = fs::metadata(path).is_ok_and(|metadata| !metadata.is_file() && !metadata.is_dir());
    if !is_special {
        drop(AtomicFile::create(path)?);
    }
    Ok(())
}

/// The extension in lower case; empty when there is none.
pub(crate) fn extension(path: &Path) -> String {
    path.extension().map(|extension| extension.to_string_lossy().to_ascii_lowercase()).unwrap_or_default()
}
