//! Normals of a cloud by principal components of the neighbours ([HDDMS92, sec. 3.1]).

use nalgebra::{Point3, Vector3};

use super::{links, orient_towards, propagate, tangent_plane};
use crate::{CloudIndex, Error};

/// Most neighbours through which orientations propagate.
pub(crate) const GRAPH_DEGREE: usize = 10;

/// Which of the two sides of the surface the normals of a cloud point to.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Orientation {
    /// Either, at random.
    Any,
    /// One side, the outside of closed shapes: see [`crate::orient_consistently`].
    #[default]
    Consistent,
    /// The side from which the point, such as the scanner, sees the surface.
    Towards(Point3<f64>),
}

/// How normals of a cloud are estimated.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NormalOptions {
    /// Number of points, the point itself included, through which the tangent plane is laid; 16 by default.
    ///
    /// More average more noise away, fewer keep more detail.
    pub neighbours: usize,
    /// To which side the normals point.
    pub orientation: Orientation,
}

impl Default for NormalOptions {
    fn default() -> Self {
        Self { neighbours: 16, orientation: Orientation::default() }
    }
}

impl NormalOptions {
    /// Sets the number of points of a tangent plane, the point itself included.
    #[must_use]
    pub const fn with_neighbours(mut self, neighbours: usize) -> Self {
        self.neighbours = neighbours;
        self
    }

    /// Sets the side to which the normals point.
    #[must_use]
    pub const fn with_orientation(mut self, orientation: Orientation) -> Self {
        self.orientation = orientation;
        self
    }
}

/// Estimated normals of a cloud.
#[derive(Debug, Clone, PartialEq)]
pub struct CloudNormals {
    /// Unit normals, one per point; zero where there is none.
    pub normals: Vec<Vector3<f64>>,
    /// Share of the variance of the neighbours that is along the normal, 0 (a plane) to 1/3 (no surface at all);
    /// 1/3 where there is no normal.
    pub variations: Vec<f64>,
    /// Number of points without a normal: not finite themselves, fewer than three neighbours, all on a line.
    pub undefined: usize,
    /// Number of pieces that were oriented on their own, 0 if orientation was not propagated.
    pub components: usize,
}

/// Estimates the normals of a cloud from the nearest neighbours of its points.
///
/// A normal is the direction in which the neighbours vary least ([HDDMS92, sec. 3.1]); its error is of the order of the
/// size of the neighbourhood times the curvature where the neighbours lie to one side, and of the square inside.
///
/// ```
/// use mesh_core::{NormalOptions, Orientation, estimate_normals, nalgebra::{Point3, Vector3}};
///
/// let grid: Vec<_> = (0..100u8).map(|i| Point3::new(f64::from(i % 10), f64::from(i / 10), 5.0)).collect();
/// let options = NormalOptions::default().with_orientation(Orientation::Towards(Point3::origin()));
/// let estimate = estimate_normals(&grid, &options)?;
/// assert!(estimate.normals.iter().all(|n| (n + Vector3::z()).norm() < 1e-14));
/// # Ok::<(), mesh_core::Error>(())
/// ```
///
/// # Errors
/// [`Error::TooFew`] if `neighbours` is less than 3, [`Error::TooMany`] beyond 32-bit indices.
pub fn estimate_normals(points: &[Point3<f64>], options: &NormalOptions) -> Result<CloudNormals, Error> {
    if options.neighbours < 3 {
        return Err(Error::TooFew { what: "neighbours", count: options.neighbours, least: 3 });
    }
    let index = CloudIndex::new(points)?;
    let degree = if options.orientation == Orientation::Consistent { GRAPH_DEGREE } else { 0 };
    let planes = index.map_nearest_n(points, options.neighbours, |i, near| {
        let plane = tangent_plane(points, &points[i], near).unwrap_or((Vector3::zeros(), 1.0 / 3.0));
        (plane, links(i, near, degree))
    });
    let mut normals: Vec<_> = planes.iter().map(|((normal, _), _)| *normal).collect();
    let variations = planes.iter().map(|((_, variation), _)| *variation).collect();
    let mut components = 0;
    match options.orientation {
        Orientation::Any => {}
        Orientation::Consistent => {
            components = propagate(points, |i| &planes[i].1, &mut normals);
        }
        Orientation::Towards(view_point) => orient_towards(points, &mut normals, &view_point)?,
    }
    let undefined = normals.iter().filter(|&&normal| normal == Vector3::zeros()).count();
    Ok(CloudNormals { normals, variations, undefined, components })
}
