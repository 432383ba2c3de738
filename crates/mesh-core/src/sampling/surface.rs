//! Points spread over the surface of a mesh.

use nalgebra::{Point3, Vector3};

use super::eliminate_samples;
use crate::bounds::is_finite;
use crate::random::SplitMix64;
use crate::{Error, TriangleMesh};

/// Candidates per point that is kept, as recommended in [Yu15, sec. 4].
const CANDIDATES: usize = 5;

/// A point on a mesh.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SurfaceSample {
    /// The point.
    pub point: Point3<f64>,
    /// Index of the triangle on which it lies.
    pub triangle: usize,
    /// Weights of the triangle's corners: not negative, their sum is 1 up to rounding.
    pub barycentric: [f64; 3],
}

/// `count` points on a mesh, independent of each other, each part of the surface as likely as its area says.
///
/// The same seed gives the same points. Triangles with a vertex that is not finite get none.
///
/// # Errors
/// [`Error::NoArea`] if there is no triangle with area to put points on.
pub fn sample_uniform(mesh: &TriangleMesh, count: usize, seed: u64) -> Result<Vec<SurfaceSample>, Error> {
    let areas = Areas::of(mesh)?;
    let mut random = SplitMix64::new(seed);
    Ok((0..count).map(|_| areas.sample(mesh, &mut random)).collect())
}

/// `count` points on a mesh that keep as far from each other as so many can (a Poisson disk distribution).
///
/// Five times as many points are sampled uniformly, and those that crowd their neighbours most are eliminated one after
/// the other (\[Yu15\]). The same seed gives the same points, in the order in which they were sampled.
///
/// # Errors
/// [`Error::NoArea`] if there is no triangle with area to put points on, [`Error::TooMany`] beyond 32-bit indices.
pub fn sample_poisson_disk(
    mesh: &TriangleMesh,
    count: usize,
    seed: u64,
) -> Result<Vec<SurfaceSample>, Error> {
    let candidates = sample_uniform(mesh, count.saturating_mul(CANDIDATES), seed)?;
    let points: Vec<_> = candidates.iter().map(|sample| sample.point).collect();
    let kept = eliminate_samples(&points, count, Areas::of(mesh)?.total())?;
    Ok(kept.into_iter().map(|index| candidates[index]).collect())
}

/// Triangles count as wide from this many times the area that a vertex has to itself on average: four times the mean triangle.
const WIDE: f64 = 2.0;
/// What the vertices of a triangle supply to it already, in vertices.
const SUPPLIED: f64 = 0.5;

/// Points on the triangles of a mesh that are much larger than others, so that together with the vertices no part of the surface
/// is much emptier than the mesh is on average. Meshes that were thinned out where they are nearly flat get many, even ones none.
///
/// A triangle more than four times as large as the mean one gets as many points as vertices share its area elsewhere, in the order
/// of the triangles. The same seed gives the same points.
///
/// # Errors
/// [`Error::NoArea`] if there is no triangle with area to put points on.
pub fn sample_wide_triangles(mesh: &TriangleMesh, seed: u64) -> Result<Vec<SurfaceSample>, Error> {
    let areas = Areas::of(mesh)?;
    let mut random = SplitMix64::new(seed);
    let own = areas.total() / mesh.vertices().len() as f64;
    let mut samples = Vec::new();
    for (triangle, area) in areas.each().enumerate().filter(|(_, area)| *area > WIDE * own) {
        let wanted = area / own - SUPPLIED + random.unit();
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "at most the number of vertices"
        )]
        let count = wanted as usize;
        samples.extend((0..count).map(|_| sample_in(mesh, triangle, &mut random)));
    }
    Ok(samples)
}

/// A point of a triangle, each part of it as likely as its area says.
fn sample_in(mesh: &TriangleMesh, triangle: usize, random: &mut SplitMix64) -> SurfaceSample {
    // The root spreads the rows from the first corner by their lengths.
    let (row, along) = (random.unit().sqrt(), random.unit());
    let barycentric = [1.0 - row, row * (1.0 - along), row * along];
    let [a, b, c] = mesh.positions_of(&mesh.triangles()[triangle]);
    let point = a + (b - a) * barycentric[1] + (c - a) * barycentric[2];
    SurfaceSample { point, triangle, barycentric }
}

/// Sums of the areas of the triangles up to each.
struct Areas {
    sums: Vec<f64>,
}

impl Areas {
    fn of(mesh: &TriangleMesh) -> Result<Self, Error> {
        let mut sum = 0.0;
        let sums: Vec<f64> = (mesh.triangles().iter().zip(mesh.area_vectors()))
            .map(|(indices, vector): (_, Vector3<f64>)| {
                let finite = mesh.positions_of(indices).iter().all(is_finite);
                let area = 0.5 * vector.norm();
                if finite && area.is_finite() {
                    sum += area;
                }
                sum
            })
            .collect();
        if sum > 0.0 && sum.is_finite() {
            Ok(Self { sums })
        } else {
            Err(Error::NoArea { triangles: mesh.triangles().len() })
        }
    }

    fn total(&self) -> f64 {
        self.sums.last().copied().unwrap_or(0.0)
    }

    /// The areas one by one.
    fn each(&self) -> impl Iterator<Item = f64> + '_ {
        (0..self.sums.len()).map(|k| self.sums[k] - if k == 0 { 0.0 } else { self.sums[k - 1] })
    }

    fn sample(&self, mesh: &TriangleMesh, random: &mut SplitMix64) -> SurfaceSample {
        // The first triangle whose sum exceeds the number has an area of its own.
        let at = random.unit() * self.total();
        let triangle = self.sums.partition_point(|&sum| sum <= at).min(self.sums.len() - 1);
        sample_in(mesh, triangle, random)
    }
}
