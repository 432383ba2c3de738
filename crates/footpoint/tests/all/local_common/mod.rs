//! Shapes for the tests of the local iterations.
#![allow(dead_code, reason = "every test file uses some of them")]

use nalgebra::{Vector2, Vector3};
use nurbs_core::{
    BsplineCurve, BsplineSurface, CurveJet, Interval, KnotVector, ParametricCurve, ParametricSurface,
    SurfaceFn, SurfaceJet,
};
use std::f64::consts::{FRAC_PI_2, TAU};

/// Example 2 of [HW05].
pub(crate) fn cubic_curve() -> BsplineCurve<2> {
    let knots = KnotVector::new(3, vec![0., 0., 0., 0., 0.2, 0.4, 0.6, 0.8, 1., 1., 1., 1.]).unwrap();
    let x = [100., 140., 200., 260., 340., 400., 460., 500.];
    let y = [100., 196., 240., 164., 164., 240., 196., 100.];
    let points = x.iter().zip(y).map(|(&x, y)| Vector2::new(x, y)).collect();
    BsplineCurve::new(knots, points, None).unwrap()
}

/// A bicubic surface over `[0, 1]²` whose heights come from `heights` (6 × 5, row by row).
pub(crate) fn bumpy_surface(heights: &[f64]) -> BsplineSurface {
    let (ku, kv) = (KnotVector::uniform_clamped(3, 6).unwrap(), KnotVector::uniform_clamped(3, 5).unwrap());
    let points = (0..30).map(|k| Vector3::new((k / 5) as f64, (k % 5) as f64, heights[k])).collect();
    BsplineSurface::new(ku, kv, points, None).unwrap()
}

/// Two straight pieces that meet at (1, 0) for `t = 1`, with the corner upwards.
pub(crate) fn roof() -> BsplineCurve<2> {
    let knots = KnotVector::new(1, vec![0., 0., 1., 2., 2.]).unwrap();
    let points = vec![Vector2::new(0., -1.), Vector2::new(1., 0.), Vector2::new(2., -1.)];
    BsplineCurve::new(knots, points, None).unwrap()
}

/// The exact rational circle of radius 1, clamped, with kinks of the parameterisation at the quarters.
pub(crate) fn circle() -> BsplineCurve<2> {
    let knots = KnotVector::new(2, vec![0., 0., 0., 1., 1., 2., 2., 3., 3., 4., 4., 4.]).unwrap();
    let h = std::f64::consts::FRAC_1_SQRT_2;
    let points =
        [[1., 0.], [1., 1.], [0., 1.], [-1., 1.], [-1., 0.], [-1., -1.], [0., -1.], [1., -1.], [1., 0.]];
    let weights = (0..9).map(|i| if i % 2 == 0 { 1.0 } else { h }).collect();
    BsplineCurve::new(knots, points.map(Vector2::from).to_vec(), Some(weights)).unwrap()
}

/// The unit sphere by longitude and latitude: closed in `u`, poles at both ends of `v`.
pub(crate) fn sphere() -> impl ParametricSurface {
    let latitudes = Interval::new(-FRAC_PI_2, FRAC_PI_2).unwrap();
    SurfaceFn::new([Interval::new(0.0, TAU).unwrap(), latitudes], |u: f64, v: f64| {
        let (su, cu) = if u == TAU { (0.0, 1.0) } else { u.sin_cos() };
        let (sv, cv) = if v.abs() == FRAC_PI_2 { (v.signum(), 0.0) } else { v.sin_cos() };
        SurfaceJet {
            point: Vector3::new(cu * cv, su * cv, sv),
            du: Vector3::new(-su * cv, cu * cv, 0.0),
            dv: Vector3::new(-cu * sv, -su * sv, cv),
            duu: Vector3::new(-cu * cv, -su * cv, 0.0),
            duv: Vector3::new(su * sv, -cu * sv, 0.0),
            dvv: Vector3::new(-cu * cv, -su * cv, -sv),
        }
    })
}

/// A quarter disc in the plane `z = 0`: the edge `v = 0` is collapsed into the origin.
pub(crate) fn fan() -> BsplineSurface {
    let (ku, kv) =
        (KnotVector::bezier(2, Interval::UNIT).unwrap(), KnotVector::bezier(1, Interval::UNIT).unwrap());
    let rim = [[1., 0., 0.], [1., 1., 0.], [0., 1., 0.]];
    let points = rim.iter().flat_map(|p| [Vector3::zeros(), Vector3::from(*p)]).collect();
    let h = std::f64::consts::FRAC_1_SQRT_2;
    BsplineSurface::new(ku, kv, points, Some(vec![1., 1., h, h, 1., 1.])).unwrap()
}

/// A roof extruded along `y`: a ridge at `u = 1`.
pub(crate) fn roof_surface() -> BsplineSurface {
    let ku = KnotVector::new(1, vec![0., 0., 1., 2., 2.]).unwrap();
    let kv = KnotVector::bezier(1, Interval::UNIT).unwrap();
    let profile = [[0., -1.], [1., 0.], [2., -1.]];
    let points = profile.iter().flat_map(|[x, z]| [0.0, 3.0].map(|y| Vector3::new(*x, y, *z))).collect();
    BsplineSurface::new(ku, kv, points, None).unwrap()
}

/// A curve moved rigidly and parameterised by `s ↦ c(origin + rate · s)`.
pub(crate) struct Moved<'a, C> {
    pub(crate) curve: &'a C,
    pub(crate) angle: f64,
    pub(crate) shift: Vector2<f64>,
    pub(crate) origin: f64,
    pub(crate) rate: f64,
}

impl<C> Moved<'_, C> {
    pub(crate) fn turn(&self, v: &Vector2<f64>) -> Vector2<f64> {
        let (s, c) = self.angle.sin_cos();
        Vector2::new(c * v.x - s * v.y, s * v.x + c * v.y)
    }
}

impl<C: ParametricCurve<2>> ParametricCurve<2> for Moved<'_, C> {
    fn domain(&self) -> Interval {
        let domain = self.curve.domain();
        Interval::new((domain.start() - self.origin) / self.rate, (domain.end() - self.origin) / self.rate)
            .unwrap()
    }

    fn jet(&self, t: f64) -> CurveJet<2> {
        let jet = self.curve.jet(self.origin + self.rate * t);
        CurveJet {
            point: self.turn(&jet.point) + self.shift,
            d1: self.turn(&jet.d1) * self.rate,
            d2: self.turn(&jet.d2) * (self.rate * self.rate),
        }
    }
}
