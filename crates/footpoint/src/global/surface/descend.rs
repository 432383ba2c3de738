//! Local minimisation of the distance on the patches: Newton's method with an active set.

use crate::global::arithmetic::simd::vectorized;
use crate::global::surface::foot::Foot;
use crate::global::surface::geometry::{Geometry, Patch};
use nalgebra::Vector3;
use nurbs_core::SurfaceJet;

/// A local step shorter than this, in units of the patch, may be the last one: the convergence is quadratic,
/// so that what remains is of the order of its square.
pub(in crate::global) const LAST_STEP: f64 = 1e-7;

/// Next to a pole parameters tell little. The last step must also be short against the distance, or against the
/// size of the model.
pub(in crate::global) const LAST_SHARE: [f64; 2] = [1e-4, 1e-10];

/// Speed, as a share of the size of the model, at which a parameter does not move the point: poles.
pub(in crate::global) const STANDSTILL: f64 = 1e-12;

/// Curvature of the squared distance, as a share of that on a flat patch, that still tells a step length.
pub(in crate::global) const FLATTEST: f64 = 1e-12;

/// Square of the rounding error of a slope, as a share of squared speed and squared lengths: `(4 ε)²`.
pub(in crate::global) const SLOPE_NOISE_SQ: f64 = 16.0 * f64::EPSILON * f64::EPSILON;

/// Relative growth of the squared distance that may be a rounding error.
pub(in crate::global) const GROWTH: f64 = 1.0 + 1e-14;

/// Least share of a step that is tried when the distance grows.
const LEAST_SHARE: f64 = 1e-4;

/// Determinant of the Hessian, as a share of that of a flat patch, down to which Newton's step is taken.
pub(in crate::global) const DEFINITE: f64 = 1e-12;

/// Second order model of half the squared distance at a place.
pub(in crate::global) struct Model {
    pub(in crate::global) gradient: [f64; 2],
    pub(in crate::global) hessian: [f64; 3],
    /// First fundamental form: the part of the Hessian that is never negative.
    pub(in crate::global) metric: [f64; 3],
}

/// What the model says about where to go.
pub(in crate::global) enum Move {
    /// Nothing but rounding errors is left of the slope.
    Rest,
    /// Numbers that are not finite.
    Stop,
    /// A step to another place. It is the last one if it is negligible.
    To { patch: usize, local: [f64; 2], step: [f64; 2], last: bool },
}

#[inline(always)]
pub(in crate::global) fn dot(a: &Vector3<f64>, b: &Vector3<f64>) -> f64 {
    (a.x * b.x + a.y * b.y) + a.z * b.z
}

impl Model {
    #[inline(always)]
    pub(in crate::global) fn new(jet: &SurfaceJet, r: &Vector3<f64>) -> Self {
        let metric = [dot(&jet.du, &jet.du), dot(&jet.du, &jet.dv), dot(&jet.dv, &jet.dv)];
        Self {
            gradient: [dot(&jet.du, r), dot(&jet.dv, r)],
            metric,
            hessian: [
                metric[0] + dot(&jet.duu, r),
                metric[1] + dot(&jet.duv, r),
                metric[2] + dot(&jet.dvv, r),
            ],
        }
    }

    /// The step in the free directions; where the Hessian is not positive definite, the direction of the first
    /// order iteration with the length that the amount of curvature along it tells, be it a hill or a valley.
    #[inline(always)]
    fn step(&self, free: [bool; 2]) -> [f64; 2] {
        let [gs, gt] = self.gradient;
        match free {
            [true, true] => {
                let [hss, hst, htt] = self.hessian;
                let det = hss * htt - hst * hst;
                if det > DEFINITE * self.metric[0] * self.metric[2] && hss > 0.0 {
                    let inverse = 1.0 / det;
                    [(hst * gt - htt * gs) * inverse, (hst * gs - hss * gt) * inverse]
                } else {
                    self.damped()
                }
            }
            [true, false] => [self.along(0), 0.0],
            [false, true] => [0.0, self.along(1)],
            [false, false] => [0.0; 2],
        }
    }

    /// The step along one parameter line.
    #[inline(always)]
    fn along(&self, d: usize) -> f64 {
        let (h, g) = (self.hessian[2 * d], self.metric[2 * d]);
        let curvature = if h.abs() > FLATTEST * g { h.abs() } else { g };
        if curvature > 0.0 { -self.gradient[d] / curvature } else { 0.0 }
    }

    #[cold]
    fn damped(&self) -> [f64; 2] {
        let [gs, gt] = self.gradient;
        let [ess, est, ett] = self.metric;
        let det = ess * ett - est * est;
        if det <= 1e-14 * ess * ett || !det.is_finite() {
            // A pole: one direction carries no length; move in the other.
            return if ess > ett { [self.along(0), 0.0] } else { [0.0, self.along(1)] };
        }
        let d = [(est * gt - ett * gs) / det, (est * gs - ess * gt) / det];
        let quadratic = |m: &[f64; 3]| m[0] * d[0] * d[0] + 2.0 * m[1] * d[0] * d[1] + m[2] * d[1] * d[1];
        let length = quadratic(&self.metric);
        let ratio = if length > 0.0 { (quadratic(&self.hessian) / length).abs() } else { 1.0 };
        let factor = if ratio > FLATTEST { 1.0 / ratio } else { 1.0 };
        [d[0] * factor, d[1] * factor]
    }
}

/// The jet a short step away: Taylor's polynomials, whose errors are far below those of rounding.
#[inline(always)]
pub(in crate::global) fn moved(jet: &SurfaceJet, [s, t]: [f64; 2]) -> SurfaceJet {
    SurfaceJet {
        point: jet.point
            + ((jet.du + (jet.duu * (0.5 * s) + jet.duv * t)) * s + (jet.dv + jet.dvv * (0.5 * t)) * t),
        du: jet.du + (jet.duu * s + jet.duv * t),
        dv: jet.dv + (jet.duv * s + jet.dvv * t),
        ..*jet
    }
}

impl Geometry {
    /// Squared distance of `x` from the point of a patch at `local`.
    #[inline(always)]
    pub(crate) fn distance_sq(&self, x: &Vector3<f64>, patch: usize, local: [f64; 2]) -> f64 {
        let patch = &self.patches[patch];
        let r = self.point(patch, local[0], local[1]) - (x - patch.centre);
        dot(&r, &r)
    }

    /// Whether the distance at a place does not exceed that of the place before.
    #[inline(always)]
    pub(crate) fn falls(&self, x: &Vector3<f64>, patch: usize, local: [f64; 2], before_sq: f64) -> bool {
        before_sq == f64::INFINITY || self.distance_sq(x, patch, local) <= before_sq * GROWTH
    }

    /// Follows the distance downhill from a place, across smooth borders of patches, until the steps vanish.
    pub(crate) fn descend(&self, x: &Vector3<f64>, patch: usize, local: [f64; 2], max_steps: u32) -> Foot {
        self.descend_to_jet(x, patch, local, max_steps).0
    }

    /// As [`descend`](Self::descend), with the jet at the foot.
    pub(crate) fn descend_to_jet(
        &self,
        x: &Vector3<f64>,
        patch: usize,
        local: [f64; 2],
        max_steps: u32,
    ) -> (Foot, SurfaceJet) {
        vectorized(
            #[inline(always)]
            || self.descend_inline(x, patch, local, max_steps),
        )
    }

    #[inline(always)]
    fn descend_inline(
        &self,
        x: &Vector3<f64>,
        patch: usize,
        local: [f64; 2],
        max_steps: u32,
    ) -> (Foot, SurfaceJet) {
        let mut index = patch;
        let mut at = local;
        let mut best = Foot { patch, local, ..Foot::NONE };
        let mut steps = 0;
        let mut shrink = 1.0;
        let mut taken = [0.0f64; 2];
        loop {
            let patch = &self.patches[index];
            let jet = self.jet(patch, at[0], at[1]);
            let r = jet.point - (x - patch.centre);
            let distance_sq = dot(&r, &r);
            steps += 1;
            let grown = distance_sq > best.distance_sq * GROWTH;
            if grown || !distance_sq.is_finite() {
                // Too far: back to the best place, and half of the step.
                if steps >= max_steps
                    || shrink < LEAST_SHARE
                    || taken[0].abs().max(taken[1].abs()) * shrink < LAST_STEP
                {
                    best.settled = steps < max_steps;
                    best.steps = steps;
                    let [s, t] = best.local;
                    return (best, self.jet(&self.patches[best.patch], s, t));
                }
                shrink *= 0.5;
                let step = [taken[0] * shrink, taken[1] * shrink];
                (index, at) = self.walk(best.patch, best.local, step);
                continue;
            }
            best = Foot { patch: index, local: at, distance_sq, steps, settled: false };
            shrink = 1.0;
            match self.advance(index, at, &Model::new(&jet, &r), distance_sq) {
                Move::Rest => {
                    best.settled = true;
                    return (best, jet);
                }
                Move::Stop => return (best, jet),
                Move::To { patch, local, step, last } => {
                    if last || steps >= max_steps {
                        best.settled = last;
                        return self.land(x, best, &jet, (patch, local), step, last);
                    }
                    taken = step;
                    (index, at) = (patch, local);
                }
            }
        }
    }

    /// Takes the last step, to a target, or as much of it as does not let the distance grow.
    #[inline(always)]
    pub(in crate::global) fn land(
        &self,
        x: &Vector3<f64>,
        foot: Foot,
        jet: &SurfaceJet,
        mut target: (usize, [f64; 2]),
        step: [f64; 2],
        short: bool,
    ) -> (Foot, SurfaceJet) {
        let mut shrink = 1.0;
        loop {
            let (index, local) = target;
            let patch = &self.patches[index];
            let there = if short && index == foot.patch {
                moved(jet, [local[0] - foot.local[0], local[1] - foot.local[1]])
            } else {
                self.jet(patch, local[0], local[1])
            };
            let r = there.point - (x - patch.centre);
            let distance_sq = dot(&r, &r);
            if distance_sq <= foot.distance_sq * GROWTH {
                return (Foot { patch: index, local, distance_sq, ..foot }, there);
            }
            shrink *= 0.5;
            if short || shrink < LEAST_SHARE {
                return (foot, *jet);
            }
            target = self.walk(foot.patch, foot.local, [step[0] * shrink, step[1] * shrink]);
        }
    }

    /// Where the model of a place leads to.
    #[inline(always)]
    pub(in crate::global) fn advance(
        &self,
        index: usize,
        at: [f64; 2],
        model: &Model,
        distance_sq: f64,
    ) -> Move {
        let patch = &self.patches[index];
        let size_sq = self.size * self.size;
        // A bound is active where the distance would decrease beyond it and there is nothing beyond.
        let mut free = [true; 2];
        let mut level = true;
        for d in 0..2 {
            let speed_sq = model.metric[2 * d];
            if speed_sq <= STANDSTILL * STANDSTILL * size_sq {
                free[d] = false;
                continue;
            }
            let pushes_out =
                (at[d] <= 0.0 && model.gradient[d] > 0.0) || (at[d] >= 1.0 && model.gradient[d] < 0.0);
            if pushes_out {
                let end = usize::from(at[d] >= 1.0);
                free[d] = self.cells[patch.shape()].across(patch.cell(), d, end).is_some();
            }
            let noise_sq = SLOPE_NOISE_SQ * (distance_sq + size_sq) * speed_sq;
            level &= !free[d] || model.gradient[d] * model.gradient[d] <= noise_sq;
        }
        if level {
            return Move::Rest;
        }
        let mut step = model.step(free);
        let inside = |x: f64| (0.0..=1.0).contains(&x);
        let mut local = [at[0] + step[0], at[1] + step[1]];
        let mut next = index;
        if !(inside(local[0]) && inside(local[1])) {
            if free[0] && free[1] {
                self.bend(patch, at, model, &mut step);
            }
            let largest = step[0].abs().max(step[1].abs());
            if !largest.is_finite() {
                return Move::Stop;
            }
            if largest > 1.5 {
                step = [step[0] * 1.5 / largest, step[1] * 1.5 / largest];
            }
            (next, local) = self.walk(index, at, step);
        }
        let largest = step[0].abs().max(step[1].abs());
        let length_sq = step[0] * step[0] * model.metric[0] + step[1] * step[1] * model.metric[2];
        let last = largest < LAST_STEP && length_sq <= self.short_sq(distance_sq);
        Move::To { patch: next, local, step, last: last || (next == index && local == at) }
    }

    /// Squared length down to which a step may be the last one.
    #[inline(always)]
    pub(in crate::global) fn short_sq(&self, distance_sq: f64) -> f64 {
        let floor = LAST_SHARE[1] * self.size;
        (LAST_SHARE[0] * LAST_SHARE[0] * distance_sq).max(floor * floor)
    }

    /// A step that meets a bound in one direction is solved anew for the other.
    #[inline(always)]
    fn bend(&self, patch: &Patch, at: [f64; 2], model: &Model, step: &mut [f64; 2]) {
        for d in 0..2 {
            let target = at[d] + step[d];
            let end = usize::from(target > 1.0);
            let outside = !(0.0..=1.0).contains(&target);
            if outside && self.cells[patch.shape()].across(patch.cell(), d, end).is_none() {
                step[d] = end as f64 - at[d];
                let other = 1 - d;
                let bent = model.hessian[2 * other];
                if bent > 1e-3 * model.metric[2 * other] {
                    step[other] = -(model.gradient[other] + model.hessian[1] * step[d]) / bent;
                }
                return;
            }
        }
    }

    /// The place reached by a local step: across smooth borders into other patches, stopped at the others.
    #[inline(always)]
    pub(crate) fn walk(&self, mut index: usize, from: [f64; 2], step: [f64; 2]) -> (usize, [f64; 2]) {
        let mut to = [from[0] + step[0], from[1] + step[1]];
        for d in 0..2 {
            // At most three borders: steps are limited to one patch and a half.
            for _ in 0..3 {
                if (0.0..=1.0).contains(&to[d]) {
                    break;
                }
                let end = usize::from(to[d] > 1.0);
                let patch = &self.patches[index];
                let cells = &self.cells[patch.shape()];
                let Some(cell) = cells.across(patch.cell(), d, end) else { break };
                let other = cells.patch(cell);
                let beyond = if end == 0 { -to[d] } else { to[d] - 1.0 };
                let scaled = beyond * patch.intervals[d].length() / self.patches[other].intervals[d].length();
                to[d] = if end == 0 { 1.0 - scaled } else { scaled };
                index = other;
            }
            to[d] = to[d].clamp(0.0, 1.0);
        }
        (index, to)
    }
}
