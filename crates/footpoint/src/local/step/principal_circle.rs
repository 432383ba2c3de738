//! The principal-circle step: a curvature circle for each principal direction.
//!
//! One normal section cannot describe a surface to the second order. The quadratic model of the
//! distance at a foot is diagonal in the principal directions, so the tangential residual is taken
//! apart there, each part projected onto the circle of its own normal curvature, and the sum turned
//! back into `(Δu, Δv)` by the first derivatives. The same jet, quadratic convergence, and since all
//! factors are positive always a direction in which the distance decreases.

use super::circle::Circle;
use super::tangent::{CurveResidual, PrincipalTangents, Tangent, along, parameter_line, surface_tangent};
use nalgebra::{SVector, Vector3};
use nurbs_core::{CurveJet, SurfaceJet};

/// `Δt = ⟨q − c, c'⟩ / |c'|²` with `q` the foot on the curvature circle.
///
/// Eq. (5) of \[HW05\] without its term in `⟨c', c''⟩`: the same order, no false fixed points.
/// `None` where `c' = 0`.
#[must_use]
pub fn principal_circle_curve<const D: usize>(jet: &CurveJet<D>, x: &SVector<f64, D>) -> Option<f64> {
    let r = CurveResidual::new(jet, x)?;
    let circle = Circle::new(r.tangential, r.curvature, r.offset);
    Some(r.tangential / r.speed * circle.tangential_factor())
}

/// `(Δu, Δv)` from the curvature circles of the two principal normal sections.
///
/// Where `s_u × s_v = 0`: [`principal_circle_curve`] along the longer of `s_u` and `s_v`; `None` if both
/// vanish.
#[must_use]
pub fn principal_circle_surface(jet: &SurfaceJet, x: &Vector3<f64>) -> Option<[f64; 2]> {
    match surface_tangent(jet) {
        Tangent::Plane(plane) => {
            let w = x - jet.point;
            let principal = PrincipalTangents::new(&plane, jet);
            let normal = w.dot(&plane.normal);
            let mut step = [0.0; 2];
            for i in 0..2 {
                let (tangential, curvature) = (w.dot(&principal.axes[i]), principal.curvatures[i]);
                let length =
                    tangential * Circle::new(tangential, curvature, curvature * normal).tangential_factor();
                for k in 0..2 {
                    step[k] += length * principal.increments[i][k];
                }
            }
            Some(step)
        }
        Tangent::Line(direction) => {
            let delta = principal_circle_curve(&parameter_line(jet, direction), x)?;
            Some(along(direction, delta))
        }
        Tangent::None => None,
    }
}
