//! Coons patches.

use super::compatible::compatible;
use crate::{BsplineCurve, BsplineSurface, Error, KnotVector, ParametricCurve};
use nalgebra::{SVector, Vector4};

/// Relative difference that the weights of curves at a corner may have.
const SAME_WEIGHT: f64 = 1e-9;

/// The bilinearly blended Coons patch of four boundary curves ([PT97, sec. 10.6]).
///
/// `along_u` are the curves `v = 0` and `v = 1`, both running in `u`; `along_v` the curves `u = 0` and
/// `u = 1`, both running in `v`. Opposite curves get common knots on the domain of the first one. Where
/// the ends of two curves differ by no more than `abs_tolerance` (a length), the patch follows its
/// boundary curves up to that difference; where they meet exactly, it contains them exactly.
///
/// Rational curves are blended in homogeneous coordinates; the weights at the four corners must then
/// agree, up to one factor for each curve.
///
/// # Errors
/// [`Error::Incompatible`] for curves that do not meet at a corner (says at which and by how much) or whose
/// weights do not; [`Error::Weight`] when blending makes a weight that is not positive.
pub fn coons(
    along_u: [&BsplineCurve<3>; 2],
    along_v: [&BsplineCurve<3>; 2],
    abs_tolerance: f64,
) -> Result<BsplineSurface, Error> {
    check_corners(along_u, along_v, abs_tolerance)?;
    let clamped = |curves: [&BsplineCurve<3>; 2]| -> Result<Vec<BsplineCurve<3>>, Error> {
        compatible(&[curves[0].clamped()?, curves[1].clamped()?])
    };
    let (u, v) = (clamped(along_u)?, clamped(along_v)?);
    let scale = weight_factors(&u, &v)?;
    let (c0, c1) = (homogeneous(&u[0], 1.0), homogeneous(&u[1], scale[0]));
    let (d0, d1) = (homogeneous(&v[0], scale[1]), homogeneous(&v[1], scale[2]));
    // A linear function has its values at the Greville abscissae as coefficients, so the blending
    // functions meet the control points there.
    let (blend_u, blend_v) = (fractions(u[0].knots()), fractions(v[0].knots()));
    let last = c0.len() - 1;
    let mut points = Vec::with_capacity(c0.len() * d0.len());
    let mut weights = Vec::with_capacity(points.capacity());
    for (i, s) in blend_u.iter().enumerate() {
        for (j, t) in blend_v.iter().enumerate() {
            let between_u = c0[i] * (1.0 - t) + c1[i] * *t;
            let between_v = d0[j] * (1.0 - s) + d1[j] * *s;
            let corners =
                (c0[0] * (1.0 - s) + c0[last] * *s) * (1.0 - t) + (c1[0] * (1.0 - s) + c1[last] * *s) * *t;
            let point = between_u + between_v - corners;
            points.push(point.xyz() / point.w);
            weights.push(point.w);
        }
    }
    let rational = u.iter().chain(&v).any(|c| c.weights().is_some());
    // Without weights the fourth coordinate is 1 up to rounding.
    let weights = rational.then_some(weights);
    BsplineSurface::new(u[0].knots().clone(), v[0].knots().clone(), points, weights)
}

fn ends(curve: &BsplineCurve<3>) -> [SVector<f64, 3>; 2] {
    let domain = curve.domain();
    [curve.point(domain.start()), curve.point(domain.end())]
}

fn check_corners(
    along_u: [&BsplineCurve<3>; 2],
    along_v: [&BsplineCurve<3>; 2],
    abs_tolerance: f64,
) -> Result<(), Error> {
    for (j, curve) in along_u.into_iter().enumerate() {
        for (i, corner) in ends(curve).into_iter().enumerate() {
            let other = ends(along_v[i])[j];
            let gap = (corner - other).norm();
            // A tolerance of NaN accepts nothing.
            if gap > abs_tolerance || abs_tolerance.is_nan() {
                return Err(Error::Incompatible {
                    what: format!(
                        "the boundary curves do not meet at the corner u = {i}, v = {j}: the curve along u \
                         has ({}, {}, {}) there, the one along v ({}, {}, {}); they are {gap} apart, more than \
                         the tolerance {abs_tolerance}",
                        corner.x, corner.y, corner.z, other.x, other.y, other.z
                    ),
                });
            }
        }
    }
    Ok(())
}

/// Factors for the weights of the second curve along `u` and both along `v` that make the weights agree at
/// the corners with those of the first.
fn weight_factors(u: &[BsplineCurve<3>], v: &[BsplineCurve<3>]) -> Result<[f64; 3], Error> {
    let corner = |c: &BsplineCurve<3>, end: usize| c.weight(end * (c.control_points().len() - 1));
    let first = corner(&u[0], 0) / corner(&v[0], 0);
    let second = corner(&u[0], 1) / corner(&v[1], 0);
    let opposite = first * corner(&v[0], 1) / corner(&u[1], 0);
    let (found, wanted) = (opposite * corner(&u[1], 1), second * corner(&v[1], 1));
    if (found / wanted - 1.0).abs() <= SAME_WEIGHT {
        return Ok([opposite, first, second]);
    }
    Err(Error::Incompatible {
        what: format!(
            "the weights of the boundary curves do not agree at the corner u = 1, v = 1: {found} and {wanted}; \
             reparameterise a rational boundary curve or use polynomial ones"
        ),
    })
}

fn homogeneous(curve: &BsplineCurve<3>, factor: f64) -> Vec<Vector4<f64>> {
    let lift = |(i, p): (usize, &SVector<f64, 3>)| {
        let w = factor * curve.weight(i);
        Vector4::new(p.x * w, p.y * w, p.z * w, w)
    };
    curve.control_points().iter().enumerate().map(lift).collect()
}

/// Greville abscissae as fractions of the domain.
fn fractions(knots: &KnotVector) -> Vec<f64> {
    let domain = knots.domain();
    knots.greville().into_iter().map(|t| domain.fraction(t)).collect()
}
