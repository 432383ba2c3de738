//! A quadratic height function over the tangent plane, fitted to neighbours (\[CP05\]).

use nalgebra::{DMatrix, DVector, Point3, Vector3};

use super::tensor::{CurvatureFrame, tangents};
use crate::Neighbour;
use crate::normals::unit;

/// Coefficients of `1, ξ, η, ξ²/2, ξη, η²/2`.
const TERMS: usize = 6;

/// Singular values up to this part of the largest count as zero: the neighbours then lie on a conic.
const RANK_TOLERANCE: f64 = 1e-6;

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
    let mut system = DMatrix::zeros(near.len(), TERMS);
    let mut heights = DVector::zeros(near.len());
    for (row, neighbour) in near.iter().enumerate() {
        let d = (points[neighbour.index] - x) / radius;
        let (xi, eta) = (d.dot(&t1), d.dot(&t2));
        let weight = (1.0 - 0.75 * neighbour.distance_sq / (radius * radius)).max(0.0);
        for (column, term) in [1.0, xi, eta, 0.5 * xi * xi, xi * eta, 0.5 * eta * eta].into_iter().enumerate()
        {
            system[(row, column)] = weight * term;
        }
        heights[row] = weight * d.dot(normal);
    }
    let [_, hx, hy, hxx, hxy, hyy] = solve(system, heights)?;
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

/// Least squares by a QR decomposition; `None` if the columns depend on each other.
fn solve(system: DMatrix<f64>, heights: DVector<f64>) -> Option<[f64; TERMS]> {
    let qr = system.qr();
    let r = qr.r();
    let diagonal = r.diagonal().abs();
    if diagonal.min() <= RANK_TOLERANCE * diagonal.max() {
        return None;
    }
    let mut right = heights;
    qr.q_tr_mul(&mut right);
    let solution = r.solve_upper_triangular(&right.rows(0, TERMS).into_owned())?;
    let found: [f64; TERMS] = std::array::from_fn(|term| solution[term]);
    found.iter().all(|value| value.is_finite()).then_some(found)
}
