//! Points that agree with their neighbours, and outliers that do not.

use super::SurfaceFit;
use crate::{Error, parallel};
use footpoint::SurfaceFootpoint;
use mesh_core::CloudIndex;
use nalgebra::{Point3, Vector3};

/// Neighbours with which the distance of a point is compared.
const NEIGHBOURS: usize = 16;
/// Neighbours whose distances tell how dense points are, and by how much more than usual each may be off.
const DENSITY: [usize; 2] = [1, 6];
const APART: f64 = 4.0;
/// How many standard deviations of these differences a point may be off (Tukey's biweight gives no weight beyond).
const OFF: f64 = 4.685;
/// Median of the absolute value of a normal distribution.
const MEDIAN: f64 = 0.674_489_75;
/// Least standard deviation, as a share of the size: that of decimals in files.
const DECIMALS: f64 = 1e-6;
/// Distance of the sixth neighbour of evenly scattered points in units of the side of the square that each has to itself.
const SIXTH: f64 = 1.38;
/// Nearest neighbours that tell how far the surface is from the points somewhere, and what that is in units of the standard deviation of all
/// distances from which on the surface does not resolve what is there: three of six that are so far off are no noise.
const NEAREST: usize = 6;
const UNRESOLVED: f64 = 5.0;

/// Which of the points that count agree with their neighbours: the signed distance of a point from a surface differs from the median of
/// the points whose feet are around its own by no more than such differences usually do, there or elsewhere, and it is not much farther from its
/// neighbours than others are.
///
/// A surface that does not resolve a detail, or that outliers have bent, is off for neighbours alike: unlike distances by themselves,
/// these differences tell outliers apart before the surface is right. Differences up to `harmless` times the distance between neighbouring points
/// tell nothing: where a rough surface is bent less than points without noise, these are off by more at corners than elsewhere.
///
/// # Errors
/// [`Error::Option`] unless there is a foot for each point.
pub fn consistent(
    points: &[Vector3<f64>],
    feet: &[SurfaceFootpoint],
    counts: &[bool],
    harmless: f64,
) -> Result<Vec<bool>, Error> {
    let counts = &crowded(points, counts)?;
    let around = Around::new(points, feet, counts)?;
    let sigma = around.sigma(points, |k| around.off[k]);
    let mut agree = counts.clone();
    for (k, &i) in around.used.iter().enumerate() {
        let usual = OFF * sigma.max(around.spread[k].min(around.spacing));
        agree[i] = around.off[k] <= usual.max(harmless * around.spacing);
    }
    Ok(agree)
}

/// How far a surface is from points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Resolution {
    /// Standard deviation of the distances: that of all points by their median, or, where the surface is much farther from points that are next to each
    /// other, the one there, at most the distance between neighbours.
    ///
    /// A robust kernel of a smaller scale gives no weight to regions that the surface does not resolve yet, and it never will.
    pub sigma: f64,
    /// Whether it is the latter.
    pub unresolved: bool,
    /// Distance between neighbouring points: side of the square that each has to itself.
    pub spacing: f64,
}

/// How far a surface is from the points that count, by their feet.
///
/// # Errors
/// As [`consistent`].
pub fn resolution(
    points: &[Vector3<f64>],
    feet: &[SurfaceFootpoint],
    counts: &[bool],
) -> Result<Resolution, Error> {
    let around = Around::new(points, feet, counts)?;
    let sigma = around.sigma(points, |k| feet[around.used[k]].distance);
    let largest = around.level.iter().copied().fold(0.0, f64::max).min(around.spacing);
    let unresolved = largest > UNRESOLVED * sigma;
    Ok(Resolution { sigma: if unresolved { largest } else { sigma }, unresolved, spacing: around.spacing })
}

/// Points beside those whose feet are around theirs.
struct Around {
    used: Vec<usize>,
    /// Difference of the signed distance from the median of the neighbours.
    off: Vec<f64>,
    /// Standard deviations of these differences among the neighbours, and of the distances among the nearest, by their medians.
    spread: Vec<f64>,
    level: Vec<f64>,
    /// Side of the square that a point has to itself.
    spacing: f64,
}

impl Around {
    fn new(points: &[Vector3<f64>], feet: &[SurfaceFootpoint], counts: &[bool]) -> Result<Self, Error> {
        for (name, found) in [("feet", feet.len()), ("counts", counts.len())] {
            if found != points.len() {
                return Err(Error::Option { name, value: found as f64, allowed: "one for each point" });
            }
        }
        let usable =
            |i: &usize| counts[*i] && feet[*i].status.is_converged() && feet[*i].distance.is_finite();
        let used: Vec<usize> = (0..points.len()).filter(usable).collect();
        let places: Vec<Point3<f64>> = used.iter().map(|&i| feet[i].point.into()).collect();
        let index = CloudIndex::new(&places)?;
        let neighbours = parallel::map(used.len(), |k| {
            let near = index.nearest_n(&places[k], NEIGHBOURS + 1);
            let around: Vec<usize> = near.iter().map(|n| n.index).filter(|j| *j != k).collect();
            let distances = around.iter().map(|&j| feet[used[j]].signed_distance).collect();
            let nearest = around.iter().take(NEAREST);
            let level = median(nearest.map(|&j| feet[used[j]].distance).collect()) / MEDIAN;
            ((feet[used[k]].signed_distance - median(distances)).abs(), level)
        });
        let (off, level): (Vec<f64>, Vec<f64>) = neighbours.into_iter().unzip();
        let spread = parallel::map(used.len(), |k| {
            let near = index.nearest_n(&places[k], NEIGHBOURS + 1);
            median(near.iter().map(|n| n.index).filter(|j| *j != k).map(|j| off[j]).collect()) / MEDIAN
        });
        let spacing = median(neighbour_distances(points, &used, DENSITY[1])?) / SIXTH;
        Ok(Self { used, off, spread, level, spacing })
    }

    /// The standard deviation of numbers of the points by their median, at least that of decimals.
    fn sigma(&self, points: &[Vector3<f64>], number: impl Fn(usize) -> f64) -> f64 {
        let first = self.used.first().map_or_else(Vector3::zeros, |&i| points[i]);
        let size = self.used.iter().map(|&i| (points[i] - first).amax()).fold(0.0, f64::max);
        (median((0..self.used.len()).map(number).collect()) / MEDIAN).max(DECIMALS * size)
    }
}

/// The upper median, 0 of nothing.
fn median(mut numbers: Vec<f64>) -> f64 {
    let middle = numbers.len() / 2;
    if numbers.is_empty() { 0.0 } else { *numbers.select_nth_unstable_by(middle, f64::total_cmp).1 }
}

/// Distances of some points from their neighbours of a number.
fn neighbour_distances(points: &[Vector3<f64>], used: &[usize], neighbour: usize) -> Result<Vec<f64>, Error> {
    let places: Vec<Point3<f64>> = used.iter().map(|&i| points[i].into()).collect();
    let index = CloudIndex::new(&places)?;
    Ok(parallel::map(used.len(), |k| {
        index.nearest_n(&places[k], neighbour + 1).last().map_or(0.0, |n| n.distance())
    }))
}

/// The points that count without those whose neighbours are much farther away than usual.
///
/// # Errors
/// [`Error::Cloud`] for more points than can be numbered.
pub fn crowded(points: &[Vector3<f64>], counts: &[bool]) -> Result<Vec<bool>, Error> {
    let used: Vec<usize> = (0..points.len()).filter(|&i| counts[i]).collect();
    let mut near = counts.to_vec();
    for neighbour in DENSITY {
        let distances = neighbour_distances(points, &used, neighbour)?;
        let limit = APART * median(distances.clone());
        for (&i, distance) in used.iter().zip(distances) {
            near[i] &= distance <= limit || limit == 0.0;
        }
    }
    Ok(near)
}

impl SurfaceFit {
    /// Which points agree with their neighbours, by their distances from this surface; see [`consistent`].
    ///
    /// # Errors
    /// As [`consistent`].
    pub fn consistent(
        &self,
        points: &[Vector3<f64>],
        counts: &[bool],
        harmless: f64,
    ) -> Result<Vec<bool>, Error> {
        consistent(points, &self.feet, counts, harmless)
    }

    /// How far this surface is from the points that count; see [`resolution`].
    ///
    /// # Errors
    /// As [`consistent`].
    pub fn resolution(&self, points: &[Vector3<f64>], counts: &[bool]) -> Result<Resolution, Error> {
        resolution(points, &self.feet, counts)
    }
}
