//! The second order step on surfaces: projection onto the curvature circle of one normal section.

use super::circle::Circle;
use super::second_order_curve::second_order_curve;
use super::tangent::{Tangent, TangentPlane, along, parameter_line, surface_tangent};
use nalgebra::Vector3;
use nurbs_core::SurfaceJet;

/// `(Δu, Δv)` from the normal section through `x` ([HW05, eqs. (12)-(15)], increment by eq. (7)).
///
/// The section's circle knows the normal curvature in the direction of the tangential residual only, so
/// the iteration converges linearly, with rate `|a − b| / (a + b)` at worst, `a, b = 1 − dκ₁, 1 − dκ₂`;
/// [`principal_circle_surface`](super::principal_circle_surface) converges quadratically.
///
/// Where `s_u × s_v = 0`: [`second_order_curve`] along the longer of `s_u` and `s_v`; `None` if both vanish.
#[must_use]
pub fn second_order_surface(jet: &SurfaceJet, x: &Vector3<f64>) -> Option<[f64; 2]> {
    section_step(jet, x, Circle::chord_factor)
}

/// As [`second_order_surface`], with the increment by eq. (5) instead of eq. (7).
///
/// The section is taken parameterised by arc length, `⟨c', c''⟩ = 0`, as it has no parameterisation of
/// its own: `Δt = 1/h`.
#[must_use]
pub fn second_order_taylor_surface(jet: &SurfaceJet, x: &Vector3<f64>) -> Option<[f64; 2]> {
    section_step(jet, x, Circle::tangential_factor)
}

fn section_step(jet: &SurfaceJet, x: &Vector3<f64>, factor: fn(&Circle) -> f64) -> Option<[f64; 2]> {
    match surface_tangent(jet) {
        Tangent::Plane(plane) => {
            let [p, q] = plane.coordinates(jet, &(x - jet.point));
            let factor = section_circle(&plane, jet, x, [p, q]).map_or(0.0, |circle| factor(&circle));
            Some([p * factor, q * factor])
        }
        Tangent::Line(direction) => {
            let delta = second_order_curve(&parameter_line(jet, direction), x)?;
            Some(along(direction, delta))
        }
        Tangent::None => None,
    }
}

/// The circle of the normal section in the direction `λ¹ s_u + λ² s_v`; `None` when that vanishes.
fn section_circle(
    plane: &TangentPlane,
    jet: &SurfaceJet,
    x: &Vector3<f64>,
    [p, q]: [f64; 2],
) -> Option<Circle> {
    let form = |[a, b, c]: [f64; 3]| a * p * p + 2.0 * b * p * q + c * q * q;
    let length_sq = form(plane.first);
    if length_sq <= 0.0 {
        return None;
    }
    // Eq. (13); the tangent vector (14) is the tangential residual itself, so L = |c'|.
    let curvature = form(plane.second) / length_sq;
    let offset = curvature * (x - jet.point).dot(&plane.normal);
    Some(Circle::new(length_sq.sqrt(), curvature, offset))
}
