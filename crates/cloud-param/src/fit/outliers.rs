//! Points that agree with their neighbours, and outliers that do not.

use super::SurfaceFit;
use crate::{Error, parallel};
use footpoint::SurfaceFootpoint;
use mesh_core::CloudIndex;
use nalgebra::{Point3, Vector3};

/// Neighbours with which the distance of a point is compared.
const NEIGHBOURS: usize = 16;
/// Neighbour whose distance tells how dense points are, and by how much more than usual it may be off.
const DENSITY: usize = 6;
const APART: f64 = 4.0;
/// How many standard deviations of these differences a point may be off (Tukey's biweight gives no weight beyond).
const OFF: f64 = 4.685;
/// Median of the absolute value of a normal distribution.
const MEDIAN: f64 = 0.674_489_75;
/// Least standard deviation, as a share of the size: that of decimals in files.
const DECIMALS: f64 = 1e-6;

/// Which of the points that count agree with their neighbours: the signed distance of a point from a surface differs from the median of
/// the points whose feet are around its own by no more than such differences usually do, and it is not much farther from its neighbours than
/// others are.
///
/// A surface that does not resolve a detail, or that outliers have bent, is off for neighbours alike: unlike distances by themselves,
/// these differences tell outliers apart before the surface is right.
///
/// # Errors
/// [`Error::Option`] unless there is a foot for each point.
pub fn consistent(
    points: &[Vector3<f64>],
    feet: &[SurfaceFootpoint],
    counts: &[bool],
) -> Result<Vec<bool>, Error> {
    for (name, found) in [("feet", feet.len()), ("counts", counts.len())] {
        if found != points.len() {
            return Err(Error::Option { name, value: found as f64, allowed: "one for each point" });
        }
    }
    let counts = &crowded(points, counts)?;
    let usable = |i: &usize| counts[*i] && feet[*i].status.is_converged() && feet[*i].distance.is_finite();
    let used: Vec<usize> = (0..points.len()).filter(usable).collect();
    let places: Vec<Point3<f64>> = used.iter().map(|&i| feet[i].point.into()).collect();
    let index = CloudIndex::new(&places)?;
    let off = parallel::map(used.len(), |k| {
        let mut around: Vec<f64> = index
            .nearest_n(&places[k], NEIGHBOURS + 1)
            .iter()
            .filter(|n| n.index != k)
            .map(|n| feet[used[n.index]].signed_distance)
            .collect();
        around.sort_unstable_by(f64::total_cmp);
        let middle = around.get(around.len() / 2).copied().unwrap_or(0.0);
        (feet[used[k]].signed_distance - middle).abs()
    });
    let mut sorted = off.clone();
    sorted.sort_unstable_by(f64::total_cmp);
    let size = used.iter().map(|&i| (points[i] - points[used[0]]).amax()).fold(0.0, f64::max);
    let sigma = sorted.get(sorted.len() / 2).map_or(0.0, |median| median / MEDIAN).max(DECIMALS * size);
    let mut agree = counts.to_vec();
    for (&i, off) in used.iter().zip(off) {
        agree[i] = off <= OFF * sigma;
    }
    Ok(agree)
}

/// The points that count without those whose neighbours are much farther away than usual.
///
/// # Errors
/// [`Error::Cloud`] for more points than can be numbered.
pub fn crowded(points: &[Vector3<f64>], counts: &[bool]) -> Result<Vec<bool>, Error> {
    let used: Vec<usize> = (0..points.len()).filter(|&i| counts[i]).collect();
    let places: Vec<Point3<f64>> = used.iter().map(|&i| points[i].into()).collect();
    let index = CloudIndex::new(&places)?;
    let distances = parallel::map(used.len(), |k| {
        index.nearest_n(&places[k], DENSITY).last().map_or(0.0, |n| n.distance())
    });
    let mut sorted = distances.clone();
    sorted.sort_unstable_by(f64::total_cmp);
    let limit = sorted.get(sorted.len() / 2).map_or(0.0, |median| APART * median);
    let mut near = counts.to_vec();
    for (&i, distance) in used.iter().zip(distances) {
        near[i] = distance <= limit || limit == 0.0;
    }
    Ok(near)
}

impl SurfaceFit {
    /// Which points agree with their neighbours, by their distances from this surface; see [`consistent`].
    ///
    /// # Errors
    /// As [`consistent`].
    pub fn consistent(&self, points: &[Vector3<f64>], counts: &[bool]) -> Result<Vec<bool>, Error> {
        consistent(points, &self.feet, counts)
    }
}
