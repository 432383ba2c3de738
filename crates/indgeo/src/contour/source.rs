//! Images and grids as input.

use super::{Job, refused};
use crate::error::Error;
use crate::files;
use crate::report::Input;
use industrial_geometry::distance_field::Grid;
use industrial_geometry::level_set::Image;
use industrial_geometry::level_set::grid_file::GridFile;
use industrial_geometry::mesh::nalgebra::SVector;
use std::path::Path;

/// What contours are taken of.
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

/// A grid of the values, in the box that was typed or that of the file.
pub(super) fn level_function<const D: usize>(
    job: &Job<'_>,
    grid: &GridFile,
    level: f64,
) -> Result<Grid<D>, Error> {
    let ends = match job.bounds {
        None => None,
        Some(_) if grid.place.is_some() => {
            let what = "--box has no effect: the file says where its nodes lie";
            return Err(Error::usage(what, "leave it out"));
        }
        Some(bounds) if bounds.len() == 2 * D => {
            Some([0, D].map(|first| SVector::<f64, D>::from_fn(|k, _| bounds[first + k])))
        }
        Some(bounds) => {
            let what = format!("--box has {} numbers, but the grid has {D} axes", bounds.len());
            return Err(Error::usage(what, "give the first node, then the last one"));
        }
    };
    grid.level_function::<D>(level, ends).map_err(|error| refused(job.input, &error))
}

/// Refuses options that mean nothing for an input.
pub(super) fn without_effect(options: &[(bool, &str)], what: &str) -> Result<(), Error> {
    match options.iter().find(|(is_given, _)| *is_given) {
        Some((_, option)) => Err(Error::usage(format!("{option} has no effect on {what}"), "leave it out")),
        None => Ok(()),
    }
}
