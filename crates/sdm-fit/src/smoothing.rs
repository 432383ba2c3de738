//! The factor of the energy: schedules, and generalised cross validation.

use crate::assemble::Normal;
use crate::freedom::Freedom;
use crate::layout::{Blocks, Layout};
use crate::noise::Noise;
use crate::options::Smoothing;
use nalgebra::SVector;

/// Factors tried: powers of ten from the last down to the first, then finer around the best.
const DECADES: [i32; 2] = [-14, 1];
const BETWEEN: [f64; 6] = [-0.75, -0.5, -0.25, 0.25, 0.5, 0.75];
/// Decades in a row without a better score after which smaller factors are not tried.
const WORSE: usize = 4;
/// Around a value that was found before, and beyond when the best is one of the outermost.
const AROUND: [f64; 5] = [-0.5, -0.25, 0.0, 0.25, 0.5];
const BEYOND: f64 = 0.5;
/// How much a degree of freedom counts: above 1, since the score by itself is easily misled to too little smoothing.
const CAUTION: f64 = 1.4;
/// Where distances are this share of the radius of curvature, a shape can follow the noise in more ways than the
/// linearised problem knows: then more smoothing counts as good, up to this share of what noise leaves in the shape.
const BENT: f64 = 0.1;
const MOST: f64 = 0.5;
/// Relative accuracy of scores that are estimated.
const ESTIMATED: f64 = 0.002;
/// A score that is worse by more than this share of the best is never as good.
const AS_GOOD: f64 = 0.1;
/// Unknowns up to which the trace is exact; above it is estimated from random vectors.
const EXACT: usize = 100;
/// Number of random vectors.
const PROBES: usize = 24;
const LEAST_PROBES: usize = 4;
/// Factor between two values of `λ` that count as the same.
const SAME: f64 = 1.3;
/// While the next value is at least this many times the last estimate, no other is made: it is on its way down.
const FAR: f64 = 4.0;
/// Iterations after which the automatic value is kept.
const SETTLED: usize = 48;
/// Below this a continuation to 0 has arrived.
const NOTHING: f64 = 1e-16;

/// The estimate of the factor of the energy from the data.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum LambdaEstimate {
    /// The estimated factor.
    Lambda(f64),
    /// Residuals of neighbours are correlated: they are lack of fit, not noise.
    NoNoise,
    /// No estimate was made, or no factor has a finite score.
    NotMade,
}

/// The factor of the energy in the course of the iteration.
#[derive(Clone, Debug)]
pub(crate) struct Schedule {
    smoothing: Smoothing,
    pub(crate) lambda: f64,
    /// Iterations whose estimate was about the present value.
    agreed: usize,
    /// The last estimate.
    pub(crate) estimate: Option<f64>,
    iteration: usize,
}

impl Schedule {
    pub(crate) fn new(smoothing: Smoothing) -> Self {
        let lambda = match smoothing {
            Smoothing::Fixed { lambda } => lambda,
            Smoothing::Continuation { start, .. } | Smoothing::Automatic { start, .. } => start,
        };
        Self { smoothing, lambda, agreed: 0, estimate: None, iteration: 0 }
    }

    /// Whether an estimate is made in this iteration.
    pub(crate) fn needs_estimate(&self) -> bool {
        let Smoothing::Automatic { factor, .. } = self.smoothing else { return false };
        let near = self.estimate.is_none_or(|estimate| self.lambda * factor < FAR * estimate);
        near && self.iteration >= 2 && self.iteration < SETTLED && self.agreed < 3
    }

    /// The value for the next iteration after an estimate.
    pub(crate) fn advance(&mut self, made: LambdaEstimate) {
        self.iteration += 1;
        match self.smoothing {
            Smoothing::Fixed { .. } => {}
            Smoothing::Continuation { factor, floor, .. } => {
                self.lambda = (self.lambda * factor).max(floor);
                if self.lambda < NOTHING {
                    self.lambda = floor;
                }
            }
            Smoothing::Automatic { factor, .. } => match made {
                LambdaEstimate::Lambda(estimate) => {
                    self.estimate = Some(estimate);
                    let same = self.lambda <= estimate * SAME && estimate <= self.lambda * SAME;
                    self.agreed = if same { self.agreed + 1 } else { 0 };
                    self.lambda = estimate.max(self.lambda * factor);
                }
                LambdaEstimate::NoNoise => {
                    self.lambda *= factor;
                    self.agreed = 0;
                }
                LambdaEstimate::NotMade if self.iteration <= 2 => self.lambda *= factor,
                LambdaEstimate::NotMade => {
                    if let Some(estimate) = self.estimate.filter(|estimate| *estimate < self.lambda) {
                        self.lambda = estimate.max(self.lambda * factor);
                    }
                }
            },
        }
    }

    /// Whether the value will stay.
    pub(crate) fn is_settled(&self) -> bool {
        match self.smoothing {
            Smoothing::Fixed { .. } => true,
            Smoothing::Continuation { floor, .. } => self.lambda <= floor,
            Smoothing::Automatic { .. } => {
                self.agreed >= 3 || self.iteration >= SETTLED || self.lambda < 1e-12
            }
        }
    }
}

/// The largest factor whose score is as good as the best, from the normal equations of the tangent model.
///
/// The score is `RSS / (1 − γ tr H / m)²` with the influence matrix `H = A (N + λE)⁻¹ Aᵀ` of the linearised problem and `m`
/// distances ([CW79]; `γ` as in [KG04]). With a value that was found before only those `near` it are tried. `None`
/// where no factor gives a finite one.
pub(crate) fn estimate_lambda<const D: usize>(
    layout: &mut Layout,
    normal: &Normal<D>,
    energy: &Blocks,
    coefficients: &[SVector<f64, D>],
    freedom: &Freedom<D>,
    noise: &Noise,
    near: Option<f64>,
) -> Option<f64> {
    let count = noise.count;
    let slack = Slack {
        share: (noise.bend / BENT).powi(4).min(MOST),
        least: if noise.surface { ESTIMATED } else { 0.0 },
    };
    let bend = layout.multiply(energy, coefficients);
    let question = Question { normal, energy, bend, freedom, count };
    let mut scores: Vec<Score> = Vec::new();
    if let Some(near) = near {
        let centre = near.log10();
        for step in AROUND {
            scores.extend(question.score(layout, centre + step));
        }
        let found = best(&scores, slack)?;
        let off = found.log10() - centre;
        if off.abs() > AROUND[AROUND.len() - 1] - 0.5 * BEYOND {
            scores.extend(question.score(layout, found.log10() + BEYOND.copysign(off)));
        }
        return best(&scores, slack);
    }
    let mut since_best = 0;
    for decade in (DECADES[0]..=DECADES[1]).rev() {
        let least = scores.iter().map(|s| s.value).fold(f64::INFINITY, f64::min);
        let Some(score) = question.score(layout, f64::from(decade)) else { continue };
        since_best = if score.value < least { 0 } else { since_best + 1 };
        scores.push(score);
        if since_best >= WORSE {
            break;
        }
    }
    let centre = best(&scores, slack)?.log10();
    for step in BETWEEN {
        scores.extend(question.score(layout, centre + step));
    }
    best(&scores, slack)
}

/// What a factor of the energy is worth.
#[derive(Clone, Copy, Debug)]
struct Score {
    lambda: f64,
    value: f64,
    /// Share of the noise that remains in the fitted shape, `tr H / m`.
    variance: f64,
}

/// How much worse than the best a score may be to count as good.
#[derive(Clone, Copy, Debug)]
struct Slack {
    /// Share of what noise leaves in the shape anyway.
    share: f64,
    /// Share of the score.
    least: f64,
}

/// The largest factor that is as good as the best; between two that were tried the score is taken as linear in the logarithm.
fn best(scores: &[Score], slack: Slack) -> Option<f64> {
    let least = scores.iter().min_by(|a, b| a.value.total_cmp(&b.value))?;
    let bound = least.value * (1.0 + (slack.share * least.variance).min(AS_GOOD).max(slack.least));
    let good = scores.iter().filter(|s| s.value <= bound).max_by(|a, b| a.lambda.total_cmp(&b.lambda))?;
    let beyond =
        scores.iter().filter(|s| s.lambda > good.lambda).min_by(|a, b| a.lambda.total_cmp(&b.lambda));
    let Some(beyond) = beyond else { return Some(good.lambda) };
    let share = (bound - good.value) / (beyond.value - good.value);
    Some(good.lambda * (beyond.lambda / good.lambda).powf(share))
}

/// The linearised problem at the present state of the shape.
struct Question<'a, const D: usize> {
    normal: &'a Normal<D>,
    energy: &'a Blocks,
    /// The energy matrix times the coefficients.
    bend: Vec<SVector<f64, D>>,
    freedom: &'a Freedom<D>,
    /// Number of distances.
    count: f64,
}

impl<const D: usize> Question<'_, D> {
    fn score(&self, layout: &mut Layout, exponent: f64) -> Option<Score> {
        let lambda = 10f64.powf(exponent);
        let Self { normal, energy, bend, freedom, count } = self;
        let damping = 1e-13 * layout.mean_diagonal::<D>(&normal.matrix);
        let factor = layout.factor::<D>(&normal.matrix, (lambda, energy), damping, freedom)?;
        let n = normal.vector.len();
        let free = |v: Vec<SVector<f64, D>>| -> Vec<SVector<f64, D>> {
            v.iter().enumerate().map(|(i, v)| freedom.allowed(i, v)).collect()
        };
        let rhs = free((0..n).map(|i| normal.vector[i] - bend[i] * lambda).collect());
        let step: Vec<SVector<f64, D>> = factor.solve(&rhs)?;
        let image = layout.multiply(&normal.matrix, &step);
        let mut rss = normal.value;
        for i in 0..n {
            rss += step[i].dot(&image[i]) - 2.0 * normal.vector[i].dot(&step[i]);
        }
        let mut trace = 0.0;
        let probe = |z: &[SVector<f64, D>]| -> Option<f64> {
            let y = factor.solve(&free(layout.multiply(&normal.matrix, z)))?;
            Some(z.iter().zip(&y).map(|(a, b)| a.dot(b)).sum())
        };
        if n * D <= EXACT {
            for i in 0..n {
                for c in 0..D {
                    let mut z = vec![SVector::zeros(); n];
                    z[i][c] = 1.0;
                    trace += probe(&free(z))?;
                }
            }
        } else {
            let mut state = 0x9e37_79b9_7f4a_7c15_u64;
            // Many unknowns average themselves.
            let probes = (PROBES * EXACT).div_ceil(n * D).clamp(LEAST_PROBES, PROBES);
            for _ in 0..probes {
                let z: Vec<_> = (0..n).map(|_| SVector::from_fn(|_, _| sign(&mut state))).collect();
                trace += probe(&free(z))? / probes as f64;
            }
        }
        let freedom = 1.0 - CAUTION * trace / count;
        let value = rss.max(0.0) / (freedom * freedom);
        let variance = trace / count;
        (freedom > 0.0 && value.is_finite()).then_some(Score { lambda, value, variance })
    }
}

/// A random sign (xorshift): the same in every run.
fn sign(state: &mut u64) -> f64 {
    *state ^= *state << 13;
    *state ^= *state >> 7;
    *state ^= *state << 17;
    if *state & (1 << 40) == 0 { 1.0 } else { -1.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_continuation_arrives_at_its_floor() {
        let mut schedule = Schedule::new(Smoothing::Continuation { start: 1.0, factor: 0.1, floor: 0.0 });
        for _ in 0..15 {
            schedule.advance(LambdaEstimate::NotMade);
        }
        assert!(!schedule.is_settled() && (schedule.lambda / 1e-15 - 1.0).abs() < 1e-9);
        for _ in 0..3 {
            schedule.advance(LambdaEstimate::NotMade);
        }
        assert!(schedule.is_settled() && schedule.lambda == 0.0);
    }

    #[test]
    fn the_data_are_asked_until_they_agree_three_times() {
        let mut schedule = Schedule::new(Smoothing::Automatic { start: 1.0, factor: 0.5 });
        for _ in 0..2 {
            assert!(!schedule.needs_estimate());
            schedule.advance(LambdaEstimate::NotMade);
        }
        assert!(schedule.needs_estimate() && schedule.lambda == 0.25);
        // A step of more than the factor at once is not taken, and the data are not asked on the way.
        schedule.advance(LambdaEstimate::Lambda(0.01));
        assert!(schedule.lambda == 0.125 && !schedule.needs_estimate());
        schedule.advance(LambdaEstimate::NotMade);
        assert!(schedule.lambda == 0.0625 && schedule.needs_estimate());
        // 1.5 times is not the same, 1.2 times is.
        schedule.advance(LambdaEstimate::Lambda(0.0625 / 1.5));
        schedule.advance(LambdaEstimate::Lambda(0.05));
        assert!(schedule.lambda == 0.05);
        schedule.advance(LambdaEstimate::Lambda(0.05));
        assert!(schedule.needs_estimate() && !schedule.is_settled());
        schedule.advance(LambdaEstimate::Lambda(0.05));
        assert!(!schedule.needs_estimate() && schedule.is_settled());
    }

    #[test]
    fn the_largest_factor_that_is_as_good() {
        let score = |lambda, value, variance| Score { lambda, value, variance };
        let found = |variance, share, least| {
            let scores = [score(1.0, 2.0, 0.0), score(0.1, 1.0, variance), score(0.01, 1.5, 1.0)];
            best(&scores, Slack { share, least }).unwrap()
        };
        assert!((found(0.1, 0.0, 0.0) - 0.1).abs() < 1e-15);
        // Half of what noise leaves, at most a tenth, at least what the estimate does not know.
        assert!((found(0.1, 0.5, 0.0) - 0.1 * 10f64.powf(0.05)).abs() < 1e-12);
        assert!((found(10.0, 0.5, 0.0) - 0.1 * 10f64.powf(0.1)).abs() < 1e-12);
        assert!((found(0.1, 0.0, 0.02) - 0.1 * 10f64.powf(0.02)).abs() < 1e-12);
        assert!(best(&[], Slack { share: 0.0, least: 0.0 }).is_none());
    }
}
