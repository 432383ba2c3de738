//! Files that appear whole or not at all.

use std::fs::{self, File, OpenOptions};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};

use crate::{Error, Unfinished};

/// Size of the buffer in bytes.
const BUFFER: usize = 1 << 18;

/// Writes to a temporary file beside the target and puts it in the target's place at the end.
///
/// Until [`AtomicFile::commit`] the target stays as it was; without it the temporary file is removed, as it is by
/// [`remove_unfinished`](crate::remove_unfinished). A target that is
/// no ordinary file, such as a pipe or `/dev/null`, is written directly. A symbolic link stays one: what it points to
/// is replaced. Permissions of a replaced file are kept.
///
/// ```
/// use std::io::Write;
///
/// let dir = tempfile::tempdir()?;
/// let path = dir.path().join("report.txt");
/// let mut file = pc_io::AtomicFile::create(&path)?;
/// file.write_all(b"done")?;
/// assert!(!path.exists());
/// file.commit()?;
/// assert_eq!(std::fs::read(&path)?, b"done");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct AtomicFile {
    /// The path as given, for messages.
    path: PathBuf,
    writer: BufWriter<File>,
    /// The temporary file, which is closed before it is removed, and what it is to replace; `None` where the target is written
    /// directly.
    pending: Option<(Unfinished, PathBuf)>,
    written: u64,
}

impl AtomicFile {
    /// Opens the temporary file.
    ///
    /// # Errors
    /// [`Error::Io`] if the folder does not exist or cannot be written to.
    pub fn create(path: impl AsRef<Path>) -> Result<Self, Error> {
        let path = path.as_ref().to_path_buf();
        let failed = |source| Error::Io { path: path.clone(), action: "create", source };
        let existing = fs::metadata(&path).ok();
        if existing.as_ref().is_some_and(fs::Metadata::is_dir) {
            return Err(failed(io::Error::from(io::ErrorKind::IsADirectory)));
        }
        if existing.as_ref().is_some_and(|metadata| !metadata.is_file()) {
            let file = OpenOptions::new().write(true).open(&path).map_err(failed)?;
            let writer = BufWriter::with_capacity(BUFFER, file);
            return Ok(Self { path, pending: None, writer, written: 0 });
        }
        let target = if existing.is_some() { fs::canonicalize(&path).map_err(failed)? } else { path.clone() };
        let (temporary, file) = open_beside(&target).map_err(failed)?;
        let writer = BufWriter::with_capacity(BUFFER, file);
        if let Some(metadata) = existing {
            fs::set_permissions(temporary.path(), metadata.permissions()).map_err(failed)?;
        }
        Ok(Self { path: path.clone(), pending: Some((temporary, target)), writer, written: 0 })
    }

    /// Puts the file in its place and returns its size in bytes.
    ///
    /// # Errors
    /// [`Error::Io`] if the last bytes cannot be written or the target cannot be replaced; it is then as it was.
    pub fn commit(mut self) -> Result<u64, Error> {
        let failed = |action, path: &Path| {
            let path = path.to_path_buf();
            move |source| Error::Io { path, action, source }
        };
        self.writer.flush().map_err(failed("write", &self.path))?;
        if let Some((temporary, target)) = self.pending.take() {
            fs::rename(temporary.path(), target).map_err(failed("replace", &self.path))?;
            temporary.keep();
        }
        Ok(self.written)
    }

    /// The path of the target as it was given.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }
}

impl Write for AtomicFile {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let count = self.writer.write(bytes)?;
        self.written += count as u64;
        Ok(count)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.writer.flush()
    }
}

/// Creates a file with a name that no other file has, in the folder of `target`.
fn open_beside(target: &Path) -> io::Result<(Unfinished, File)> {
    static COUNTER: AtomicU64 = AtomicU64::new(0);
    let name = target.file_name().ok_or(io::ErrorKind::InvalidInput)?.to_string_lossy();
    let short: String = name.chars().take(64).collect();
    loop {
        let number = COUNTER.fetch_add(1, Ordering::Relaxed);
        let temporary = target.with_file_name(format!(".{short}.{}-{number}.tmp", std::process::id()));
        let temporary = Unfinished::new(temporary);
        match OpenOptions::new().write(true).create_new(true).open(temporary.path()) {
            // It is that of another process.
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists => temporary.keep(),
            other => return other.map(|file| (temporary, file)),
        }
    }
}
