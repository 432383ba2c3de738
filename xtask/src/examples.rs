//! The shapes of the examples in [HW05, sec. 4].

use nalgebra::{Vector2, Vector3};
use nurbs_core::{
    BsplineCurve, BsplineSurface, CurveFn, CurveJet, Error, Interval, KnotVector, ParametricCurve,
};

/// Example 1: `c(t) = (t, sin t)` on one period.
pub(crate) fn sine() -> Result<impl ParametricCurve<2>, Error> {
    Ok(CurveFn::new(Interval::new(0.0, std::f64::consts::TAU)?, |t: f64| CurveJet {
        point: Vector2::new(t, t.sin()),
        d1: Vector2::new(1.0, t.cos()),
        d2: Vector2::new(0.0, -t.sin()),
    }))
}

/// Example 2: a cubic B-spline curve ("order" in the text; `B⁴` are the cubic basis functions).
pub(crate) fn curve() -> Result<BsplineCurve<2>, Error> {
    let knots = KnotVector::new(3, vec![0., 0., 0., 0., 0.2, 0.4, 0.6, 0.8, 1., 1., 1., 1.])?;
    let points = [
        [100., 100.],
        [140., 196.],
        [200., 240.],
        [260., 164.],
        [340., 164.],
        [400., 240.],
        [460., 196.],
        [500., 100.],
    ];
    BsplineCurve::new(knots, points.map(Vector2::from).to_vec(), None)
}

/// Example 3: a bicubic B-spline surface.
///
/// The groups of four control points run in `v`, the seven groups in `u`: the knots admit no other
/// reading, although the text sums over 4 × 7.
pub(crate) fn surface() -> Result<BsplineSurface, Error> {
    let knots_u = KnotVector::new(3, vec![0., 0., 0., 0., 0.25, 0.5, 0.75, 1., 1., 1., 1.])?;
    let knots_v = KnotVector::bezier(3, Interval::UNIT)?;
    let net = [
        [[-236., -197., -22.], [-206., -117., -22.], [-216., -27., 8.], [-246., 62., -22.]],
        [[-156., -177., 8.], [-176., -97., 38.], [-157., 20., 126.], [-186., 142., 8.]],
        [[-86., -157., 8.], [-138., -113., -146.], [-104., 14., -60.], [-96., 102., 8.]],
        [[-6., -197., -22.], [-47., -96., -33.], [25., 32., 95.], [-6., 102., 8.]],
        [[74., -177., 8.], [34., -75., 147.], [86., 97., 105.], [54., 142., 8.]],
        [[124., -157., 8.], [198., -31., 63.], [64., 31., 154.], [144., 102., 8.]],
        [[204., -197., -22.], [234., -77., 8.], [214., -7., 8.], [239., 102., -22.]],
    ];
    let points = net.as_flattened().iter().map(|p| Vector3::from(*p)).collect();
    BsplineSurface::new(knots_u, knots_v, points, None)
}
