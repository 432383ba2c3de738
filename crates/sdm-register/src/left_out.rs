//! Points that lie off a model: scattered ones, and those that show a surface of their own.

use crate::neighbourhood::median;
use crate::parallel;
use mesh_core::CloudIndex;
use nalgebra::{Point3, Vector3};

/// Points that a point needs around it to be one of a surface, and how far these may be, in distances of neighbours of the cloud.
const NEIGHBOURS: usize = 4;
const NEAR: f64 = 2.5;
/// Points whose neighbours are looked at.
const MEASURED: usize = 600;

/// Which of the points that were left out lie as densely among themselves as the cloud does: those of a surface that is not where
/// the model has one. Outliers that are scattered in space do not.
///
/// `is_out` tells which points were left out; points that are not finite are none of a surface.
#[must_use]
pub fn surface_left_out(points: &[Vector3<f64>], is_out: &[bool]) -> Vec<bool> {
    let mut found = vec![false; points.len()];
    let picked = |out: bool| -> Vec<usize> {
        let all = points.iter().zip(is_out).enumerate();
        let wanted = all.filter(|(_, (x, is_out))| **is_out == out && x.iter().all(|c| c.is_finite()));
        wanted.map(|(i, _)| i).collect()
    };
    let (left_out, kept) = (picked(true), picked(false));
    let places = |of: &[usize]| -> Vec<Point3<f64>> { of.iter().map(|&i| points[i].into()).collect() };
    let (Ok(others), Ok(own)) = (CloudIndex::new(&places(&kept)), CloudIndex::new(&places(&left_out))) else {
        return found;
    };
    // The distance of the fourth neighbour is that of points that lie together twice.
    let reach = |index: &CloudIndex<3>, x: &Vector3<f64>| {
        index.nearest_n(&(*x).into(), NEIGHBOURS + 1).get(NEIGHBOURS).map(mesh_core::Neighbour::distance)
    };
    let step = kept.len().div_ceil(MEASURED).max(1);
    let some: Vec<usize> = kept.iter().copied().step_by(step).collect();
    let spacings = parallel::map(some.len(), |k| reach(&others, &points[some[k]]));
    let Some(spacing) = median(spacings.into_iter().flatten().collect()) else { return found };
    let dense = parallel::map(left_out.len(), |k| {
        reach(&own, &points[left_out[k]]).is_some_and(|distance| distance <= NEAR * spacing)
    });
    for (&i, dense) in left_out.iter().zip(dense) {
        found[i] = dense;
    }
    found
}
