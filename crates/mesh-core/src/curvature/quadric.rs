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
    // Coordinates over the tangent plane in units of the radius, heights and weights.
    let samples = || {
        near.iter().map(|neighbour| {
            let d = (points[neighbour.index] - x) / radius;
            let weight = (1.0 - 0.75 * neighbour.distance_sq / (radius * radius)).max(0.0);
            [d.dot(&t1), d.dot(&t2), d.dot(normal), weight]
        })
    };
    let [_, hx, hy, hxx, hxy, hyy] = solve_normal_equations(samples()).or_else(|| solve(samples()))?;
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

/// Samples that are summed side by side.
const LANES: usize = 4;

/// The normal equations: matrix and right-hand side.
///
/// All products of two terms are monomials up to degree 4, so that 15 moments make up the matrix. Sums run in lanes, which
/// the compiler turns into vector instructions, and are added up in a fixed order.
fn normal_equations(samples: impl Iterator<Item = [f64; 4]>) -> ([[f64; TERMS]; TERMS], [f64; TERMS]) {
    let mut moments = [[0.0; LANES]; 15];
    let mut heights = [[0.0; LANES]; TERMS];
    let mut add = |[xi, eta, height, weight]: &[[f64; LANES]; 4]| {
        for lane in 0..LANES {
            let (x, y, w) = (xi[lane], eta[lane], weight[lane] * weight[lane]);
            let (xx, xy, yy) = (x * x, x * y, y * y);
            let monomials = [
                1.0,
                x,
                y,
                xx,
                xy,
                yy,
                xx * x,
                xx * y,
                x * yy,
                yy * y,
                xx * xx,
                xx * xy,
                xx * yy,
                xy * yy,
                yy * yy,
            ];
            for (moment, monomial) in moments.iter_mut().zip(monomials) {
                moment[lane] += w * monomial;
            }
            let h = w * height[lane];
            for (sum, monomial) in heights.iter_mut().zip(monomials) {
                sum[lane] += h * monomial;
            }
        }
    };
    let mut block = [[0.0; LANES]; 4];
    let mut filled = 0;
    for sample in samples {
        for (row, value) in block.iter_mut().zip(sample) {
            row[filled] = value;
        }
        filled += 1;
        if filled == LANES {
            add(&block);
            // What is left of the last block has no weight.
            (block, filled) = ([[0.0; LANES]; 4], 0);
        }
    }
    add(&block);
    let total = |lanes: &[f64; LANES]| (lanes[0] + lanes[1]) + (lanes[2] + lanes[3]);
    let [m, x, y, xx, xy, yy, xxx, xxy, xyy, yyy, x4, x3y, xxyy, xy3, y4] = moments.each_ref().map(total);
    let [h, hx, hy, hxx, hxy, hyy] = heights.each_ref().map(total);
    let matrix = [
        [m, x, y, 0.5 * xx, xy, 0.5 * yy],
        [x, xx, xy, 0.5 * xxx, xxy, 0.5 * xyy],
        [y, xy, yy, 0.5 * xxy, xyy, 0.5 * yyy],
        [0.5 * xx, 0.5 * xxx, 0.5 * xxy, 0.25 * x4, 0.5 * x3y, 0.25 * xxyy],
        [xy, xxy, xyy, 0.5 * x3y, xxyy, 0.5 * xy3],
        [0.5 * yy, 0.5 * xyy, 0.5 * yyy, 0.25 * xxyy, 0.5 * xy3, 0.25 * y4],
    ];
    (matrix, [h, hx, hy, 0.5 * hxx, hxy, 0.5 * hyy])
}

/// Least squares by the normal equations; `None` where they would cost half of the digits.
fn solve_normal_equations(samples: impl Iterator<Item = [f64; 4]>) -> Option<[f64; TERMS]> {
    let (mut normal, mut right) = normal_equations(samples);
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
fn solve(samples: impl ExactSizeIterator<Item = [f64; 4]>) -> Option<[f64; TERMS]> {
    let mut system = DMatrix::zeros(samples.len(), TERMS);
    let mut right = DVector::zeros(samples.len());
    for (i, [xi, eta, height, weight]) in samples.enumerate() {
        let terms = [1.0, xi, eta, 0.5 * xi * xi, xi * eta, 0.5 * eta * eta];
        system.set_row(i, &RowSVector::from(terms.map(|term| weight * term)));
        right[i] = weight * height;
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
