//! A grid of values as a model: its level set 0.

use crate::error::Error;
use crate::files;
use crate::input::image_or_grid::{self, Source, refused};
use industrial_geometry::distance_field::LevelSetField;
use industrial_geometry::io::{Format, ReadReport};
use industrial_geometry::level_set;
use industrial_geometry::level_set::surface::{dual_contour, of_field};
use industrial_geometry::mesh::TriangleMesh;
use std::path::Path;

/// The level set 0 of values on a grid.
#[derive(Debug)]
pub(crate) enum LevelSet {
    /// In the plane.
    Plane(Box<LevelSetField<2>>),
    /// In space.
    Space(Box<LevelSetField<3>>),
}

/// Whether a file is one of a grid, by its name.
pub(crate) fn is_grid(path: &Path) -> bool {
    matches!(files::extension(path).as_str(), "vti" | "npy")
}

/// The level set 0 of a field in space as a mesh, by dual contouring.
pub(crate) fn mesh(path: &Path) -> Result<TriangleMesh, Error> {
    match read(path)?.0 {
        LevelSet::Space(field) => {
            dual_contour(field.grid(), of_field(&field)).map_err(|error| refused(path, &error))
        }
        LevelSet::Plane(_) => Err(Error::content(path, "the field lies in the plane", "give one in space")),
    }
}

/// Reads values on a grid that says where its nodes lie.
pub(crate) fn read(path: &Path) -> Result<(LevelSet, ReadReport), Error> {
    let Source::Grid(grid) = image_or_grid::read(path)? else {
        let advice = "give the grid of a field (.vti)";
        return Err(Error::content(path, "this is an image, not a grid", advice));
    };
    if grid.place.is_none() {
        let what = "an NPY file does not say where its nodes lie";
        let advice = "write the field as .vti (`indgeo field SHAPE -o FIELD.vti`)";
        return Err(Error::content(path, what, advice));
    }
    let failed = |error: level_set::Error| refused(path, &error);
    let found = if grid.counts.len() == 2 {
        let function = grid.level_function::<2>(0.0, None).map_err(failed)?;
        LevelSetField::<2>::new(&function).map(|field| LevelSet::Plane(Box::new(field)))
    } else {
        let function = grid.level_function::<3>(0.0, None).map_err(failed)?;
        LevelSetField::<3>::new(&function).map(|field| LevelSet::Space(Box::new(field)))
    };
    let report = ReadReport {
        path: Some(path.to_path_buf()),
        // Not looked at: the format of a grid is its own.
        format: Format::Json,
        points: 0,
        triangles: 0,
        shapes: 1,
        non_finite: 0,
        dropped: 0,
        scans: Vec::new(),
        warnings: Vec::new(),
    };
    let without_zero = |error: industrial_geometry::distance_field::Error| match error {
        industrial_geometry::distance_field::Error::NoPoints { count } => Error::content(
            path,
            format!("its {count} values have one sign: there is no level set 0"),
            "write distances with a sign (`indgeo field --signed`)",
        ),
        other => failed(other.into()),
    };
    Ok((found.map_err(without_zero)?, report))
}
