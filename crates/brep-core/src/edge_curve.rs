//! Evaluation of edge curves.

use crate::description::EdgeCurve;
use footpoint::CurveProjector;
use nalgebra::Vector3;
use nurbs_core::{CurveJet, ParametricCurve};
use std::f64::consts::TAU;

impl EdgeCurve {
    /// Point and derivatives at `t`.
    #[must_use]
    pub fn jet(&self, t: f64) -> CurveJet<3> {
        match self {
            Self::Line { origin, direction } => {
                CurveJet { point: origin + direction * t, d1: *direction, d2: Vector3::zeros() }
            }
            Self::Circle { frame, radius } => {
                let (s, c) = t.sin_cos();
                let outwards = (frame.x() * c + frame.y() * s) * *radius;
                CurveJet {
                    point: frame.origin() + outwards,
                    d1: (frame.y() * c - frame.x() * s) * *radius,
                    d2: -outwards,
                }
            }
            Self::Ellipse { frame, semi_axes: [a, b] } => {
                let (s, c) = t.sin_cos();
                let outwards = frame.x() * (a * c) + frame.y() * (b * s);
                CurveJet {
                    point: frame.origin() + outwards,
                    d1: frame.y() * (b * c) - frame.x() * (a * s),
                    d2: -outwards,
                }
            }
            Self::Nurbs(curve) => curve.jet(t),
        }
    }

    /// The point at `t`.
    #[must_use]
    pub fn point(&self, t: f64) -> Vector3<f64> {
        match self {
            Self::Line { origin, direction } => origin + direction * t,
            Self::Nurbs(curve) => curve.point(t),
            _ => self.jet(t).point,
        }
    }

    /// Period of the parameter; `None` for lines and for B-splines with ends.
    #[must_use]
    pub fn period(&self) -> Option<f64> {
        match self {
            Self::Line { .. } => None,
            Self::Circle { .. } | Self::Ellipse { .. } => Some(TAU),
            Self::Nurbs(curve) => curve.period(),
        }
    }

    /// A parameter of a point on the curve; for a point beside the curve that of its foot, but on an ellipse, where
    /// it is the one of the point on the same ray of the affine image of the circle.
    ///
    /// Angles are in `(−π, π]`.
    #[must_use]
    pub fn parameter_of(&self, x: &Vector3<f64>) -> f64 {
        match self {
            Self::Line { origin, direction } => (x - origin).dot(direction) / direction.norm_squared(),
            Self::Circle { frame, .. } => {
                let local = frame.local(x);
                local.y.atan2(local.x)
            }
            Self::Ellipse { frame, semi_axes: [a, b] } => {
                let local = frame.local(x);
                (local.y / b).atan2(local.x / a)
            }
            Self::Nurbs(curve) => CurveProjector::new(curve).project(x).parameter,
        }
    }
}
