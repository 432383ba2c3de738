//! Images and grids as input.

use crate::error::Error;
use crate::files;
use crate::report::Input;
use industrial_geometry::level_set::Image;
use industrial_geometry::level_set::grid_file::GridFile;
use std::path::Path;

/// An image or a grid.
pub(crate) enum Source {
    Image(Image),
    Grid(GridFile),
}

/// Reads an image or a grid.
pub(crate) fn read(path: &Path) -> Result<Source, Error> {
    let bytes = files::read_bytes(path)?;
    if Image::is_image(&bytes) {
        return Image::from_bytes(&bytes).map(Source::Image).map_err(|error| refused(path, &error));
    }
    if GridFile::is_grid(&bytes) {
        return GridFile::from_bytes(&bytes).map(Source::Grid).map_err(|error| refused(path, &error));
    }
    let what = "this is no image (PNG, PGM) and no grid (NPY, VTI)";
    Err(Error::content(path, what, "convert it to one of these first"))
}

impl Source {
    /// The file as an input of a report.
    pub(crate) fn input(&self, path: &Path) -> Input {
        let format = match self {
            Self::Image(_) => "image",
            Self::Grid(_) => "grid",
        };
        Input::of_shapes("file", path, format, 0)
    }
}

/// The error of the library with the file that it is about.
pub(crate) fn refused(path: &Path, error: &industrial_geometry::level_set::Error) -> Error {
    use industrial_geometry::level_set::Error as LevelSet;
    let text = error.to_string();
    match error {
        LevelSet::Option { .. } => Error::usage(text, "see `indgeo contour --help`"),
        LevelSet::Malformed { .. } => Error::content(path, text, "get the whole file again, or save it anew"),
        LevelSet::Level { .. } => Error::content(path, text, "see --level"),
        LevelSet::Field(_) | LevelSet::Mesh(_) => Error::content(path, text, "check it with `indgeo info`"),
        _ => Error::content(path, text, "look at the image or grid with another program"),
    }
}
