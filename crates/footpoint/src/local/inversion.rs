//! Point inversion: the parameter of a point that lies on the shape.

use super::{LocalOptions, Method, Start, project_curve, project_surface};
use crate::{CurveFootpoint, Error, SurfaceFootpoint};
use nalgebra::{SVector, Vector3};
use nurbs_core::{ParametricCurve, ParametricSurface};

/// The parameter of a point that lies on the curve up to `tolerance` (a length), sought from `start`.
///
/// Eq. (5) of \[HW05\] is tried first, since for points on the curve it converges with order 3; where it
/// ends elsewhere, the method of the options.
///
/// # Errors
/// [`Error::NotOnShape`] with the distance of the footpoint found, if that exceeds the tolerance: the
/// point does not lie on the curve, or the start was too far from it. [`Error::NonFinitePoint`] if `x` is
/// not finite, [`Error::Option`] if the tolerance is negative or NaN.
///
/// ```
/// use footpoint::local::{LocalOptions, Start, invert_curve};
/// use nurbs_core::{BsplineCurve, ParametricCurve, nalgebra::Vector2};
///
/// let points = vec![Vector2::new(0.0, 0.0), Vector2::new(1.0, 2.0), Vector2::new(2.0, 0.0)];
/// let parabola = BsplineCurve::bezier(points, None)?;
/// let x = parabola.point(0.375);
/// let found = invert_curve(&parabola, &x, Start::ControlPolygon, 1e-9, &LocalOptions::default())?;
/// assert!((found.parameter - 0.375).abs() < 1e-12);
/// # Ok::<(), footpoint::Error>(())
/// ```
pub fn invert_curve<const D: usize, C: ParametricCurve<D> + ?Sized>(
    curve: &C,
    x: &SVector<f64, D>,
    start: impl Into<Start<f64>>,
    tolerance: f64,
    options: &LocalOptions,
) -> Result<CurveFootpoint<D>, Error> {
    check(x.iter(), tolerance)?;
    let start = start.into();
    let mut found = project_curve(curve, x, start, &options.with_method(Method::SecondOrderTaylor));
    if !on_shape(found.distance, tolerance) && options.method != Method::SecondOrderTaylor {
        let other = project_curve(curve, x, start, options);
        if other.distance < found.distance {
            found = other;
        }
    }
    accept(found.distance, tolerance).map(|()| found)
}

/// The parameters of a point that lies on the surface up to `tolerance` (a length), sought from `start`.
///
/// # Errors
/// As [`invert_curve`].
pub fn invert_surface<S: ParametricSurface + ?Sized>(
    surface: &S,
    x: &Vector3<f64>,
    start: impl Into<Start<[f64; 2]>>,
    tolerance: f64,
    options: &LocalOptions,
) -> Result<SurfaceFootpoint, Error> {
    check(x.iter(), tolerance)?;
    let found = project_surface(surface, x, start, options);
    accept(found.distance, tolerance).map(|()| found)
}

fn check<'a>(mut coordinates: impl Iterator<Item = &'a f64>, tolerance: f64) -> Result<(), Error> {
    if !coordinates.all(|c| c.is_finite()) {
        return Err(Error::NonFinitePoint { index: 0 });
    }
    if tolerance.is_nan() || tolerance < 0.0 {
        let what = "a length, zero or positive, is needed";
        return Err(Error::Option { option: "tolerance", value: tolerance, what });
    }
    Ok(())
}

fn on_shape(distance: f64, tolerance: f64) -> bool {
    distance <= tolerance
}

fn accept(distance: f64, tolerance: f64) -> Result<(), Error> {
    if on_shape(distance, tolerance) { Ok(()) } else { Err(Error::NotOnShape { distance, tolerance }) }
}
