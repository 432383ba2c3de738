//! The places of points.

use nalgebra::SVector;

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
