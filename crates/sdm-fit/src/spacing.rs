//! How far apart data points are.

use crate::Error;
use mesh_core::CloudIndex;
use nalgebra::{Point3, Vector3};
use std::f64::consts::PI;

/// Points, itself included, around one whose spacing is taken; those of which the typical one is taken.
const AROUND: usize = 13;
const SAMPLE: usize = 4000;

/// Points without those that are equal to an earlier one, in their order.
pub(crate) fn distinct(points: &[Vector3<f64>]) -> Vec<Vector3<f64>> {
    let mut order: Vec<usize> = (0..points.len()).collect();
    order.sort_unstable_by(|&i, &j| {
        let (a, b) = (points[i], points[j]);
        a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)).then(a.z.total_cmp(&b.z)).then(i.cmp(&j))
    });
    let mut first = vec![true; points.len()];
    for pair in order.windows(2) {
        first[pair[1]] = points[pair[0]] != points[pair[1]];
    }
    points.iter().zip(first).filter(|(_, first)| *first).map(|(p, _)| *p).collect()
}

/// Points of a surface with their spacing: the side of the square that a point has to itself.
#[derive(Clone, Debug)]
pub(crate) struct LocalSpacing {
    points: Vec<Point3<f64>>,
    index: CloudIndex<3>,
    typical: f64,
}

impl LocalSpacing {
    /// Of different points.
    ///
    /// # Errors
    /// [`Error::TooFewPoints`] for fewer than two.
    pub(crate) fn new(points: &[Vector3<f64>]) -> Result<Self, Error> {
        let points: Vec<Point3<f64>> = points.iter().map(|p| Point3::from(*p)).collect();
        if points.len() < 2 {
            return Err(Error::TooFewPoints { total: points.len(), finite: points.len(), needed: 2 });
        }
        let index = CloudIndex::new(&points)?;
        let mut found = Self { points, index, typical: 0.0 };
        let step = found.points.len().div_ceil(SAMPLE).max(1);
        let sampled: Vec<usize> = (0..found.points.len()).step_by(step).collect();
        let mut spacings = crate::parallel::tasks(sampled.len(), |k| found.around(sampled[k]));
        spacings.sort_unstable_by(f64::total_cmp);
        found.typical = spacings[spacings.len() / 2];
        Ok(found)
    }

    pub(crate) fn index(&self) -> &CloudIndex<3> {
        &self.index
    }

    /// The median.
    pub(crate) fn typical(&self) -> f64 {
        self.typical
    }

    /// Around one point: a circle holds as many others as its area says, of which the outermost counts half.
    pub(crate) fn around(&self, point: usize) -> f64 {
        let near = self.index.nearest_n(&self.points[point], AROUND);
        let others = near.len().saturating_sub(1).max(1) as f64;
        near.last().map_or(0.0, |n| n.distance()) * (PI / (others - 0.5)).sqrt()
    }
}
