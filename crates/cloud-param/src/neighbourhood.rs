//! A cloud prepared for neighbours, with its typical spacing.

use crate::{Error, parallel};
use mesh_core::CloudIndex;
use nalgebra::{Point3, Vector3};

/// Points whose nearest neighbours give the spacing.
const SAMPLE: usize = 2000;
/// Points, itself included, around each of these that give the density.
const DENSITY: usize = 13;

/// A cloud in which neighbours are found.
#[derive(Clone, Debug)]
pub struct Neighbourhood {
    points: Vec<Vector3<f64>>,
    index: CloudIndex<3>,
    spacing: f64,
    pitch: f64,
    middle: Vector3<f64>,
    radius: f64,
}

impl Neighbourhood {
    /// Prepares a cloud; points that are not finite have no place in it.
    ///
    /// # Errors
    /// [`Error::TooFewPoints`] for fewer than two different finite points.
    pub fn new(points: &[Vector3<f64>]) -> Result<Self, Error> {
        let points: Vec<Vector3<f64>> =
            points.iter().filter(|p| p.iter().all(|c| c.is_finite())).copied().collect();
        let positions: Vec<Point3<f64>> = points.iter().map(|&p| p.into()).collect();
        let index = CloudIndex::new(&positions)?;
        let step = points.len().div_ceil(SAMPLE).max(1);
        let sampled: Vec<usize> = (0..points.len()).step_by(step).collect();
        let nearest = parallel::map(sampled.len(), |k| {
            let near = index.nearest_n(&positions[sampled[k]], DENSITY);
            let first = near.iter().map(|n| n.distance()).find(|&d| d > 0.0);
            first.zip(near.last().map(|n| n.distance()))
        });
        let median = |values: &mut dyn Iterator<Item = f64>| {
            let mut values: Vec<f64> = values.collect();
            values.sort_by(f64::total_cmp);
            values.get(values.len() / 2).copied()
        };
        let spacing = median(&mut nearest.iter().flatten().map(|&(first, _)| first));
        let wide = median(&mut nearest.iter().flatten().map(|&(_, last)| last));
        let (Some(spacing), Some(wide)) = (spacing, wide) else {
            return Err(Error::TooFewPoints { total: points.len(), usable: points.len().min(1), needed: 2 });
        };
        // A circle around a point holds as many others as its area says; the outermost counts half.
        let pitch = wide * (std::f64::consts::PI / (DENSITY as f64 - 1.5)).sqrt();
        let middle = points.iter().sum::<Vector3<f64>>() / points.len() as f64;
        let radius = points.iter().map(|p| (p - middle).norm()).fold(0.0, f64::max);
        Ok(Self { points, index, spacing, pitch, middle, radius })
    }

    /// The finite points.
    #[must_use]
    pub fn points(&self) -> &[Vector3<f64>] {
        &self.points
    }

    /// Median distance of a point from its nearest neighbour.
    #[must_use]
    pub fn spacing(&self) -> f64 {
        self.spacing
    }

    /// The `count` nearest points, nearest first, with their distances.
    pub fn nearest(&self, x: &Vector3<f64>, count: usize) -> impl Iterator<Item = (Vector3<f64>, f64)> + '_ {
        self.index.nearest_n(&(*x).into(), count).into_iter().map(|n| (self.points[n.index], n.distance()))
    }

    /// Indices of the `count` nearest points among the finite ones, with their distances.
    pub(crate) fn nearest_indices(&self, x: &Vector3<f64>, count: usize) -> Vec<(usize, f64)> {
        self.index.nearest_n(&(*x).into(), count).into_iter().map(|n| (n.index, n.distance())).collect()
    }

    /// Distance from the nearest point.
    #[must_use]
    pub fn distance(&self, x: &Vector3<f64>) -> f64 {
        self.index.nearest(&(*x).into()).map_or(f64::INFINITY, |n| n.distance())
    }

    /// Side of the square that a point has to itself on a surface: the spacing of a regular grid of the same density.
    #[must_use]
    pub fn pitch(&self) -> f64 {
        self.pitch
    }

    /// A distance that no point exceeds.
    pub(crate) fn reach(&self, x: &Vector3<f64>) -> f64 {
        (x - self.middle).norm() + self.radius
    }

    /// Root mean square of the distances of places from their nearest points.
    #[must_use]
    pub fn rms(&self, places: &[Vector3<f64>]) -> f64 {
        let squares = parallel::map(places.len(), |i| self.distance(&places[i]).powi(2));
        (squares.iter().sum::<f64>() / places.len().max(1) as f64).sqrt()
    }
}
