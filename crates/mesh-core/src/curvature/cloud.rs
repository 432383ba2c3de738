//! Curvatures of a cloud by local quadrics (\[CP05\]).

use nalgebra::{Point3, Vector3};

use super::quadric;
use super::tensor::CurvatureFrame;
use crate::normals::tangent_plane;
use crate::{CloudIndex, Error};

/// How curvatures of a cloud are estimated.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct CurvatureOptions {
    /// Number of points, the point itself included, to which a quadric is fitted; 24 by default, at least 6.
    ///
    /// More average more noise away, fewer keep more detail.
    pub neighbours: usize,
}

impl Default for CurvatureOptions {
    fn default() -> Self {
        Self { neighbours: 24 }
    }
}

impl CurvatureOptions {
    /// Sets the number of points to which a quadric is fitted, the point itself included.
    #[must_use]
    pub const fn with_neighbours(mut self, neighbours: usize) -> Self {
        self.neighbours = neighbours;
        self
    }
}

/// Estimated principal curvatures of a cloud.
#[derive(Debug, Clone, PartialEq)]
pub struct CloudCurvature {
    /// One frame per point; `None` where the neighbours do not determine a quadric.
    pub frames: Vec<Option<CurvatureFrame>>,
    /// Number of points without a frame.
    pub undefined: usize,
}

/// Estimates normals and principal curvatures of a cloud by fitting a quadratic height function over the tangent plane
/// to the nearest neighbours of every point (\[CP05\]).
///
/// The normals of the result are those of the quadrics, on the side of the given normals; without normals, or where one
/// is zero, the tangent plane is estimated and the side is arbitrary.
///
/// # Errors
/// [`Error::TooFew`] if `neighbours` is less than 6, [`Error::AttributeLength`] if there is not one normal per point,
/// [`Error::TooMany`] beyond 32-bit indices.
pub fn estimate_curvature(
    points: &[Point3<f64>],
    normals: Option<&[Vector3<f64>]>,
    options: &CurvatureOptions,
) -> Result<CloudCurvature, Error> {
    if options.neighbours < 6 {
        return Err(Error::TooFew { what: "neighbours", count: options.neighbours, least: 6 });
    }
    if let Some(normals) = normals.filter(|normals| normals.len() != points.len()) {
        let found = normals.len();
        return Err(Error::AttributeLength { name: "normals".to_owned(), found, expected: points.len() });
    }
    let index = CloudIndex::new(points)?;
    let frames = index.map_nearest_n(points, options.neighbours, |i, near| {
        // The plane of the neighbours is the better base of the quadric; the given normal tells its side.
        let (base, _) = tangent_plane(points, &points[i], near)?;
        let given = normals.map_or(base, |normals| normals[i]);
        let base = if base.dot(&given) < 0.0 { -base } else { base };
        quadric::fit(points, &points[i], near, &base)
    });
    let undefined = frames.iter().filter(|frame| frame.is_none()).count();
    Ok(CloudCurvature { frames, undefined })
}
