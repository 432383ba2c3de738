//! What the distances of a pose say about outliers and about the pose itself.

use crate::iterate::Outcome;
use crate::source::Prepared;
use crate::view::View;
use distance_field::Spread;

/// Distances in standard deviations of the noise at which a point no longer is one of the inliers.
pub(crate) const CUT: f64 = 4.685;
/// Smallest noise that is believed, as a share of the size of the cloud, and as multiples of the rounding of its coordinates.
const NOISE_FLOOR: f64 = 1e-12;
const ROUNDED: f64 = 8.0 * f64::EPSILON;
/// Distances in standard deviations that a normal distribution does not show: a single point there is an outlier.
const IMPOSSIBLE: f64 = 8.0;
/// Noise as a share of the size of the cloud above which the minimum may be a wrong one.
const NOISY: f64 = 0.012;
/// Distance as a share of the size of the cloud up to which a point supports a pose.
const NEAR: f64 = 0.012;
/// Share of the points whose support is enough not to look for another pose.
const ENOUGH: f64 = 0.45;

/// Distance up to which a point lies on the shape as far as numbers can tell, in the unit in which distances count: where neither cloud
/// nor shape has any noise, the spread of the distances is that of their rounding, or 0 because most of them are.
pub(crate) fn noise_floor<const D: usize>(view: &View<D>, cloud: &Prepared<D>) -> f64 {
    let far = cloud.centre.norm() * view.pose.scale + view.pose.target_origin.norm();
    NOISE_FLOOR * view.size(cloud) + ROUNDED * far / view.unit()
}

/// What the distances at the end of a stage say about outliers.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Evidence {
    /// Standard deviation of the noise.
    pub(crate) sigma: f64,
    /// Number of points that cannot be noise.
    pub(crate) outliers: usize,
    /// Whether the noise is large for the size of the cloud.
    noisy: bool,
}

impl Evidence {
    pub(crate) fn of<const D: usize>(outcome: &Outcome<D>, cloud: &Prepared<D>) -> Self {
        let distances = outcome.view.distances(&outcome.base);
        let sigma = Spread::of(&mut distances.clone(), CUT).sigma;
        let size = outcome.view.size(cloud);
        let limit = IMPOSSIBLE * sigma.max(noise_floor(&outcome.view, cloud));
        let outliers = distances.iter().filter(|d| **d > limit).count();
        Self { sigma, outliers, noisy: sigma > NOISY * size }
    }

    pub(crate) fn suspicious(&self) -> bool {
        self.outliers > 0 || self.noisy
    }
}

/// How many points lie on the shape, whatever weights led to the pose.
///
/// The noise alone does not tell a good pose from a bad one: a cloud that has slid off the shape but for a few points fits it
/// well there.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Nearness {
    /// Mean squared distance of all points, each at most 1, in units of the distance that still is near.
    pub(crate) cost: f64,
    /// Share of the points that are near.
    share: f64,
}

impl Nearness {
    pub(crate) fn of<const D: usize>(outcome: &Outcome<D>, cloud: &Prepared<D>) -> Self {
        let limit = NEAR * outcome.view.size(cloud);
        let (mut cost, mut near, mut weight) = (0.0, 0.0, 0.0);
        for i in 0..outcome.view.frames.len() {
            let own = cloud.weight(i);
            let square = (outcome.view.distance(i) / limit).powi(2);
            let is_near = square < 1.0;
            cost += own * if is_near { square } else { 1.0 };
            near += if is_near { own } else { 0.0 };
            weight += own;
        }
        Self { cost: cost / weight, share: near / weight }
    }

    pub(crate) fn is_enough(&self) -> bool {
        self.share >= ENOUGH
    }
}
