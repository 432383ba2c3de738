//! The vertex of a sheet in a cell.

use super::Crossing;
use nalgebra::{Matrix3, SymmetricEigen, Vector3};

/// Eigenvalue, as a share of the largest, below which the tangent planes say nothing about a direction.
const FLAT: f64 = 0.05;

/// Where the tangent planes at some crossings meet best: `min Σ ⟨n, x − p⟩²`, along directions that these leave open the mean of the
/// crossings. Kept within the cell.
pub(super) fn vertex(crossings: &[Crossing], low: &Vector3<f64>, high: &Vector3<f64>) -> Vector3<f64> {
    let mean = crossings.iter().map(|c| c.point).sum::<Vector3<f64>>() / crossings.len().max(1) as f64;
    let (mut matrix, mut right) = (Matrix3::zeros(), Vector3::zeros());
    for crossing in crossings.iter().filter(|c| c.normal.iter().all(|n| n.is_finite())) {
        matrix += crossing.normal * crossing.normal.transpose();
        right += crossing.normal * crossing.normal.dot(&(crossing.point - mean));
    }
    let eigen = SymmetricEigen::new(matrix);
    let largest = eigen.eigenvalues.amax();
    let mut offset = Vector3::zeros();
    for k in 0..3 {
        if eigen.eigenvalues[k] > FLAT * largest {
            let axis = eigen.eigenvectors.column(k);
            offset += axis * (axis.dot(&right) / eigen.eigenvalues[k]);
        }
    }
    let place = mean + offset;
    if place.iter().all(|c| c.is_finite()) { place.sup(low).inf(high) } else { mean }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn planes_meet_where_they_must() {
        let crossing = |point: [f64; 3], normal: [f64; 3]| Crossing {
            point: Vector3::from(point),
            normal: Vector3::from(normal),
        };
        let (low, high) = (Vector3::zeros(), Vector3::repeat(1.0));
        // The edge x = 0.3, y = 0.4, and the corner at z = 0.2.
        let mut all = vec![
            crossing([0.3, 0.0, 0.1], [1.0, 0.0, 0.0]),
            crossing([0.3, 0.0, 0.9], [1.0, 0.0, 0.0]),
            crossing([0.0, 0.4, 0.5], [0.0, 1.0, 0.0]),
        ];
        let edge = vertex(&all, &low, &high);
        assert!((edge - Vector3::new(0.3, 0.4, 0.5)).norm() < 1e-14, "{edge}");
        all.push(crossing([0.9, 0.9, 0.2], [0.0, 0.0, 1.0]));
        assert!((vertex(&all, &low, &high) - Vector3::new(0.3, 0.4, 0.2)).norm() < 1e-14);
        // On a plane it is the mean.
        let flat = [crossing([0.1, 0.2, 0.5], [0.0, 0.0, 1.0]), crossing([0.5, 0.6, 0.5], [0.0, 0.0, 1.0])];
        assert!((vertex(&flat, &low, &high) - Vector3::new(0.3, 0.4, 0.5)).norm() < 1e-14);
    }
}
