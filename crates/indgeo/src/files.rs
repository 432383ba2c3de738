//! Paths of files to be read and written, checked before any work is done.

use crate::error::Error;
use crate::runtime::memory;
use industrial_geometry::io::{
    self, AtomicFile, Content, Format, Loaded, ReadOptions, WriteOptions, WriteReport,
};
use std::collections::BTreeMap;
use std::fs;
use std::io::{BufWriter, ErrorKind, Read, StdoutLock, Write};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

/// The name that stands for standard input and standard output.
const STREAM: &str = "-";

/// Whether a path stands for standard input or standard output.
pub(crate) fn is_stream(path: &Path) -> bool {
    path.as_os_str() == STREAM
}

/// What was read of standard input and of pipes, which can be read once only.
static STREAMS: Mutex<BTreeMap<PathBuf, Arc<Vec<u8>>>> = Mutex::new(BTreeMap::new());

/// Whether a path is one of standard input or of a pipe, which can be read once only.
fn is_read_once(path: &Path) -> bool {
    let is_pipe = || fs::metadata(path).is_ok_and(|metadata| !metadata.is_file() && !metadata.is_dir());
    is_stream(path) || !memory::is_memory(path) && is_pipe()
}

/// All of standard input or of a pipe, kept for whoever asks again; `None` for files.
pub(crate) fn stream(path: &Path) -> Result<Option<Arc<Vec<u8>>>, Error> {
    if !is_read_once(path) {
        return Ok(None);
    }
    let mut known = STREAMS.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some(bytes) = known.get(path) {
        return Ok(Some(Arc::clone(bytes)));
    }
    let mut bytes = Vec::new();
    let read = if is_stream(path) {
        std::io::stdin().lock().read_to_end(&mut bytes).map(|_| bytes)
    } else {
        fs::read(path)
    };
    let failed = |source| io::Error::Io { path: path.to_path_buf(), action: "read", source };
    let bytes = Arc::new(read.map_err(failed)?);
    known.insert(path.to_path_buf(), Arc::clone(&bytes));
    Ok(Some(bytes))
}

/// How messages call a path.
pub(crate) fn spoken(path: &Path) -> &Path {
    if is_stream(path) { Path::new("standard input") } else { path }
}

/// Reads a file, or standard input where it is called `-`.
pub(crate) fn read(path: &Path, options: &ReadOptions) -> Result<Loaded<Content>, Error> {
    if let Some(bytes) = stream(path)? {
        // Points are not kept twice.
        STREAMS.lock().unwrap_or_else(PoisonError::into_inner).remove(path);
        return Ok(io::read_from(bytes.as_slice(), spoken(path), options)?);
    }
    match memory::read(path, |bytes, name| io::read_from(bytes, name, options)) {
        Some(read) => Ok(read?),
        None => Ok(io::read(path, options)?),
    }
}

/// The bytes of a file, or of standard input where it is called `-`.
pub(crate) fn read_bytes(path: &Path) -> Result<Vec<u8>, Error> {
    if let Some(bytes) = memory::read(path, |bytes, _| bytes.to_vec()) {
        return Ok(bytes);
    }
    if let Some(bytes) = stream(path)? {
        return Ok(bytes.as_ref().clone());
    }
    let failed = |source| io::Error::Io { path: path.to_path_buf(), action: "read", source };
    Ok(fs::read(path).map_err(failed)?)
}

/// Reads what the bytes of a file hold.
pub(crate) fn read_from_bytes(
    bytes: &[u8],
    path: &Path,
    options: &ReadOptions,
) -> Result<Loaded<Content>, Error> {
    Ok(io::read_from(bytes, spoken(path), options)?)
}

/// Makes sure that standard input is read once at most.
pub(crate) fn check_inputs(inputs: &[&Path]) -> Result<(), Error> {
    if inputs.iter().filter(|path| is_stream(path)).count() > 1 {
        return Err(Error::usage("standard input (`-`) is named twice", "put one of them into a file"));
    }
    Ok(())
}

/// Writes a file, which appears whole or not at all, or to standard output where it is called `-`; returns the number of
/// bytes.
pub(crate) fn write(
    path: &Path,
    fill: impl FnOnce(&mut dyn Write) -> std::io::Result<()>,
) -> Result<u64, Error> {
    if is_stream(path) {
        return print(fill);
    }
    check_going_on()?;
    if memory::is_memory(path) {
        let mut bytes = Vec::new();
        fill(&mut bytes).map_err(|source| Error::write(path, source))?;
        let count = bytes.len() as u64;
        memory::keep(path, bytes);
        return Ok(count);
    }
    let mut file = AtomicFile::create(path)?;
    fill(&mut file).map_err(|source| Error::write(path, source))?;
    Ok(file.commit()?)
}

/// Makes sure that nobody asked to stop: what is not finished is not written.
fn check_going_on() -> Result<(), Error> {
    if memory::is_cancelled() {
        return Err(Error::usage("cancelled", "nothing was written"));
    }
    Ok(())
}

/// Writes to standard output; returns the number of bytes.
fn print(fill: impl FnOnce(&mut dyn Write) -> std::io::Result<()>) -> Result<u64, Error> {
    let mut out = BufWriter::new(StandardOutput { out: std::io::stdout().lock(), bytes: 0 });
    let failed = |source| Error::write(Path::new("standard output"), source);
    fill(&mut out).and_then(|()| out.flush()).map_err(failed)?;
    Ok(out.get_ref().bytes)
}

/// Standard output, and how much was written. A reader that has seen enough is no error.
struct StandardOutput {
    out: StdoutLock<'static>,
    bytes: u64,
}

impl Write for StandardOutput {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        let count = match self.out.write(bytes) {
            Err(error) if error.kind() == ErrorKind::BrokenPipe => bytes.len(),
            other => other?,
        };
        self.bytes += count as u64;
        Ok(count)
    }

    fn flush(&mut self) -> std::io::Result<()> {
        match self.out.flush() {
            Err(error) if error.kind() == ErrorKind::BrokenPipe => Ok(()),
            other => other,
        }
    }
}

/// Writes points, triangles or shapes, in the format of `options` or of the extension; on standard output (`-`) CSV is the
/// format of points, OBJ that of triangles, and JSON that of shapes, unless `options` say otherwise.
pub(crate) fn write_content(
    path: &Path,
    content: &Content,
    options: &WriteOptions,
) -> Result<WriteReport, Error> {
    if !is_stream(path) && !memory::is_memory(path) {
        check_going_on()?;
        return Ok(io::write(path, content, options)?);
    }
    if memory::is_memory(path) {
        let mut bytes = Vec::new();
        let report = io::write_to(&mut bytes, path, content, options)?;
        memory::keep(path, bytes);
        return Ok(report);
    }
    let usual = match content {
        Content::Cloud(_) => Format::Csv,
        Content::Mesh(_) => Format::Obj,
        Content::Nurbs(_) => Format::Json,
    };
    let options = options.with_format(options.format.unwrap_or(usual));
    let mut out = StandardOutput { out: std::io::stdout().lock(), bytes: 0 };
    Ok(io::write_to(&mut out, "standard output", content, &options)?)
}

/// The format that a file of points, triangles or shapes shall have, as typed.
pub(crate) fn parse_format(text: &str) -> Result<Format, String> {
    Format::from_extension(text)
        .ok_or_else(|| "choose ply, xyz, csv, pts, obj, stl, off, pcd, las, laz, e57, glb or json".to_owned())
}

/// Makes sure that the folder for several results is none of the streams.
pub(crate) fn check_folder(path: &Path) -> Result<(), Error> {
    if is_stream(path) {
        let what = "several files are written, which cannot go to standard output (`-`)";
        return Err(Error::usage(what, "name a folder: -o DIR"));
    }
    Ok(())
}

/// Makes sure that `path` can be written and is none of the inputs, and leaves everything as it was.
pub(crate) fn check_writable(path: &Path, inputs: &[&Path]) -> Result<(), Error> {
    if is_stream(path) || memory::is_memory(path) {
        return Ok(());
    }
    if inputs.iter().any(|input| is_same(path, input)) {
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

/// Whether two paths name the same file, there or not yet. Devices and pipes are never the same.
pub(crate) fn is_same(a: &Path, b: &Path) -> bool {
    let place = |path: &Path| {
        let path = &without_links(path);
        if let Ok(there) = fs::canonicalize(path) {
            return Some(there).filter(|there| there.is_file());
        }
        let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
        Some(fs::canonicalize(folder.unwrap_or(Path::new("."))).ok()?.join(path.file_name()?))
    };
    !is_stream(a) && !is_stream(b) && place(a).is_some_and(|a| place(b).is_some_and(|b| a == b))
}

/// What a path leads to when links whose target is not there yet are followed.
fn without_links(path: &Path) -> PathBuf {
    let mut place = path.to_path_buf();
    // More links in a row are a circle.
    for _ in 0..40 {
        let Ok(target) = fs::read_link(&place) else { break };
        place = place.parent().map_or_else(|| target.clone(), |folder| folder.join(&target));
    }
    place
}

/// The extension in lower case; empty when there is none.
pub(crate) fn extension(path: &Path) -> String {
    path.extension().map(|extension| extension.to_string_lossy().to_ascii_lowercase()).unwrap_or_default()
}
