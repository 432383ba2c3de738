//! Several files that appear together in a folder, or not at all.

use crate::error::Error;
use industrial_geometry::io;
use std::fs;
use std::path::{Path, PathBuf};

/// A folder inside the target in which files wait until all of them are there.
///
/// Without [`Staging::commit`] nothing is left behind, the target itself included if it was made for this.
#[derive(Debug)]
pub(crate) struct Staging {
    target: PathBuf,
    waiting: io::Unfinished,
    made_target: bool,
    names: Vec<PathBuf>,
    done: bool,
}

impl Staging {
    /// Makes the folder, and the target if it is not there.
    pub(crate) fn new(target: &Path) -> Result<Self, Error> {
        let failed = |path: &Path, source| create_error(path, source);
        let made_target = !target.is_dir();
        if made_target {
            fs::create_dir_all(target).map_err(|source| failed(target, source))?;
        }
        let waiting = io::Unfinished::new(target.join(format!(".indgeo-{}.tmp", std::process::id())));
        let out = Self { target: target.to_path_buf(), waiting, made_target, names: Vec::new(), done: false };
        fs::create_dir(out.waiting.path()).map_err(|source| failed(out.waiting.path(), source))?;
        Ok(out)
    }

    /// Where a file that is to become `target` waits.
    pub(crate) fn path(&mut self, target: &Path) -> PathBuf {
        let name = PathBuf::from(target.file_name().unwrap_or_default());
        let path = self.waiting.path().join(&name);
        self.names.push(name);
        path
    }

    /// Puts all files in their places.
    pub(crate) fn commit(mut self) -> Result<(), Error> {
        for name in &self.names {
            let place = self.target.join(name);
            fs::rename(self.waiting.path().join(name), &place)
                .map_err(|source| Error::write(&place, source))?;
        }
        self.done = true;
        Ok(())
    }
}

impl Drop for Staging {
    fn drop(&mut self) {
        // Nothing is left to be done about a failure here.
        let _ = fs::remove_dir_all(self.waiting.path());
        if self.made_target && !self.done {
            let _ = fs::remove_dir(&self.target);
        }
    }
}

/// A folder that cannot be made.
pub(crate) fn create_error(path: &Path, source: std::io::Error) -> Error {
    Error::File { source: io::Error::Io { path: path.to_path_buf(), action: "create", source } }
}
