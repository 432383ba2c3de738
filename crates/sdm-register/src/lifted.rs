//! Points matched by position and normal: the nearest of the image `(x, w n) ∈ R⁶` of a shape ([P05, sec. 6]).
//!
//! Far from the right pose the nearest point of a shape lies on a wrong face as often as not. With the normal as three more coordinates, times
//! a length `w`, faces that look the other way are far away, such as the other side of a thin wall. What that brings depends on the part and
//! is measured (`cargo xtask measure registration-features`), so that it is an option.

use crate::parallel;
use crate::start::OrientedPoints;
use crate::superpose::best_rotation;
use crate::{Error, Pose};
use mesh_core::CloudIndex;
use nalgebra::{Matrix3, Point, SVector, Vector3};

/// Most points that are matched: the motion has six unknowns, and what it leads to is refined with all of them.
const POINTS: usize = 1000;
/// Most steps.
const STEPS: usize = 60;
/// A step as a share of the size of the cloud at which nothing changes but pairs of samples next to each other.
const SETTLED: f64 = 1e-4;
/// Fewest points: three positions determine a motion.
const FEWEST: usize = 3;

/// A shape as samples with normals, ready to be matched.
#[derive(Clone, Debug)]
pub struct FeatureMatching {
    index: CloudIndex<6>,
    samples: OrientedPoints,
    width: f64,
    oriented: bool,
}

/// Where matching by position and normal led.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FeatureApproach {
    /// The pose, with the scale of the start.
    pub pose: Pose<3>,
    /// Number of steps.
    pub steps: usize,
    /// Whether the pairs came to rest.
    pub is_settled: bool,
    /// Root of the weighted mean of the squared distances in R⁶.
    pub rms: f64,
}

impl FeatureMatching {
    /// Prepares the samples of a shape. `width` is the length `w` of a unit normal, 0 matches by positions alone; `oriented` tells that
    /// the normals of shape and cloud point to the same side, otherwise their signs do not count.
    ///
    /// # Errors
    /// [`Error::Option`] for a width that is negative or not finite, [`Error::TooFewPoints`] for less than three samples, [`Error::Cloud`] for too
    /// many.
    pub fn new(samples: &OrientedPoints, width: f64, oriented: bool) -> Result<Self, Error> {
        if !(width >= 0.0 && width.is_finite()) {
            return Err(Error::Option {
                name: "feature_weight",
                value: width,
                allowed: "a length, 0 or more",
            });
        }
        if samples.len() < FEWEST {
            let total = samples.len() + samples.dropped();
            return Err(Error::TooFewPoints { total, finite: samples.len(), needed: FEWEST });
        }
        let image = samples.points().iter().zip(samples.normals()).map(|(x, n)| lifted(x, &(n * width)));
        let index = CloudIndex::new(&image.collect::<Vec<_>>())?;
        Ok(Self { index, samples: samples.clone(), width, oriented })
    }

    /// Moves a cloud from a start by the motions that bring its points and their nearest samples, normals included, closest together; pairs
    /// that are farther apart than others count less.
    ///
    /// # Errors
    /// [`Error::TooFewPoints`] for less than three points, [`Error::NotAMotion`] for a start that is not finite.
    pub fn approach(&self, cloud: &OrientedPoints, start: &Pose<3>) -> Result<FeatureApproach, Error> {
        if cloud.len() < FEWEST {
            let total = cloud.len() + cloud.dropped();
            return Err(Error::TooFewPoints { total, finite: cloud.len(), needed: FEWEST });
        }
        if !start.is_finite() {
            return Err(Error::NotAMotion { deviation: f64::NAN });
        }
        let step = cloud.len().div_ceil(POINTS).max(1);
        let some: Vec<usize> = (0..cloud.len()).step_by(step).collect();
        let middle = some.iter().map(|&i| cloud.points()[i]).sum::<Vector3<f64>>() / some.len() as f64;
        let mut found = FeatureApproach {
            pose: start.with_source_origin(middle),
            steps: 0,
            is_settled: false,
            rms: f64::INFINITY,
        };
        let size = start.scale
            * some.iter().map(|&i| (cloud.points()[i] - middle).norm()).fold(f64::MIN_POSITIVE, f64::max);
        let mut guesses: Vec<Option<usize>> = vec![None; some.len()];
        while found.steps < STEPS && !found.is_settled {
            let pose = found.pose;
            let pairs = parallel::map(some.len(), |k| {
                let i = some[k];
                let (x, n) = (pose.apply(&cloud.points()[i]), pose.rotate(&cloud.normals()[i]));
                self.nearest(&x, &n, guesses[k])
                    .map(|(j, normal, distance_sq)| (x, n, j, normal, distance_sq))
            });
            for (guess, pair) in guesses.iter_mut().zip(&pairs) {
                *guess = pair.map(|pair| pair.2);
            }
            let pairs: Vec<Pair> = pairs.into_iter().flatten().collect();
            let Some((next, rms)) = self.motion(&pairs, &pose, size) else { break };
            let turn = (next.rotation - pose.rotation).norm() * size;
            let shift = (next.target_origin - pose.target_origin).norm();
            found.is_settled = turn.max(shift) < SETTLED * size;
            (found.pose, found.rms) = (next, rms);
            found.steps += 1;
        }
        Ok(found)
    }

    /// The nearest sample, its normal on the side of the given one, and the squared distance.
    fn nearest(
        &self,
        x: &Vector3<f64>,
        n: &Vector3<f64>,
        guess: Option<usize>,
    ) -> Option<(usize, Vector3<f64>, f64)> {
        let find = |sign: f64| {
            let near = self.index.nearest_near(&lifted(x, &(n * (sign * self.width))), guess)?;
            Some((near.index, self.samples.normals()[near.index] * sign, near.distance_sq))
        };
        match (find(1.0), if self.oriented || self.width == 0.0 { None } else { find(-1.0) }) {
            (Some(one), Some(other)) if other.2 < one.2 => Some(other),
            (one, other) => one.or(other),
        }
    }

    /// The motion of weighted least squares over the pairs, and the root mean square distance before it.
    fn motion(&self, pairs: &[Pair], pose: &Pose<3>, size: f64) -> Option<(Pose<3>, f64)> {
        if pairs.len() < FEWEST {
            return None;
        }
        let mut squares: Vec<f64> = pairs.iter().map(|pair| pair.4).collect();
        let half = squares.len() / 2;
        let typical = squares.select_nth_unstable_by(half, f64::total_cmp).1.max((SETTLED * size).powi(2));
        let weight = |pair: &Pair| 1.0 / (1.0 + pair.4 / typical);
        let foot = |pair: &Pair| self.samples.points()[pair.2];
        let total: f64 = pairs.iter().map(weight).sum();
        let from = pairs.iter().map(|pair| pair.0 * weight(pair)).sum::<Vector3<f64>>() / total;
        let to = pairs.iter().map(|pair| foot(pair) * weight(pair)).sum::<Vector3<f64>>() / total;
        let per_square = (size * size).recip();
        let products: Matrix3<f64> = pairs
            .iter()
            .map(|pair| {
                let places = (pair.0 - from) * (foot(pair) - to).transpose();
                let normals = pair.1 * pair.3.transpose() * (self.width * self.width);
                (places + normals) * (weight(pair) * per_square)
            })
            .sum();
        if !products.iter().all(|c| c.is_finite()) {
            return None;
        }
        let turn = best_rotation(&products);
        let rms = (pairs.iter().map(|pair| pair.4 * weight(pair)).sum::<f64>() / total).sqrt();
        let step = Pose { source_origin: from, target_origin: to, ..Pose::new(turn, Vector3::zeros()) };
        Some((pose.followed_by(&step), rms))
    }
}

/// A point where it is, its normal, the sample that is nearest, the normal there, and the squared distance.
type Pair = (Vector3<f64>, Vector3<f64>, usize, Vector3<f64>, f64);

/// A point of R⁶.
fn lifted(x: &Vector3<f64>, n: &Vector3<f64>) -> Point<f64, 6> {
    Point::from(SVector::from([x.x, x.y, x.z, n.x, n.y, n.z]))
}
