//! Whether distances from a carrier vary systematically over a region.

use nalgebra::{DMatrix, DVector, Point3};

use crate::carrier::Carrier;
use crate::least_squares::mean;

/// Share of the variance of the noise that a trend may have: what remains of borders and of noise that is not Gaussian.
const ALLOWED: f64 = 0.06;

/// Whether polynomials of degree 3 (of degree 2 for few points) in the position explain more of the distances than noise would:
/// their sum of squares over `σ²` exceeds the number of coefficients by 4 standard deviations and an allowance.
pub(crate) fn is_systematic(carrier: &Carrier, points: &[Point3<f64>], sigma: f64) -> bool {
    has_trend(carrier, points, sigma, ALLOWED)
}

/// The same with another share of the variance that a trend may have.
pub(crate) fn has_trend(carrier: &Carrier, points: &[Point3<f64>], sigma: f64, allowed: f64) -> bool {
    let feet = points.iter().map(|p| {
        let (distance, normal) = carrier.at(p);
        (distance / sigma, p - normal * distance)
    });
    trend_exceeds(&feet.collect::<Vec<_>>(), allowed)
}

/// Whether distances, in standard deviations, have a trend over their feet.
pub(crate) fn trend_exceeds(feet: &[(f64, Point3<f64>)], allowed: f64) -> bool {
    let n = feet.len();
    if n < 20 {
        return false;
    }
    let points: Vec<Point3<f64>> = feet.iter().map(|foot| foot.1).collect();
    let terms = if n < 60 { 10 } else { 20 };
    // Polynomials of the feet: those of the points themselves would contain the distances.
    let centre = mean(&points);
    let size = points.iter().map(|p| (p - centre).norm()).fold(f64::MIN_POSITIVE, f64::max);
    let mut matrix = DMatrix::<f64>::zeros(terms, terms);
    let mut right = DVector::<f64>::zeros(terms);
    let mut row = [0.0; 20];
    for (d, foot) in feet {
        let q = (foot - centre) / size;
        let (x, y, z) = (q.x, q.y, q.z);
        let all = [
            1.0,
            x,
            y,
            z,
            x * x,
            x * y,
            x * z,
            y * y,
            y * z,
            z * z,
            x * x * x,
            x * x * y,
            x * x * z,
            x * y * y,
            x * y * z,
            x * z * z,
            y * y * y,
            y * y * z,
            y * z * z,
            z * z * z,
        ];
        row.copy_from_slice(&all);
        for i in 0..terms {
            right[i] += row[i] * d;
            for j in 0..=i {
                matrix[(i, j)] += row[i] * row[j];
            }
        }
    }
    for i in 0..terms {
        matrix[(i, i)] += 1e-7 * n as f64;
    }
    let Some(cholesky) = matrix.cholesky() else { return false };
    let explained = right.dot(&cholesky.solve(&right));
    let k = terms as f64;
    explained > k + 4.0 * (2.0 * k).sqrt() + allowed * n as f64
}
