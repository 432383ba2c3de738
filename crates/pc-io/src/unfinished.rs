//! Files and folders that must not stay when the work on them is broken off, by an error or by a signal.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// All that would have to be removed now.
static UNFINISHED: Mutex<BTreeSet<PathBuf>> = Mutex::new(BTreeSet::new());

fn all() -> MutexGuard<'static, BTreeSet<PathBuf>> {
    // The set is whole whatever a thread that panicked was doing.
    UNFINISHED.lock().unwrap_or_else(PoisonError::into_inner)
}

/// A file or folder that is removed, with all that is in it, when this is dropped, unless it is [kept](Unfinished::keep).
///
/// A program that is told to stop does not drop anything; it calls [`remove_unfinished`] first.
///
/// ```
/// use pc_io::{Unfinished, remove_unfinished};
///
/// let dir = tempfile::tempdir()?;
/// let path = dir.path().join("half.txt");
/// let unfinished = Unfinished::new(path.clone());
/// std::fs::write(&path, "half of")?;
/// remove_unfinished();
/// assert!(!path.exists());
/// # drop(unfinished);
/// # Ok::<(), std::io::Error>(())
/// ```
#[derive(Debug)]
pub struct Unfinished {
    path: PathBuf,
    kept: bool,
}

impl Unfinished {
    /// To be called before the file or folder is made, so that there is no moment at which it would stay.
    #[must_use]
    pub fn new(path: PathBuf) -> Self {
        all().insert(path.clone());
        Self { path, kept: false }
    }

    /// The file or folder.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The work is done: what is at the path by now stays.
    pub fn keep(mut self) {
        self.kept = true;
    }
}

impl Drop for Unfinished {
    fn drop(&mut self) {
        all().remove(&self.path);
        if !self.kept {
            remove(&self.path);
        }
    }
}

/// Removes everything that is [unfinished](Unfinished) in this process, such as the temporary files of
/// [`AtomicFile`](crate::AtomicFile): to be called before the process ends without dropping its values.
pub fn remove_unfinished() {
    // The lock is kept, so that no other thread makes a new one before the process has ended.
    let all = all();
    all.iter().rev().for_each(|path| remove(path));
}

/// Nothing is left to be done about a failure here.
fn remove(path: &Path) {
    if path.is_dir() {
        let _ = fs::remove_dir_all(path);
    } else {
        let _ = fs::remove_file(path);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn is_removed_unless_kept() {
        let dir = tempfile::tempdir().unwrap();
        let path = |name: &str| dir.path().join(name);
        for name in ["dropped", "kept"] {
            let unfinished = Unfinished::new(path(name));
            fs::create_dir(unfinished.path()).unwrap();
            fs::write(unfinished.path().join("inside"), "text").unwrap();
            assert!(all().contains(&path(name)));
            if name == "kept" {
                unfinished.keep();
            } else {
                drop(unfinished);
            }
            assert!(!all().contains(&path(name)));
        }
        assert!(!path("dropped").exists() && path("kept").join("inside").exists());
    }
}
