//! The choice of a local method.

use super::step;
use nalgebra::{SVector, Vector3};
use nurbs_core::{CurveJet, SurfaceJet};

/// The step that a local iteration repeats.
///
/// | method | curves | surfaces |
/// |---|---|---|
/// | `FirstOrder` | linear | linear, may diverge |
/// | `SecondOrder` | quadratic | linear |
/// | `SecondOrderTaylor` | quadratic, cubic for points on the curve | linear |
/// | `PrincipalCircle` | quadratic | quadratic |
/// | `Newton` | quadratic | quadratic |
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(rename_all = "snake_case"))]
pub enum Method {
    /// Foot on the tangent line or plane ([HW05, eqs. (1)-(2), (9)-(11)]).
    FirstOrder,
    /// Foot on the curvature circle, of the normal section on surfaces, increment by the chord
    /// ([HW05, eqs. (7)-(8), (12)-(15)]).
    SecondOrder,
    /// The same with the increment by the Taylor polynomial ([HW05, eq. (5)]).
    SecondOrderTaylor,
    /// Feet on the curvature circles of both principal directions: the default.
    #[default]
    PrincipalCircle,
    /// Newton's method, with the principal-circle step where the Hessian is not positive definite.
    Newton,
}

impl Method {
    /// All methods.
    pub const ALL: [Self; 5] =
        [Self::FirstOrder, Self::SecondOrder, Self::SecondOrderTaylor, Self::PrincipalCircle, Self::Newton];

    /// `Δt` of one step; `None` where `c' = 0`.
    #[must_use]
    pub fn curve_step<const D: usize>(self, jet: &CurveJet<D>, x: &SVector<f64, D>) -> Option<f64> {
        match self {
            Self::FirstOrder => step::first_order_curve(jet, x),
            Self::SecondOrder => step::second_order_curve(jet, x),
            Self::SecondOrderTaylor => step::second_order_taylor_curve(jet, x),
            Self::PrincipalCircle => step::principal_circle_curve(jet, x),
            Self::Newton => step::newton_curve(jet, x),
        }
    }

    /// `(Δu, Δv)` of one step; `None` where both first derivatives vanish.
    #[must_use]
    pub fn surface_step(self, jet: &SurfaceJet, x: &Vector3<f64>) -> Option<[f64; 2]> {
        match self {
            Self::FirstOrder => step::first_order_surface(jet, x),
            Self::SecondOrder => step::second_order_surface(jet, x),
            Self::SecondOrderTaylor => step::second_order_taylor_surface(jet, x),
            Self::PrincipalCircle => step::principal_circle_surface(jet, x),
            Self::Newton => step::newton_surface(jet, x),
        }
    }

    /// `Δt` of one step in the direction in which the distance decreases; `None` where `c' = 0`.
    ///
    /// Eq. (5) shrinks to nothing at its false fixed points and points away from the foot beyond them:
    /// where it differs much from the principal-circle step, to which it tends at a foot, that one is taken.
    pub(crate) fn descending_curve_step<const D: usize>(
        self,
        jet: &CurveJet<D>,
        x: &SVector<f64, D>,
    ) -> Option<f64> {
        let circle = step::principal_circle_curve(jet, x)?;
        let trusted = |delta: &f64| {
            let ratio = delta / circle;
            ratio.is_finite()
                && ratio > 0.0
                && (self != Self::SecondOrderTaylor || (0.25..4.0).contains(&ratio))
        };
        Some(self.curve_step(jet, x).filter(trusted).unwrap_or(circle))
    }
}
