//! The places of points.

use distance_field::quantile_in_place;
use nalgebra::SVector;

/// Distance from the middle, in units of what nine tenths of the points do not exceed, beyond which a point is astray.
const ASTRAY: f64 = 1e3;

/// Number of different places.
pub(super) fn count_distinct<const D: usize>(points: &[SVector<f64, D>], kept: &[usize]) -> usize {
    let mut order = kept.to_vec();
    let compare = |&a: &usize, &b: &usize| {
        let pairs = points[a].iter().zip(points[b].iter());
        pairs.map(|(x, y)| x.total_cmp(y)).find(|o| o.is_ne()).unwrap_or(std::cmp::Ordering::Equal)
    };
    order.sort_by(compare);
    order.dedup_by(|a, b| points[*a] == points[*b]);
    order.len()
}

/// Centre of the box around the points that count.
pub(super) fn centre<const D: usize>(points: &[SVector<f64, D>], kept: &[usize]) -> SVector<f64, D> {
    let mut low = SVector::<f64, D>::repeat(f64::INFINITY);
    let mut high = -low;
    for &i in kept {
        low = low.inf(&points[i]);
        high = high.sup(&points[i]);
    }
    low * 0.5 + high * 0.5
}

/// The points that count without those that are so far away that the others are one place beside them, and these.
pub(super) fn without_astray<const D: usize>(
    points: &[SVector<f64, D>],
    kept: Vec<usize>,
) -> (Vec<usize>, Vec<usize>) {
    let middle = SVector::<f64, D>::from_fn(|c, _| {
        quantile_in_place(&mut kept.iter().map(|&i| points[i][c]).collect::<Vec<_>>(), 0.5)
    });
    // The largest coordinate: squares may overflow.
    let reach = |i: usize| (points[i] - middle).amax();
    let usual = quantile_in_place(&mut kept.iter().map(|&i| reach(i)).collect::<Vec<_>>(), 0.9);
    if usual.is_nan() || usual <= 0.0 {
        return (kept, Vec::new());
    }
    kept.into_iter().partition(|&i| reach(i) <= ASTRAY * usual)
}

/// The length of a vector whose squares may overflow.
pub(super) fn length<const D: usize>(v: &SVector<f64, D>) -> f64 {
    let size = v.amax();
    if size > 0.0 && size.is_finite() { (v / size).norm() * size } else { size }
}
