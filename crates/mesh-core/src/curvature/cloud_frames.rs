//! Frames of the surface that a cloud samples, sides included, in one walk over the neighbourhoods.

use nalgebra::{Point3, Vector3};

use super::quadric;
use super::tensor::{CurvatureFrame, tangents};
use crate::normals::{GRAPH_DEGREE, links, propagate, tangent_plane};
use crate::{CloudIndex, Error, Neighbour};

/// How the frames of a cloud are estimated.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FrameOptions {
    /// Number of points, the point itself included, to which a plane and a quadric are fitted; 24 by default, at least 6.
    pub neighbours: usize,
    /// Number of points that are looked at, which may be more; 24 by default.
    pub looked_at: usize,
    /// Whether curvatures are estimated (default), or planes alone.
    pub curvature: bool,
}

impl Default for FrameOptions {
    fn default() -> Self {
        Self { neighbours: 24, looked_at: 24, curvature: true }
    }
}

/// Estimates normals and principal curvatures of a cloud as [`estimate_normals`](crate::estimate_normals), with consistent
/// sides, and [`estimate_curvature`](crate::estimate_curvature) do one after the other, but asks for the neighbours once.
///
/// `index` is that of `points`. Given normals tell the sides, and are the normals of the frames if no curvature is
/// estimated. `look(i, neighbours, frame)` sees the `looked_at` neighbours of every point, nearest first, and its frame, of which the
/// side is not settled yet; what it returns is returned in order. A frame is flat where the neighbours determine a plane but
/// no quadric, and missing where they lie on a line.
///
/// # Errors
/// [`Error::TooFew`] if `neighbours` is less than 6, [`Error::AttributeLength`] if there is not one normal per point.
pub fn estimate_frames<T: Send>(
    index: &CloudIndex<3>,
    points: &[Point3<f64>],
    normals: Option<&[Vector3<f64>]>,
    options: &FrameOptions,
    look: impl Fn(usize, &[Neighbour], Option<&CurvatureFrame>) -> T + Sync,
) -> Result<(Vec<Option<CurvatureFrame>>, Vec<T>), Error> {
    if options.neighbours < 6 {
        return Err(Error::TooFew { what: "neighbours", count: options.neighbours, least: 6 });
    }
    if let Some(normals) = normals.filter(|normals| normals.len() != points.len()) {
        let found = normals.len();
        return Err(Error::AttributeLength { name: "normals".to_owned(), found, expected: points.len() });
    }
    let degree = if normals.is_none() { GRAPH_DEGREE } else { 0 };
    let seen = index.map_nearest_n(points, options.neighbours.max(options.looked_at), |i, near| {
        let given = normals.map(|normals| &normals[i]);
        let fitted = &near[..near.len().min(options.neighbours)];
        let frame = frame_of(points, i, fitted, given, options.curvature);
        let looked = look(i, near, frame.as_ref());
        (frame, looked, links(i, near, degree))
    });
    let mut lists = Vec::with_capacity(seen.len());
    let (mut frames, mut looked) = (Vec::with_capacity(seen.len()), Vec::with_capacity(seen.len()));
    for (frame, value, list) in seen {
        frames.push(frame);
        looked.push(value);
        lists.push(list);
    }
    if normals.is_none() {
        let sides = |frame: &Option<CurvatureFrame>| frame.map_or_else(Vector3::zeros, |frame| frame.normal);
        let mut normals: Vec<_> = frames.iter().map(sides).collect();
        propagate(points, |i| &lists[i], &mut normals);
        for (frame, normal) in
            frames.iter_mut().flatten().zip(normals.iter().filter(|n| **n != Vector3::zeros()))
        {
            if frame.normal.dot(normal) < 0.0 {
                *frame = frame.flipped();
            }
        }
    }
    Ok((frames, looked))
}

/// The frame of one point, on the side of the given normal if there is one.
fn frame_of(
    points: &[Point3<f64>],
    i: usize,
    near: &[Neighbour],
    given: Option<&Vector3<f64>>,
    curvature: bool,
) -> Option<CurvatureFrame> {
    if !curvature && let Some(given) = given {
        return flat(given);
    }
    // The plane of the neighbours is the better base of the quadric; the given normal tells its side.
    let Some((base, _)) = tangent_plane(points, &points[i], near) else { return given.and_then(flat) };
    let base = if given.is_some_and(|given| base.dot(given) < 0.0) { -base } else { base };
    let fitted = if curvature { quadric::fit(points, &points[i], near, &base) } else { None };
    fitted.or_else(|| flat(given.unwrap_or(&base)))
}

/// A frame without curvature; `None` for a normal without direction.
fn flat(normal: &Vector3<f64>) -> Option<CurvatureFrame> {
    let normal = normal.try_normalize(f64::MIN_POSITIVE).filter(|n| n.iter().all(|c| c.is_finite()))?;
    Some(CurvatureFrame { normal, curvatures: [0.0; 2], directions: tangents(&normal)? })
}
