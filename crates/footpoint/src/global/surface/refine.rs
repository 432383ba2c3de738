//! The last digits of a footpoint, and how many of them there are.
//!
//! A descent compares distances. Close to the shape these say little about parameters: a place that is `e` beside the
//! foot of a query at the distance `d` is further by `e² / 2d` only, which rounding hides for all `e` up to `√(2 ν d)`, with
//! `ν` the rounding error of a point. The slope of the distance tells the foot down to `e ≈ ν`. So a foot at which the
//! slope has not vanished is led on by the slope, as long as the distance does not grow by more than its rounding error.
//!
//! With `m` the unit roundoff `ε / 2`, positive weights and a net within `ρ` of its origin, a sum `Σ B w p / Σ B w` in Bernstein
//! form has an error of at most `(p + q + 4) · 2m · ρ`, since its terms add up to at most `ρ Σ B w` (\[Hig02, section 5.3\]). In powers
//! about the middle the coefficients are up to `2^(p + q)` times as large as the net, in which the largest weight `w₊` counts:
//! `2^(p + q) · (p + q + 4) · 2m · ρ w₊ / w`. Derivatives lose a factor of twice the degree more, the quotient another `w₊ / w`.

use crate::global::arithmetic::bernstein::basis_jet;
use crate::global::surface::descend::{Model, Move, dot};
use crate::global::surface::foot::Foot;
use crate::global::surface::geometry::{Geometry, Patch};
use crate::tolerance::STANDSTILL;
use nalgebra::Vector3;
use nurbs_core::{MAX_DEGREE, SurfaceJet};

/// Steps led by the slope: they converge quadratically.
pub(in crate::global) const MAX_STEPS: u32 = 6;

/// Rounding errors at a place.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Noise {
    /// Of a point, as a length.
    pub(crate) point: f64,
    /// Of a first derivative, as a length per unit of the parameter.
    pub(crate) tangent: f64,
}

impl Noise {
    /// For a patch of degrees that add up to `degrees` within `radius` of its origin, in powers or in Bernstein form, where the
    /// largest weight is `ratio` times the weight of the place.
    pub(in crate::global) fn new(degrees: usize, in_powers: bool, radius: f64, ratio: f64) -> Self {
        let sum = (degrees as f64 + 4.0) * f64::EPSILON * radius;
        let point = if in_powers { sum * ratio * (1u32 << degrees) as f64 } else { sum };
        Self { point, tangent: 2.0 * degrees as f64 * ratio * point }
    }

    /// That of the component of a connecting line of the given length along a tangent of the given speed.
    pub(crate) fn along(&self, distance: f64, speed: f64) -> f64 {
        self.point + f64::EPSILON * distance + distance * self.tangent / speed
    }

    /// The largest square of a distance that may be the same as that of a known place, but for rounding.
    pub(in crate::global) fn same_sq(&self, distance_sq: f64) -> f64 {
        let distance = distance_sq.sqrt() + 2.0 * self.point;
        distance * distance * (1.0 + 8.0 * f64::EPSILON)
    }
}

impl Geometry {
    /// A place at which the slope is smaller, next to one at which a descent has come to rest.
    #[cold]
    pub(crate) fn refine(&self, x: &Vector3<f64>, foot: &Foot, jet: &SurfaceJet) -> (Foot, SurfaceJet) {
        let (mut best, mut best_jet) = (*foot, *jet);
        let mut violation = self.violation_sq(x, &best, &best_jet);
        for _ in 0..MAX_STEPS {
            let patch = &self.patches[best.patch];
            let limit_sq = self.noise_at(patch, best.local).same_sq(best.distance_sq);
            let model = Model::new(&best_jet, &(best_jet.point - (x - patch.centre)));
            let Move::To { patch, local, .. } =
                self.advance(best.patch, best.local, &model, best.distance_sq)
            else {
                break;
            };
            let there = self.jet(&self.patches[patch], local[0], local[1]);
            let r = there.point - (x - self.patches[patch].centre);
            let next = Foot { patch, local, distance_sq: dot(&r, &r), steps: best.steps + 1, settled: true };
            let left = self.violation_sq(x, &next, &there);
            let better = next.distance_sq <= limit_sq && left < violation;
            if !better {
                break;
            }
            (best, best_jet, violation) = (next, there, left);
        }
        (best, best_jet)
    }

    /// Square of the largest component of the connecting line along a parameter line that leads on.
    fn violation_sq(&self, x: &Vector3<f64>, foot: &Foot, jet: &SurfaceJet) -> f64 {
        let r = jet.point - (x - self.patches[foot.patch].centre);
        let along = |d: usize| {
            let tangent = if d == 0 { &jet.du } else { &jet.dv };
            let (slope, speed_sq) = (tangent.dot(&r), tangent.norm_squared());
            let still = STANDSTILL * self.size;
            let free = speed_sq > still * still && !self.is_blocked(foot.patch, foot.local, d, slope);
            if free { slope * slope / speed_sq } else { 0.0 }
        };
        along(0).max(along(1))
    }

    /// Whether the distance with this slope falls beyond the border at which a place lies only, and nothing smooth follows.
    #[inline(always)]
    pub(crate) fn is_blocked(&self, patch: usize, local: [f64; 2], d: usize, slope: f64) -> bool {
        let outwards = (local[d] <= 0.0 && slope > 0.0) || (local[d] >= 1.0 && slope < 0.0);
        let patch = &self.patches[patch];
        let end = usize::from(local[d] >= 1.0);
        outwards && self.cells[patch.shape()].across(patch.cell(), d, end).is_none()
    }

    /// The rounding errors at a place.
    pub(crate) fn noise_at(&self, patch: &Patch, [s, t]: [f64; 2]) -> Noise {
        let [p, q] = patch.degrees();
        let mut ratio = 1.0;
        if patch.rational {
            let (mut bu, mut bv) = ([[0.0; 3]; MAX_DEGREE + 1], [[0.0; 3]; MAX_DEGREE + 1]);
            basis_jet(p, s, &mut bu[..=p]);
            basis_jet(q, t, &mut bv[..=q]);
            let net = self.net(patch).chunks(q + 1);
            let rows = net
                .zip(&bu)
                .map(|(row, b)| b[0] * row.iter().zip(&bv).map(|(point, b)| b[0] * point[3]).sum::<f64>());
            ratio = patch.max_weight_sq.sqrt() / rows.sum::<f64>();
        }
        Noise::new(p + q, patch.order() > 0, patch.radius, ratio)
    }

    /// Whether the slope at a place is as small as its rounding error.
    #[cold]
    pub(crate) fn is_level(&self, x: &Vector3<f64>, foot: &Foot, jet: &SurfaceJet) -> bool {
        let patch = &self.patches[foot.patch];
        let r = jet.point - (x - patch.centre);
        let (distance, noise) = (r.norm(), self.noise_at(patch, foot.local));
        [&jet.du, &jet.dv].into_iter().enumerate().all(|(d, tangent)| {
            let (slope, speed) = (tangent.dot(&r), tangent.norm());
            slope.abs() <= speed * noise.along(distance, speed)
                || self.is_blocked(foot.patch, foot.local, d, slope)
        })
    }
}
