//! Whether the points that count are told apart from the others.

use super::model::Model;
use super::robust::Rule;
use nalgebra::SVector;

/// Share of points above which hardly one is left out.
const NEARLY_ALL: f64 = 0.95;

/// Mean distance, in units of half the size of the cloud, above which points do not lie close to a shape.
const CLOSE: f64 = 0.05;

/// How much less densely points lie beside the zone of those that count than in the middle of it.
const DENSE: f64 = 0.25;

/// Largest distance over the median one of the trimmed: beyond that some outliers were kept.
const TAIL: f64 = 10.0;

/// Distances that rounding leaves.
const ROUNDING: f64 = 1e-10;

/// Whether a robust fit separates two kinds of points.
pub(super) fn is_apart<const D: usize, M: Model<D>>(
    model: &M,
    points: &[SVector<f64, D>],
    used: &[usize],
    rule: Rule,
) -> bool {
    let mut inner: Vec<f64> = used.iter().map(|&i| model.distance_sq(&points[i]).sqrt()).collect();
    inner.sort_by(f64::total_cmp);
    let (Some(&edge), Some(&median)) = (inner.last(), inner.get(inner.len() / 2)) else { return false };
    if edge <= ROUNDING {
        return true;
    }
    if used.len() as f64 > NEARLY_ALL * points.len() as f64 {
        let size = points.iter().map(|x| x.amax()).fold(0.0, f64::max);
        return median <= CLOSE * size;
    }
    if matches!(rule, Rule::Trimmed(_)) && edge > TAIL * median {
        return false;
    }
    // The zone of the inner half and one as wide beyond the edge: volumes grow with the codimension.
    let half = 0.5 * edge;
    let middle = inner.iter().filter(|d| **d <= half).count() as f64;
    let beside = points.iter().map(|x| model.distance_sq(x).sqrt());
    let beside = beside.filter(|d| *d > edge && *d <= edge + half).count() as f64;
    let volume = if M::ROWS == 2 { 5.0 } else { 1.0 };
    beside / volume <= DENSE * middle
}
