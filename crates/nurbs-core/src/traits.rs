//! What every parametric shape can be asked for.

use crate::{CurveJet, Interval, SurfaceJet};
use nalgebra::{SVector, Vector3};

/// A parameter at which a shape is not twice continuously differentiable.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Break {
    /// The parameter.
    pub parameter: f64,
    /// How often the shape is continuously differentiable there: 0 at a kink, 1 where only the second
    /// derivative jumps.
    pub continuity: usize,
}

/// A parametric curve in `R^D` that is twice differentiable almost everywhere.
///
/// Object safe. Parameters outside the domain are wrapped into the period if there is one; without
/// one the first and last piece are continued, so that an iteration may step past an end.
pub trait ParametricCurve<const D: usize> {
    /// Interval of valid parameters.
    fn domain(&self) -> Interval;

    /// The period for closed curves whose parameter wraps around, with all derivatives.
    fn period(&self) -> Option<f64> {
        None
    }

    /// Parameters inside the domain, in increasing order, where the curve need not be smooth (knots).
    ///
    /// Quadrature and other numerical methods stop there and start anew.
    fn breaks(&self) -> Vec<f64> {
        Vec::new()
    }

    /// Point, first and second derivative in one evaluation.
    fn jet(&self, t: f64) -> CurveJet<D>;

    /// The point alone.
    fn point(&self, t: f64) -> SVector<f64, D> {
        self.jet(t).point
    }

    /// Where the curve is less than twice continuously differentiable, increasing.
    ///
    /// Inside the domain only; a periodic curve also lists the start of its domain if it is such a
    /// place. Iterations that use second derivatives split there.
    fn derivative_breaks(&self) -> Vec<Break> {
        Vec::new()
    }

    /// The Greville parameter of the control point nearest to `x`, if there is a control polygon.
    fn nearest_control_parameter(&self, x: &SVector<f64, D>) -> Option<f64> {
        let _ = x;
        None
    }
}

/// A parametric surface in `R³` that is twice differentiable almost everywhere.
///
/// Object safe. Parameters outside the domain are wrapped in periodic directions; in the others the
/// outermost pieces are continued.
pub trait ParametricSurface {
    /// Intervals of valid parameters `u` and `v`.
    fn domain(&self) -> [Interval; 2];

    /// The periods in `u` and `v` where the surface wraps around with all derivatives.
    fn period(&self) -> [Option<f64>; 2] {
        [None, None]
    }

    /// Parameters `u` and `v` inside the domain, in increasing order, where the surface need not be
    /// smooth (knots).
    fn breaks(&self) -> [Vec<f64>; 2] {
        [Vec::new(), Vec::new()]
    }

    /// Point and all derivatives up to the second order in one evaluation.
    fn jet(&self, u: f64, v: f64) -> SurfaceJet;

    /// The point alone.
    fn point(&self, u: f64, v: f64) -> Vector3<f64> {
        self.jet(u, v).point
    }

    /// Where the surface is less than twice continuously differentiable in `u` and in `v`, increasing.
    ///
    /// As for [`ParametricCurve::derivative_breaks`], in each direction.
    fn derivative_breaks(&self) -> [Vec<Break>; 2] {
        [Vec::new(), Vec::new()]
    }

    /// The Greville parameters of the control point nearest to `x`, if there is a control net.
    fn nearest_control_parameter(&self, x: &Vector3<f64>) -> Option<[f64; 2]> {
        let _ = x;
        None
    }
}

macro_rules! forward {
    ($($pointer:ty),*) => {$(
        impl<const D: usize, C: ParametricCurve<D> + ?Sized> ParametricCurve<D> for $pointer {
            fn domain(&self) -> Interval {
                (**self).domain()
            }
            fn period(&self) -> Option<f64> {
                (**self).period()
            }
            fn breaks(&self) -> Vec<f64> {
                (**self).breaks()
            }
            fn jet(&self, t: f64) -> CurveJet<D> {
                (**self).jet(t)
            }
            fn point(&self, t: f64) -> SVector<f64, D> {
                (**self).point(t)
            }
            fn derivative_breaks(&self) -> Vec<Break> {
                (**self).derivative_breaks()
            }
            fn nearest_control_parameter(&self, x: &SVector<f64, D>) -> Option<f64> {
                (**self).nearest_control_parameter(x)
            }
        }
    )*};
}
forward!(&C, Box<C>);

macro_rules! forward_surface {
    ($($pointer:ty),*) => {$(
        impl<S: ParametricSurface + ?Sized> ParametricSurface for $pointer {
            fn domain(&self) -> [Interval; 2] {
                (**self).domain()
            }
            fn period(&self) -> [Option<f64>; 2] {
                (**self).period()
            }
            fn breaks(&self) -> [Vec<f64>; 2] {
                (**self).breaks()
            }
            fn jet(&self, u: f64, v: f64) -> SurfaceJet {
                (**self).jet(u, v)
            }
            fn point(&self, u: f64, v: f64) -> Vector3<f64> {
                (**self).point(u, v)
            }
            fn derivative_breaks(&self) -> [Vec<Break>; 2] {
                (**self).derivative_breaks()
            }
            fn nearest_control_parameter(&self, x: &Vector3<f64>) -> Option<[f64; 2]> {
                (**self).nearest_control_parameter(x)
            }
        }
    )*};
}
forward_surface!(&S, Box<S>);

/// A curve given by a domain and a closure that returns the jet.
///
/// ```
/// # use nurbs_core::{CurveFn, CurveJet, Interval, ParametricCurve};
/// # use nalgebra::Vector2;
/// let sine = CurveFn::new(Interval::new(0.0, 6.0)?, |t: f64| CurveJet {
///     point: Vector2::new(t, t.sin()),
///     d1: Vector2::new(1.0, t.cos()),
///     d2: Vector2::new(0.0, -t.sin()),
/// });
/// assert_eq!(sine.point(0.0), Vector2::zeros());
/// # Ok::<(), nurbs_core::Error>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct CurveFn<F> {
    domain: Interval,
    jet: F,
}

impl<F> CurveFn<F> {
    /// A curve on `domain` whose jet is `jet(t)`.
    pub fn new(domain: Interval, jet: F) -> Self {
        Self { domain, jet }
    }
}

impl<const D: usize, F: Fn(f64) -> CurveJet<D>> ParametricCurve<D> for CurveFn<F> {
    fn domain(&self) -> Interval {
        self.domain
    }
    fn jet(&self, t: f64) -> CurveJet<D> {
        (self.jet)(t)
    }
}

/// A surface given by its domain and a closure that returns the jet.
#[derive(Clone, Copy, Debug)]
pub struct SurfaceFn<F> {
    domain: [Interval; 2],
    jet: F,
}

impl<F> SurfaceFn<F> {
    /// A surface on `domain` whose jet is `jet(u, v)`.
    pub fn new(domain: [Interval; 2], jet: F) -> Self {
        Self { domain, jet }
    }
}

impl<F: Fn(f64, f64) -> SurfaceJet> ParametricSurface for SurfaceFn<F> {
    fn domain(&self) -> [Interval; 2] {
        self.domain
    }
    fn jet(&self, u: f64, v: f64) -> SurfaceJet {
        (self.jet)(u, v)
    }
}
