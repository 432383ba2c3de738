//! Bilinear patches, ruled surfaces, extrusions, translational surfaces.

use super::compatible::compatible;
use crate::analytic::finite;
use crate::{BsplineCurve, BsplineSurface, Error, Interval, KnotVector, ParametricCurve};
use nalgebra::Vector3;

/// The bilinear patch on `[0, 1]²` with the given corners: `corners[i][j]` is at `u = i`, `v = j`.
///
/// # Errors
/// When a coordinate is not finite.
pub fn bilinear(corners: [[Vector3<f64>; 2]; 2]) -> Result<BsplineSurface, Error> {
    let knots = KnotVector::bezier(1, Interval::UNIT)?;
    BsplineSurface::new(knots.clone(), knots, corners.concat(), None)
}

/// The ruled surface between two curves: `u` runs along the curves, `v` from the first (0) to the
/// second (1).
///
/// Points of equal parameter are joined, the second curve's domain being stretched to that of the
/// first. Two rational curves are joined in homogeneous coordinates: the rulings are straight then too,
/// but not evenly parameterised.
///
/// ```
/// # use nurbs_core::{construct, Line, ParametricSurface};
/// # use nalgebra::Vector3;
/// let a = Line::new(Vector3::new(0., 0., 0.), Vector3::new(1., 0., 0.))?.to_nurbs()?;
/// let b = Line::new(Vector3::new(0., 1., 0.), Vector3::new(1., 1., 1.))?.to_nurbs()?;
/// let s = construct::ruled(&a, &b)?;
/// assert_eq!(s.point(0.5, 0.5), Vector3::new(0.5, 0.5, 0.25));
/// # Ok::<(), nurbs_core::Error>(())
/// ```
///
/// # Errors
/// [`Error::Incompatible`] when one curve is periodic and the other is not.
pub fn ruled(first: &BsplineCurve<3>, second: &BsplineCurve<3>) -> Result<BsplineSurface, Error> {
    let curves = compatible(&[first.clone(), second.clone()])?;
    let (a, b) = (&curves[0], &curves[1]);
    let rational = a.weights().is_some() || b.weights().is_some();
    let n = a.control_points().len();
    let points = (0..n).flat_map(|i| [a.control_points()[i], b.control_points()[i]]).collect();
    let weights = rational.then(|| (0..n).flat_map(|i| [a.weight(i), b.weight(i)]).collect());
    BsplineSurface::new(a.knots().clone(), KnotVector::bezier(1, Interval::UNIT)?, points, weights)
}

/// The surface swept by a curve along a vector: `u` along the curve, `v` the length of the way, from
/// 0 to that of the vector.
///
/// # Errors
/// [`Error::Argument`] when the vector is zero or not finite.
pub fn extrude(curve: &BsplineCurve<3>, vector: &Vector3<f64>) -> Result<BsplineSurface, Error> {
    finite("extrusion vector", vector.as_slice())?;
    let length = vector.norm();
    if !(length > 0.0 && length.is_finite()) {
        return Err(Error::argument(format!("the extrusion vector has the length {length}")));
    }
    let points = curve.control_points().iter().flat_map(|p| [*p, p + vector]).collect();
    let weights = curve.weights().map(|w| w.iter().flat_map(|w| [*w; 2]).collect());
    let knots_v = KnotVector::bezier(1, Interval::new(0.0, length)?)?;
    BsplineSurface::new(curve.knots().clone(), knots_v, points, weights)
}

/// The translational surface `s(u, v) = c(u) + p(v) − p(v₀)`: the curve is moved along the path without
/// turning, from where it lies; `v₀` is the start of the path. Exact for rational curves too.
///
/// # Errors
/// None for finite curves, unless coordinates overflow.
pub fn translate_along(curve: &BsplineCurve<3>, path: &BsplineCurve<3>) -> Result<BsplineSurface, Error> {
    let start = path.point(path.domain().start());
    let mut points = Vec::with_capacity(curve.control_points().len() * path.control_points().len());
    let mut weights = Vec::with_capacity(points.capacity());
    for (i, c) in curve.control_points().iter().enumerate() {
        for (j, p) in path.control_points().iter().enumerate() {
            points.push(c + (p - start));
            weights.push(curve.weight(i) * path.weight(j));
        }
    }
    let rational = curve.weights().is_some() || path.weights().is_some();
    let weights = rational.then_some(weights);
    BsplineSurface::new(curve.knots().clone(), path.knots().clone(), points, weights)
}
