//! Files of points that a command line names, one by one or by their folder.

use crate::error::Error;
use crate::files;
use industrial_geometry::io::{self, Format};
use std::fs;
use std::path::{Path, PathBuf};

/// The files, those of a folder in its place: all with the extension of a format of points, by their names.
pub(crate) fn expand(paths: &[PathBuf]) -> Result<Vec<PathBuf>, Error> {
    let mut all = Vec::new();
    for path in paths {
        if files::is_stream(path) || !path.is_dir() {
            all.push(path.clone());
        } else {
            all.extend(of_folder(path)?);
        }
    }
    Ok(all)
}

fn of_folder(folder: &Path) -> Result<Vec<PathBuf>, Error> {
    let failed = |source| Error::from(io::Error::Io { path: folder.to_path_buf(), action: "read", source });
    let mut found = Vec::new();
    for entry in fs::read_dir(folder).map_err(failed)? {
        let path = entry.map_err(failed)?.path();
        let is_hidden = path.file_name().is_some_and(|name| name.to_string_lossy().starts_with('.'));
        let format = Format::from_extension(&files::extension(&path));
        let has_points = format.is_some_and(|format| !matches!(format, Format::Json | Format::Glb));
        if has_points && !is_hidden && path.is_file() {
            found.push(path);
        }
    }
    found.sort_unstable();
    if found.is_empty() {
        let what = "the folder holds no scans: no file with an extension such as .ply, .laz, .e57 or .xyz";
        return Err(Error::content(folder, what, "name the folder of the scans, or the files"));
    }
    Ok(found)
}
