//! Local minimisation of the distance on the patches: Newton's method with an active set.

use super::dispatch::vectorized;
use super::patch::PatchSet;
use nalgebra::Vector3;

/// A local step shorter than this, in units of the patch, may be the last one: the convergence is quadratic,
/// so that what remains is of the order of its square.
const LAST_STEP: f64 = 1e-7;

/// Next to a pole parameters tell little. The last step must also be short against the distance, or against the
/// size of the model.
const LAST_SHARE: [f64; 2] = [1e-4, 1e-10];

/// Speed, as a share of the size of the model, at which a parameter does not move the point: poles.
const STANDSTILL: f64 = 1e-12;

/// Curvature of the squared distance, as a share of that on a flat patch, that still tells a step length.
pub(super) const FLATTEST: f64 = 1e-12;

/// Square of the rounding error of a slope, as a share of squared speed and squared lengths: `(4 ε)²`.
pub(super) const SLOPE_NOISE_SQ: f64 = 16.0 * f64::EPSILON * f64::EPSILON;

/// A place on the model and its distance from the query.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Foot {
    pub(crate) patch: usize,
    /// Local parameters in `[0, 1]²`.
    pub(crate) local: [f64; 2],
    pub(crate) distance_sq: f64,
    /// Jets evaluated on the way.
    pub(crate) steps: u32,
    /// Whether the steps became negligible.
    pub(crate) settled: bool,
}

impl Foot {
    pub(crate) const NONE: Self =
        Self { patch: usize::MAX, local: [0.0; 2], distance_sq: f64::INFINITY, steps: 0, settled: false };
}

/// Newton's step for `|S − x|² / 2` in local parameters, restricted to the directions that are free.
struct Step {
    delta: [f64; 2],
}

/// Second order model of half the squared distance at a place.
struct Model {
    gradient: [f64; 2],
    hessian: [f64; 3],
    /// First fundamental form: the part of the Hessian that is never negative.
    metric: [f64; 3],
}

impl Model {
    /// The step in the free directions; where the Hessian is not positive definite, the direction of the first
    /// order iteration with the length that the amount of curvature along it tells, be it a hill or a valley.
    #[inline(always)]
    fn step(&self, free: [bool; 2]) -> Step {
        let [gs, gt] = self.gradient;
        let delta = match free {
            [true, true] => {
                let [hss, hst, htt] = self.hessian;
                let det = hss * htt - hst * hst;
                if det > 1e-12 * self.metric[0] * self.metric[2] && hss > 0.0 {
                    [(hst * gt - htt * gs) / det, (hst * gs - hss * gt) / det]
                } else {
                    self.damped()
                }
            }
            [true, false] => [self.along(0), 0.0],
            [false, true] => [0.0, self.along(1)],
            [false, false] => [0.0; 2],
        };
        Step { delta }
    }

    /// The step along one parameter line.
    #[inline(always)]
    fn along(&self, d: usize) -> f64 {
        let (h, g) = (self.hessian[2 * d], self.metric[2 * d]);
        let curvature = if h.abs() > FLATTEST * g { h.abs() } else { g };
        if curvature > 0.0 { -self.gradient[d] / curvature } else { 0.0 }
    }

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

impl<const K: usize> PatchSet<K> {
    /// Squared distance of `x` from the point of a patch at `local`.
    #[inline(always)]
    pub(crate) fn distance_sq(&self, x: &Vector3<f64>, patch: usize, local: [f64; 2]) -> f64 {
        let patch = &self.patches[patch];
        (self.point(patch, local[0], local[1]) - (x - patch.centre)).norm_squared()
    }

    /// Follows the distance downhill from a place, across smooth borders of patches, until the steps vanish.
    pub(crate) fn descend(&self, x: &Vector3<f64>, patch: usize, local: [f64; 2], max_steps: u32) -> Foot {
        vectorized(
            #[inline(always)]
            || self.descend_inline(x, patch, local, max_steps),
        )
    }

    #[inline(always)]
    fn descend_inline(&self, x: &Vector3<f64>, patch: usize, local: [f64; 2], max_steps: u32) -> Foot {
        let mut index = patch;
        let mut at = local;
        let mut best = Foot { patch, local, ..Foot::NONE };
        let mut steps = 0;
        let mut shrink = 1.0;
        let mut taken = [0.0f64; 2];
        loop {
            let patch = &self.patches[index];
            let y = x - patch.centre;
            let jet = self.jet(patch, at[0], at[1]);
            let r = jet.point - y;
            let distance_sq = r.norm_squared();
            steps += 1;
            let grown = distance_sq > best.distance_sq * (1.0 + 1e-14);
            if grown || !distance_sq.is_finite() {
                // Too far: back to the best place, and half of the step.
                if steps >= max_steps
                    || shrink < 1e-4
                    || taken[0].abs().max(taken[1].abs()) * shrink < LAST_STEP
                {
                    best.settled = steps < max_steps;
                    break;
                }
                shrink *= 0.5;
                let step = [taken[0] * shrink, taken[1] * shrink];
                (index, at) = self.walk(best.patch, best.local, step);
                continue;
            }
            best = Foot { patch: index, local: at, distance_sq, steps, settled: false };
            shrink = 1.0;
            let model = Model {
                gradient: [jet.du.dot(&r), jet.dv.dot(&r)],
                metric: [jet.du.norm_squared(), jet.du.dot(&jet.dv), jet.dv.norm_squared()],
                hessian: [
                    jet.du.norm_squared() + jet.duu.dot(&r),
                    jet.du.dot(&jet.dv) + jet.duv.dot(&r),
                    jet.dv.norm_squared() + jet.dvv.dot(&r),
                ],
            };
            // A bound is active where the distance would decrease beyond it and there is nothing beyond.
            let mut free = [true; 2];
            let mut level = true;
            let size_sq = self.size * self.size;
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
                    free[d] = self.cells[patch.shape].across(patch.cell, d, end).is_some();
                }
                let noise_sq = SLOPE_NOISE_SQ * (distance_sq + size_sq) * speed_sq;
                level &= !free[d] || model.gradient[d] * model.gradient[d] <= noise_sq;
            }
            if level {
                // Nothing but rounding errors is left of the slope.
                best.settled = true;
                break;
            }
            let mut step = model.step(free).delta;
            // A step that meets a bound in one direction is solved anew for the other.
            for d in 0..2 {
                let target = at[d] + step[d];
                let end = usize::from(target > 1.0);
                let outside = !(0.0..=1.0).contains(&target);
                if outside
                    && free[0]
                    && free[1]
                    && self.cells[patch.shape].across(patch.cell, d, end).is_none()
                {
                    step[d] = end as f64 - at[d];
                    let other = 1 - d;
                    let bent = model.hessian[2 * other];
                    if bent > 1e-3 * model.metric[2 * other] {
                        step[other] = -(model.gradient[other] + model.hessian[1] * step[d]) / bent;
                    }
                    break;
                }
            }
            let largest = step[0].abs().max(step[1].abs());
            if !largest.is_finite() {
                break;
            }
            if largest > 1.5 {
                step = [step[0] * 1.5 / largest, step[1] * 1.5 / largest];
            }
            let (next, target) = self.walk(index, at, step);
            let length_sq = step[0] * step[0] * model.metric[0] + step[1] * step[1] * model.metric[2];
            let short = LAST_SHARE[0] * LAST_SHARE[0] * distance_sq;
            let last = largest < LAST_STEP && length_sq <= short.max((LAST_SHARE[1] * self.size).powi(2));
            if last || steps >= max_steps || (next == index && target == at) {
                let distance_sq = self.distance_sq(x, next, target);
                if distance_sq <= best.distance_sq {
                    best.patch = next;
                    best.local = target;
                    best.distance_sq = distance_sq;
                }
                best.settled = last || (next == index && target == at);
                break;
            }
            taken = step;
            (index, at) = (next, target);
        }
        best.steps = steps;
        best
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
                let cells = &self.cells[patch.shape];
                let Some(cell) = cells.across(patch.cell, d, end) else { break };
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
