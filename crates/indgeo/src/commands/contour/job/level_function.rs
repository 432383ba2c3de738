//! The level function of a grid that was read.

use super::Job;
use crate::error::Error;
use crate::input::image_or_grid::refused;
use industrial_geometry::distance_field::Grid;
use industrial_geometry::level_set::grid_file::GridFile;
use industrial_geometry::mesh::nalgebra::SVector;

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
