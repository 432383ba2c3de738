//! Newton's method for the squared distance.

use super::principal_circle::{principal_circle_curve, principal_circle_surface};
use super::tangent::{Tangent, surface_tangent};
use nalgebra::{SVector, Vector3};
use nurbs_core::{CurveJet, SurfaceJet};

/// Share of the sum of its two parts' magnitudes that the second derivative must exceed: below, its
/// sign is a matter of rounding.
const DEFINITE: f64 = 1e-12;

/// `Δt = ⟨x − c, c'⟩ / (⟨c', c'⟩ − ⟨x − c, c''⟩)` ([PT97, eq. (6.3)]).
///
/// Where the second derivative of the squared distance is not positive Newton's step would climb:
/// [`principal_circle_curve`] is taken instead. `None` where `c' = 0`.
#[must_use]
pub fn newton_curve<const D: usize>(jet: &CurveJet<D>, x: &SVector<f64, D>) -> Option<f64> {
    let w = x - jet.point;
    let (first, bend) = (jet.d1.norm_squared(), w.dot(&jet.d2));
    if first.is_normal() && first - bend > DEFINITE * (first + bend.abs()) {
        Some(w.dot(&jet.d1) / (first - bend))
    } else {
        principal_circle_curve(jet, x)
    }
}

/// Newton's step for `½|x − s(u, v)|²` ([PT97, eq. (6.5)]).
///
/// Where the Hessian is not positive definite, [`principal_circle_surface`] is taken instead. Singular
/// points as there.
#[must_use]
pub fn newton_surface(jet: &SurfaceJet, x: &Vector3<f64>) -> Option<[f64; 2]> {
    let Tangent::Plane(plane) = surface_tangent(jet) else {
        return principal_circle_surface(jet, x);
    };
    let w = x - jet.point;
    let [g11, g12, g22] = plane.first;
    let (a, b, c) = (g11 - w.dot(&jet.duu), g12 - w.dot(&jet.duv), g22 - w.dot(&jet.dvv));
    let determinant = a * c - b * b;
    if !(a > 0.0 && c > 0.0 && determinant > DEFINITE * a * c) {
        return principal_circle_surface(jet, x);
    }
    let (p, q) = (w.dot(&jet.du), w.dot(&jet.dv));
    Some([(c * p - b * q) / determinant, (a * q - b * p) / determinant])
}
