//! Parametric splines in powers of the parameter (types 112 and 114), as B-splines of degree 3.

use super::fault::Fault;
use super::file::Cursor;
use brep_core::description::EdgeCurve;
use nalgebra::Vector3;
use nurbs_core::{BsplineCurve, BsplineSurface, KnotVector};
use std::sync::Arc;

/// Share of the size by which neighbouring pieces may differ at their joint: files give coefficients in 9 digits or more.
const JOINT: f64 = 1e-6;

/// Bernstein coefficients of `Σ a_i s^i` over `0 ≤ s ≤ h`.
fn bernstein(powers: [f64; 4], h: f64) -> [f64; 4] {
    let [a, b, c, d] = powers;
    let (b, c, d) = (b * h, c * h * h, d * h * h * h);
    [a, a + b / 3.0, a + (2.0 * b + c) / 3.0, a + b + c + d]
}

/// The knots of cubic pieces between the break points.
fn knots(breaks: &[f64]) -> Vec<f64> {
    let inner = breaks.iter().flat_map(|&t| [t; 3]);
    let ends = [breaks.first(), breaks.last()].map(|end| end.copied().unwrap_or_default());
    std::iter::once(ends[0]).chain(inner).chain([ends[1]]).collect()
}

/// Break points of a spline, checked to increase.
fn breaks(values: &mut Cursor<'_>, pieces: usize) -> Result<Vec<f64>, Fault> {
    if pieces == 0 {
        return Err(values.invalid("the spline has no pieces"));
    }
    let breaks = values.list(pieces + 1, "break points")?;
    match breaks.windows(2).find(|pair| pair[0] >= pair[1]) {
        Some(pair) => {
            Err(values.invalid(format!("the break points {} and {} do not increase", pair[0], pair[1])))
        }
        None => Ok(breaks),
    }
}

/// Checks that a piece begins where its neighbour ends.
fn check_joint(
    values: &Cursor<'_>,
    end: &Vector3<f64>,
    start: &Vector3<f64>,
    size: f64,
) -> Result<(), Fault> {
    let gap = (end - start).norm();
    if gap <= JOINT * size {
        return Ok(());
    }
    Err(values.invalid(format!("two pieces of the spline are {gap} apart where they should meet")))
}

fn largest(points: &[Vector3<f64>]) -> f64 {
    points.iter().map(Vector3::amax).fold(0.0, f64::max)
}

/// Type 112: a parametric spline curve.
pub(crate) fn curve(values: &mut Cursor<'_>) -> Result<(EdgeCurve, [f64; 2]), Fault> {
    for name in ["spline type", "degree of continuity", "number of dimensions"] {
        values.integer(name)?;
    }
    let pieces = values.count("number of pieces")?;
    let breaks = breaks(values, pieces)?;
    let mut points: Vec<Vector3<f64>> = Vec::with_capacity(3 * pieces + 1);
    for piece in breaks.windows(2) {
        let mut net = [Vector3::zeros(); 4];
        for c in 0..3 {
            let powers = values.reals("coefficients of a piece")?;
            for (point, coefficient) in net.iter_mut().zip(bernstein(powers, piece[1] - piece[0])) {
                point[c] = coefficient;
            }
        }
        if let Some(last) = points.pop() {
            check_joint(values, &last, &net[0], largest(&points).max(largest(&net)))?;
        }
        points.extend(net);
    }
    // Values and derivatives at the end repeat what the last piece says.
    if !values.is_ended() {
        values.reals::<12>("values at the end")?;
    }
    let curve = KnotVector::new(3, knots(&breaks)).and_then(|knots| BsplineCurve::new(knots, points, None));
    let curve = curve.map_err(|error| values.invalid(format!("the spline is not valid: {error}")))?;
    Ok((EdgeCurve::Nurbs(Arc::new(curve)), [breaks[0], breaks[pieces]]))
}

/// Type 114: a parametric spline surface.
pub(crate) fn surface(values: &mut Cursor<'_>) -> Result<BsplineSurface, Fault> {
    for name in ["spline type", "patch type"] {
        values.integer(name)?;
    }
    let [rows, columns] = [values.count("number of patches in u")?, values.count("number of patches in v")?];
    let [u, v] = [breaks(values, rows)?, breaks(values, columns)?];
    values.expect(rows.saturating_mul(columns).saturating_mul(48), "coefficients of the patches")?;
    let width = 3 * columns + 1;
    let mut points = vec![Vector3::zeros(); (3 * rows + 1) * width];
    let mut set = vec![false; points.len()];
    let mut patches = Vec::with_capacity(rows * columns);
    for i in 0..rows {
        // Each row is followed by one more patch of arbitrary numbers.
        for j in 0..=columns {
            if j == columns && i + 1 == rows && values.is_ended() {
                break;
            }
            let coefficients: [f64; 48] = values.reals("coefficients of a patch")?;
            if j < columns {
                patches.push(patch(&coefficients, u[i + 1] - u[i], v[j + 1] - v[j]));
            }
        }
    }
    // And the last row by a row of such patches.
    for _ in 0..=columns {
        if values.is_ended() || values.reals::<48>("coefficients of a patch").is_err() {
            break;
        }
    }
    let size = patches.iter().map(|patch| largest(patch)).fold(0.0, f64::max);
    for (index, patch) in patches.iter().enumerate() {
        let (i, j) = (index / columns, index % columns);
        for (k, point) in patch.iter().enumerate() {
            let place = (3 * i + k / 4) * width + 3 * j + k % 4;
            if set[place] {
                check_joint(values, &points[place], point, size)?;
            }
            points[place] = *point;
            set[place] = true;
        }
    }
    let made = KnotVector::new(3, knots(&u))
        .and_then(|knots_u| BsplineSurface::new(knots_u, KnotVector::new(3, knots(&v))?, points, None));
    made.map_err(|error| values.invalid(format!("the spline surface is not valid: {error}")))
}

/// The control points of a patch, `u` outer; its coefficients are those of `s^i t^j` at index `4 j + i` of each coordinate.
fn patch(coefficients: &[f64; 48], h_u: f64, h_v: f64) -> [Vector3<f64>; 16] {
    let mut net = [Vector3::zeros(); 16];
    for c in 0..3 {
        let of = &coefficients[16 * c..16 * c + 16];
        // Along u for each power of t, then along v.
        let in_u: [[f64; 4]; 4] =
            std::array::from_fn(|j| bernstein(std::array::from_fn(|i| of[4 * j + i]), h_u));
        for i in 0..4 {
            let in_v = bernstein(std::array::from_fn(|j| in_u[j][i]), h_v);
            for j in 0..4 {
                net[4 * i + j][c] = in_v[j];
            }
        }
    }
    net
}
