//! A quadratic height function over the tangent plane, fitted to neighbours (\[CP05\]).

use nalgebra::{DMatrix, DVector, Point3, RowSVector, Vector3};

use super::tensor::{CurvatureFrame, tangents};
use crate::Neighbour;
use crate::normals::unit;

/// Coefficients of `1, ξ, η, ξ²/2, ξη, η²/2`.
const TERMS: usize = 6;

/// Singular values up to this part of the largest count as zero: the neighbours then lie on a conic.
const RANK_TOLERANCE: f64 = 1e-6;

/// Squared pivots above this part of the largest let the normal equations keep ten digits.
const WELL_CONDITIONED: f64 = 1e-6;

/// Fits the jet of the surface at `x` and returns its frame.
///
/// Closer neighbours weigh more. `None` if the neighbours do not determine a quadric.
pub(super) fn fit(
    points: &[Point3<f64>],
    x: &Point3<f64>,
    near: &[Neighbour],
    normal: &Vector3<f64>,
) -> Option<CurvatureFrame> {
    let radius = near.last()?.distance();
    if near.len() < TERMS || radius == 0.0 {
        return None;
    }
    let [t1, t2] = tangents(normal)?;
    let rows = || {
        near.iter().map(|neighbour| {
            let d = (points[neighbour.index] - x) / radius;
            let (xi, eta) = (d.dot(&t1), d.dot(&t2));
            let weight = (1.0 - 0.75 * neighbour.distance_sq / (radius * radius)).max(0.0);
            let terms = [1.0, xi, eta, 0.5 * xi * xi, xi * eta, 0.5 * eta * eta];
            (terms.map(|term| weight * term), weight * d.dot(normal))
        })
    };
    let [_, hx, hy, hxx, hxy, hyy] = solve_normal_equations(rows()).or_else(|| solve(rows()))?;
    // Curvature of the graph of the height at (0, 0), over orthonormal vectors of its tangent plane.
    let slope = (1.0 + hx * hx + hy * hy).sqrt();
    let tilted = unit(&(normal - t1 * hx - t2 * hy))?;
    let e1 = unit(&(t1 + normal * hx))?;
    let e2 = tilted.cross(&e1);
    // e2 = α s_ξ + β s_η; its tangential parts are these factors.
    let length = (1.0 + hx * hx).sqrt();
    let (alpha, beta) = (e2.dot(&t1), e2.dot(&t2));
    let scale = 1.0 / (slope * radius);
    let form = [
        hxx / (length * length) * scale,
        (alpha * hxx + beta * hxy) / length * scale,
        (alpha * alpha * hxx + 2.0 * alpha * beta * hxy + beta * beta * hyy) * scale,
    ];
    CurvatureFrame::of_form(form, [e1, e2], &tilted)
}

/// Least squares by the normal equations; `None` where they would cost half of the digits.
fn solve_normal_equations(rows: impl Iterator<Item = ([f64; TERMS], f64)>) -> Option<[f64; TERMS]> {
    let mut normal = [[0.0; TERMS]; TERMS];
    let mut right = [0.0; TERMS];
    for (row, height) in rows {
        for i in 0..TERMS {
            for j in 0..=i {
                normal[i][j] += row[i] * row[j];
            }
            right[i] += row[i] * height;
        }
    }
    // Cholesky's decomposition; the factor replaces the lower triangle.
    let (mut least, mut most) = (f64::INFINITY, 0.0f64);
    for i in 0..TERMS {
        for j in 0..=i {
            let mut value = normal[i][j];
            for k in 0..j {
                value -= normal[i][k] * normal[j][k];
            }
            if i == j {
                (least, most) = (least.min(value), most.max(value));
                if value.is_nan() || value <= WELL_CONDITIONED * most {
                    return None;
                }
                normal[i][i] = value.sqrt();
            } else {
                normal[i][j] = value / normal[j][j];
            }
        }
    }
    if least <= WELL_CONDITIONED * most {
        return None;
    }
    for i in 0..TERMS {
        for k in 0..i {
            right[i] -= normal[i][k] * right[k];
        }
        right[i] /= normal[i][i];
    }
    for i in (0..TERMS).rev() {
        for k in i + 1..TERMS {
            right[i] -= normal[k][i] * right[k];
        }
        right[i] /= normal[i][i];
    }
    right.iter().all(|value| value.is_finite()).then_some(right)
}

/// Least squares by a QR decomposition; `None` if the columns depend on each other.
fn solve(rows: impl ExactSizeIterator<Item = ([f64; TERMS], f64)>) -> Option<[f64; TERMS]> {
    let mut system = DMatrix::zeros(rows.len(), TERMS);
    let mut right = DVector::zeros(rows.len());
    for (i, (row, height)) in rows.enumerate() {
        system.set_row(i, &RowSVector::from(row));
        right[i] = height;
    }
    let qr = system.qr();
    let r = qr.r();
    let diagonal = r.diagonal().abs();
    if diagonal.min() <= RANK_TOLERANCE * diagonal.max() {
        return None;
    }
    qr.q_tr_mul(&mut right);
    let solution = r.solve_upper_triangular(&right.rows(0, TERMS).into_owned())?;
    let found: [f64; TERMS] = std::array::from_fn(|term| solution[term]);
    found.iter().all(|value| value.is_finite()).then_some(found)
}
