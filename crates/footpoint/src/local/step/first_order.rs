//! First order steps: projection onto the tangent line or plane.

use super::tangent::{CurveResidual, Tangent, along, surface_tangent};
use nalgebra::{SVector, Vector3};
use nurbs_core::{CurveJet, SurfaceJet};

/// `Δt = ⟨c', x − c⟩ / ⟨c', c'⟩`: the foot of `x` on the tangent ([HW05, eqs. (1)-(2)]).
///
/// `None` where `c' = 0`.
///
/// ```
/// # use footpoint::local::first_order_curve;
/// # use nurbs_core::{nalgebra::Vector2, CurveJet};
/// let jet = CurveJet { point: Vector2::new(1.0, 0.0), d1: Vector2::new(2.0, 0.0), d2: Vector2::zeros() };
/// assert_eq!(first_order_curve(&jet, &Vector2::new(4.0, 5.0)), Some(1.5));
/// ```
#[must_use]
pub fn first_order_curve<const D: usize>(jet: &CurveJet<D>, x: &SVector<f64, D>) -> Option<f64> {
    let r = CurveResidual::new(jet, x)?;
    Some(r.tangential / r.speed)
}

/// `(Δu, Δv)` of the foot of `x` on the tangent plane ([HW05, eqs. (9)-(11)]).
///
/// Where `s_u × s_v = 0`: the step along the longer of `s_u` and `s_v`; `None` if both vanish.
#[must_use]
pub fn first_order_surface(jet: &SurfaceJet, x: &Vector3<f64>) -> Option<[f64; 2]> {
    let w = x - jet.point;
    match surface_tangent(jet) {
        Tangent::Plane(plane) => Some(plane.coordinates(jet, &w)),
        Tangent::Line(0) => Some(along(0, w.dot(&jet.du) / jet.du.norm_squared())),
        Tangent::Line(_) => Some(along(1, w.dot(&jet.dv) / jet.dv.norm_squared())),
        Tangent::None => None,
    }
}
