//! Second order steps on curves: projection onto the curvature circle.
//!
//! Both formulas of \[HW05\] turn the foot `q` on the circle into a parameter increment through the
//! second order Taylor polynomial of the curve. They are evaluated in closed form, valid in every
//! dimension; areas and the circle's centre, which lose digits near a foot, do not occur.

use super::circle::Circle;
use super::tangent::CurveResidual;
use nalgebra::SVector;
use nurbs_core::CurveJet;

/// `Δt` from the chord: `|Δt| = |q − c| / |c'|`, with the sign of `⟨c', q − c⟩` ([HW05, eqs. (7)-(8)]).
///
/// For a test point beyond the centre of curvature the foot lies on the far side of the circle and the
/// step is about its diameter. `None` where `c' = 0`.
#[must_use]
pub fn second_order_curve<const D: usize>(jet: &CurveJet<D>, x: &SVector<f64, D>) -> Option<f64> {
    let r = CurveResidual::new(jet, x)?;
    if r.tangential == 0.0 {
        return Some(0.0);
    }
    Some(r.tangential / r.speed * Circle::new(r.tangential, r.curvature, r.offset).chord_factor())
}

/// `Δt` from the Taylor polynomial in the plane of `c'` and `c''` ([HW05, eq. (5)]).
///
/// In any dimension `Δt = L/(h|c'|) − ⟨c',c''⟩/|c'|⁴ · L²/(h(h+m))`. The formula of the paper's Tables 1-3.
/// It has false fixed points (wherever `q − c` is parallel to `c''`) and its sign may point away from the
/// foot. For points on the curve (inversion) it converges with order 3. `None` where `c' = 0`.
#[must_use]
pub fn second_order_taylor_curve<const D: usize>(jet: &CurveJet<D>, x: &SVector<f64, D>) -> Option<f64> {
    let r = CurveResidual::new(jet, x)?;
    if r.tangential == 0.0 {
        return Some(0.0);
    }
    let circle = Circle::new(r.tangential, r.curvature, r.offset);
    let first = r.tangential / r.speed;
    Some(first * circle.tangential_factor() - r.stretch * first * first * circle.half_square_factor())
}
