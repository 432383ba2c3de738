//! Planes and quadrics through the neighbours of points: what a cloud shows of its own shape and noise.

use crate::eigen::Eigen;
use crate::parallel;
use mesh_core::CloudIndex;
use nalgebra::{DMatrix, DVector, Point, SVector};

/// Points of which the noise is estimated.
pub(crate) const SAMPLE: usize = 1500;
/// Neighbours of each per dimension.
const NEIGHBOURS: usize = 4;
/// Squared thickness of a neighbourhood over its squared width up to which it has a normal.
pub(crate) const FLAT: f64 = 0.1;

/// How far points deviate from planes through their neighbours, the median; `None` of too few points.
pub(crate) fn plane_deviation<const D: usize>(points: &[SVector<f64, D>]) -> Option<f64> {
    let step = points.len().div_ceil(SAMPLE).max(1);
    let some: Vec<Point<f64, D>> = points.iter().step_by(step).map(|x| (*x).into()).collect();
    median(planes(&some).iter().map(|plane| plane.deviation).collect())
}

/// How far points deviate from smooth surfaces through their neighbours, after thinning, the median; `None` of too few points.
pub(crate) fn own_noise<const D: usize>(points: &[SVector<f64, D>]) -> Option<f64> {
    let step = points.len().div_ceil(SAMPLE).max(1);
    let some: Vec<Point<f64, D>> = points.iter().step_by(step).map(|x| (*x).into()).collect();
    median(planes(&some).iter().map(|plane| plane.roughness).collect())
}

/// The normals of planes through the neighbours of each point, of either side; 0 where the neighbours are not flat. Empty if there
/// are too few points.
pub(crate) fn plane_normals<const D: usize>(points: &[SVector<f64, D>]) -> Vec<SVector<f64, D>> {
    let points: Vec<Point<f64, D>> = points.iter().map(|x| (*x).into()).collect();
    let normal = |plane: Plane<D>| if plane.is_flat { plane.normal } else { SVector::zeros() };
    planes(&points).into_iter().map(normal).collect()
}

/// The plane through the neighbours of a point (in the plane: the line).
pub(crate) struct Plane<const D: usize> {
    pub(crate) normal: SVector<f64, D>,
    /// Root mean square distance of the neighbours, their degrees of freedom taken into account.
    deviation: f64,
    /// The same from the quadric over the plane.
    pub(crate) roughness: f64,
    /// Whether the neighbours are much wider than they are thick.
    pub(crate) is_flat: bool,
}

/// One plane per point; none if there are too few points.
pub(crate) fn planes<const D: usize>(points: &[Point<f64, D>]) -> Vec<Plane<D>> {
    let count = NEIGHBOURS * D;
    let Some(index) = CloudIndex::new(points).ok().filter(|_| points.len() > count) else {
        return Vec::new();
    };
    parallel::map(points.len(), |k| {
        let near = index.nearest_n(&points[k], count + 1);
        let mean =
            near.iter().map(|n| points[n.index].coords).sum::<SVector<f64, D>>() / near.len().max(1) as f64;
        let mut spread = DMatrix::zeros(D, D);
        for neighbour in &near {
            let offset = points[neighbour.index].coords - mean;
            for i in 0..D {
                for j in 0..D {
                    spread[(i, j)] += offset[i] * offset[j];
                }
            }
        }
        let eigen = Eigen::new(spread);
        let mut order: Vec<usize> = (0..D).collect();
        order.sort_by(|&i, &j| eigen.values[i].total_cmp(&eigen.values[j]));
        let (thin, wide) = (eigen.values[order[0]].max(0.0), eigen.values[order[1]]);
        let deviation = (thin / near.len().saturating_sub(D).max(1) as f64).sqrt();
        let local: Vec<SVector<f64, D>> = near
            .iter()
            .map(|n| {
                let offset = points[n.index].coords - mean;
                SVector::from_fn(|k, _| {
                    (0..D).map(|i| eigen.vectors[(i, order[D - 1 - k])] * offset[i]).sum()
                })
            })
            .collect();
        Plane {
            normal: SVector::from_fn(|i, _| eigen.vectors[(i, order[0])]),
            deviation,
            roughness: roughness(&local).map_or(deviation, |roughness| roughness.min(deviation)),
            is_flat: thin <= FLAT * wide,
        }
    })
}

/// How far points deviate from the quadric over the plane of all coordinates but the last, their degrees of freedom taken into account;
/// `None` where they are too few, or determine none.
fn roughness<const D: usize>(points: &[SVector<f64, D>]) -> Option<f64> {
    let terms = D * (D + 1) / 2;
    let freedom = points.len().checked_sub(terms).filter(|freedom| *freedom > 0)?;
    let width = points.iter().map(|x| x.rows(0, D - 1).norm()).fold(0.0, f64::max);
    let row = |x: &SVector<f64, D>| {
        let mut row = vec![1.0];
        row.extend((0..D - 1).map(|i| x[i] / width));
        for i in 0..D - 1 {
            row.extend((0..=i).map(|j| x[i] * x[j] / (width * width)));
        }
        DVector::from_vec(row)
    };
    let (mut matrix, mut right) = (DMatrix::zeros(terms, terms), DVector::zeros(terms));
    for x in points {
        let row = row(x);
        matrix.ger(1.0, &row, &row, 1.0);
        right.axpy(x[D - 1], &row, 1.0);
    }
    let coefficients = matrix.cholesky()?.solve(&right);
    let squares: f64 = points.iter().map(|x| (x[D - 1] - row(x).dot(&coefficients)).powi(2)).sum();
    Some((squares / freedom as f64).sqrt()).filter(|roughness| roughness.is_finite())
}

pub(crate) fn median(mut values: Vec<f64>) -> Option<f64> {
    let middle = values.len() / 2;
    (!values.is_empty()).then(|| *values.select_nth_unstable_by(middle, f64::total_cmp).1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::start::random::Random;
    use nalgebra::Vector3;

    #[test]
    fn bends_are_no_noise() {
        let mut random = Random::new(5);
        for noise in [0.0, 1e-3] {
            let points: Vec<Point<f64, 3>> = (0..1500)
                .map(|_| {
                    let (x, y) = (random.unit(), random.unit());
                    let z = 0.8 * x * x - 0.5 * x * y + noise * (random.unit() - 0.5) * 12f64.sqrt();
                    Vector3::new(z, x, y).into()
                })
                .collect();
            let planes = planes(&points);
            let of = |value: fn(&Plane<3>) -> f64| median(planes.iter().map(value).collect()).unwrap();
            let (plane, quadric) = (of(|plane| plane.deviation), of(|plane| plane.roughness));
            assert!((quadric - noise).abs() <= 0.25 * noise + 2e-4, "{noise}: {quadric}");
            assert!(plane > quadric, "{plane} {quadric}");
        }
    }
}
