//! The views of a registration: files, and the scans of files that hold several (E57, PTX).

use crate::error::Error;
use industrial_geometry::io::{self, Format, ReadOptions};
use std::ffi::OsString;
use std::fs::{self, File};
use std::io::Read;
use std::path::{Path, PathBuf};

/// A view: a file, or one scan of it.
#[derive(Clone, Debug)]
pub(crate) struct ViewFile {
    /// The file.
    pub(crate) path: PathBuf,
    /// The scan, by its number from 0 on, of a file of several.
    pub(crate) scan: Option<usize>,
    /// Whether the file says where the scanner stood.
    pub(crate) is_posed: bool,
    /// Name of the file of the moved view.
    pub(crate) name: OsString,
}

/// The views that files hold; the scans of a file of several are views of their own.
pub(crate) fn of(paths: &[PathBuf]) -> Result<Vec<ViewFile>, Error> {
    let mut all = Vec::new();
    for path in paths {
        let name = path.file_name().unwrap_or_default().to_owned();
        let scans = scans(path)?;
        if scans.len() < 2 {
            all.push(ViewFile { path: path.clone(), scan: None, is_posed: false, name });
            continue;
        }
        let stem = path.file_stem().unwrap_or_default();
        // PTX is not written.
        let extension = if is_e57(path) { "e57" } else { "ply" };
        for (number, is_posed) in scans {
            let mut name = stem.to_owned();
            name.push(format!("-{number}.{extension}"));
            all.push(ViewFile { path: path.clone(), scan: Some(number), is_posed, name });
        }
    }
    Ok(all)
}

/// The numbers of the scans with points of a file that can hold several, and whether they have poses; none of other files.
fn scans(path: &Path) -> Result<Vec<(usize, bool)>, Error> {
    if !is_e57(path) && Format::from_path(path) != Some(Format::Ptx) {
        return Ok(Vec::new());
    }
    let read = io::read_pieces(path, &ReadOptions::default(), 1 << 16, |_| Ok::<(), Error>(()))?;
    let scans = read.map(|read| read.scans).unwrap_or_default();
    Ok(scans.iter().filter(|scan| scan.points > 0).map(|scan| (scan.number, scan.pose.is_some())).collect())
}

fn is_e57(path: &Path) -> bool {
    let mut head = Vec::new();
    // Opening a pipe waits for its writer.
    fs::metadata(path).is_ok_and(|file| file.is_file())
        && File::open(path).is_ok_and(|file| file.take(8).read_to_end(&mut head).is_ok())
        && head == b"ASTM-E57"
}
