//! How far the points speak for a pose: what tells a fit from a place where the iteration merely ended.

use crate::Status;
use crate::iterate::Outcome;
use crate::neighbourhood::{SAMPLE, median, planes};
use crate::source::Prepared;
use nalgebra::{Point, SVector};
use std::fmt;

/// Share of the points below which a pose is not believed, unless [`MANY`] of them stand out.
const FEW: f64 = 0.1;
/// Points that are enough whatever their share, if the model fixes all motions and hardly any point is next to them.
const MANY: usize = 200;
/// Points per unknown below which those that are left of a cloud fit anything: of most of it, and of less than half.
const PER_UNKNOWN: [usize; 2] = [2, 5];
/// Share of the points that is little.
const LITTLE: f64 = 0.5;
/// Density of the distances beyond the limit, over that within, above which the limit separates nothing, and what is clear.
const UNSEPARATED: f64 = 0.5;
const CLEAR: f64 = 0.1;
/// Width of the range beyond the limit that is looked at, in limits.
const BEYOND: f64 = 5.0;
/// Share of the points that count from which there is nothing to separate.
const ALL: f64 = 0.97;
/// Root mean square distances, as shares of the size of the points that count: what is looked at more closely, and what is too much
/// where locks cause it.
const NOTED: f64 = 0.001;
const HELD: f64 = 0.008;
/// The same for what is too much where normals disagree as well, and what is too much in any case: where all points count, where
/// some were left out for their distance, and where most were. What is left is to be closer then, since it was chosen to be close.
const LARGE: [f64; 3] = [0.012, 0.006, 0.006];
const HUGE: [f64; 3] = [0.05, 0.025, 0.015];
/// The same where most of the squared distances lie along the surface of the points themselves, and what is most of them.
const OVERHANG: f64 = 0.005;
const ALONG: f64 = 0.5;
/// Distances in units of the noise that the points show among themselves above which the two do not agree.
const DISAGREEING: f64 = 3.0;
/// Median angle between the normals of the points and of the model above which they do not agree, radians.
const ANGLE: f64 = 0.06;
/// Root mean square distance of a cloud on a cloud that is too much where it exceeds the noise and normals disagree: what a part that was
/// made badly differs from its construction by is no reason between two scans of it.
const LARGE_OF_CLOUDS: f64 = 0.002;
/// Share of the squared distances that would go if the locked motions were free.
const RELEASED: f64 = 0.5;
/// Sizes of the points over that of the model between which a scale is one.
const SIZES: [f64; 2] = [0.01, 100.0];

/// Why a pose at which the iteration converged is not believed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(rename_all = "snake_case"))]
#[non_exhaustive]
pub enum Doubt {
    /// Too few of the points lie on the model: status [`Status::NoOverlap`].
    FewPoints,
    /// The points on the model are no more than those next to it, as where two surfaces cross or touch.
    NoSeparation,
    /// The distances are much larger than the noise of the points, and their normals disagree with those of the model.
    LargeDistances,
    /// The distances are much larger than the noise of the points, because of the degrees of freedom that are locked.
    Locks,
    /// The estimated scale makes the points far smaller, or larger, than the model: status [`Status::Diverged`].
    Collapsed,
    /// Most of what the points could show of the model has none: see [`Coverage::doubt`](crate::Coverage::doubt).
    Bare,
    /// Points float in front of surfaces that were seen through them: see [`FreeSpace::doubt`](crate::FreeSpace::doubt).
    FreeSpace,
    /// The distances are more than noise, and the points fit distinctly better in another position, which is none that the start leads to.
    Elsewhere,
    /// The points fit as well in another position, to which a near symmetry of the model leads, but in which the model is not the same.
    Rival,
    /// The mirror image of the points fits distinctly better: a part of the other hand, or axes that are left-handed.
    Mirrored,
    /// The model is a cloud that shows no surface: see [`shows_a_surface`](crate::shows_a_surface).
    Unresolved,
    /// The points that count leave motions free, and many others were left out, which might fix them, or the model has places that would
    /// ([`FreeMotion::is_fixed_by`](crate::FreeMotion::is_fixed_by)): status [`Status::Underdetermined`].
    Unfixed,
}

impl Doubt {
    /// The status of a registration that ends with this doubt.
    #[must_use]
    pub fn status(self) -> Status {
        match self {
            Self::FewPoints => Status::NoOverlap,
            Self::Collapsed => Status::Diverged,
            Self::Unfixed => Status::Underdetermined,
            Self::NoSeparation
            | Self::LargeDistances
            | Self::Locks
            | Self::Bare
            | Self::FreeSpace
            | Self::Elsewhere
            | Self::Rival
            | Self::Mirrored
            | Self::Unresolved => Status::Doubtful,
        }
    }

    /// The name used in files.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::FewPoints => "few_points",
            Self::NoSeparation => "no_separation",
            Self::LargeDistances => "large_distances",
            Self::Locks => "locks",
            Self::Collapsed => "collapsed",
            Self::Bare => "bare",
            Self::FreeSpace => "free_space",
            Self::Elsewhere => "elsewhere",
            Self::Rival => "rival",
            Self::Mirrored => "mirrored",
            Self::Unresolved => "unresolved",
            Self::Unfixed => "unfixed",
        }
    }
}

/// What the points that count say about the pose.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Support {
    /// Share of the points that count.
    pub share: f64,
    /// Root mean square distance of the points that count as a share of their size, the diagonal of the box around them.
    pub relative_rms: f64,
    /// The same of what the points deviate from smooth surfaces through their neighbours, after thinning; `None` where the distances
    /// are so small that it does not matter.
    pub own_noise: Option<f64>,
    /// Median angle between the normals of those planes and the normals of the model, radians; where `own_noise` is known.
    pub normal_angle: Option<f64>,
    /// Share of the squared distances that lies along the surface which the points show among themselves, as where they hang over an
    /// end of the model; where `own_noise` is known.
    pub along_surface: Option<f64>,
    /// Density of the distances just beyond the limit over that within: near 0 for points that stand out, near 1 where nothing
    /// separates them from the others. `None` where no limit was drawn, or hardly any point is beyond.
    pub background: Option<f64>,
    /// `relative_rms` as the model of the last step foretells it without locks; `None` without locks.
    pub unlocked_rms: Option<f64>,
    /// Size of the points that count over that of the model; `None` unless the scale was estimated.
    pub relative_size: Option<f64>,
    /// Why the pose is not believed.
    pub doubt: Option<Doubt>,
}

/// What is known of the registration besides its outcome.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Circumstances {
    /// Number of unknowns.
    pub(crate) unknowns: usize,
    /// Whether the model leaves some motion free.
    pub(crate) has_free_motions: bool,
    /// Share of the squared distances that would be left without locks.
    pub(crate) unlocked: Option<f64>,
    /// Diagonal of the box around the model, where the scale was estimated.
    pub(crate) model_size: Option<f64>,
}

impl Support {
    pub(crate) fn of<const D: usize>(
        outcome: &Outcome<D>,
        cloud: &Prepared<D>,
        rms: f64,
        given: &Circumstances,
    ) -> Self {
        let view = &outcome.view;
        let counts =
            |i: usize| outcome.base[i] > 0.0 && outcome.weighting.evaluate(view.distance(i)).weight > 0.0;
        let used: Vec<usize> = (0..cloud.points.len()).filter(|&i| counts(i)).collect();
        let share = used.len() as f64 / cloud.points.len().max(1) as f64;
        let extent = diagonal(used.iter().map(|&i| &cloud.points[i]));
        let size = extent * view.size(cloud) / cloud.diagonal;
        let relative_rms = if size > 0.0 { rms / size } else { 0.0 };
        let mut support = Self {
            share,
            relative_rms,
            own_noise: None,
            normal_angle: None,
            along_surface: None,
            background: background(outcome, share),
            unlocked_rms: given.unlocked.map(|left| relative_rms * left.sqrt()),
            relative_size: given.model_size.map(|model| extent * view.pose.scale / model),
            doubt: None,
        };
        if relative_rms > NOTED {
            let own = OwnShape::of(outcome, cloud, &used);
            support.own_noise = own.noise.map(|noise| noise / extent);
            support.normal_angle = own.angle;
            support.along_surface = own.along;
        }
        support.doubt = support.judge(used.len(), given);
        support
    }

    fn judge(&self, used: usize, given: &Circumstances) -> Option<Doubt> {
        let collapsed = |size: f64| !(SIZES[0]..=SIZES[1]).contains(&size);
        if self.relative_size.is_some_and(collapsed) {
            return Some(Doubt::Collapsed);
        }
        let is_little = self.share < LITTLE;
        let is_few = self.share < 1.0 && used < PER_UNKNOWN[usize::from(is_little)] * given.unknowns;
        let stand_out =
            used >= MANY && !given.has_free_motions && self.background.is_none_or(|density| density < CLEAR);
        if is_few || self.share < FEW && !stand_out {
            return Some(Doubt::FewPoints);
        }
        if self.background.is_some_and(|density| density > UNSEPARATED) {
            return Some(Doubt::NoSeparation);
        }
        let left_out = usize::from(self.background.is_some()) + usize::from(is_little);
        if self.relative_rms > HUGE[left_out.min(2)] {
            return Some(Doubt::LargeDistances);
        }
        if !self.exceeds_noise() {
            return None;
        }
        if self.relative_rms > HELD && given.unlocked.is_some_and(|left| left < 1.0 - RELEASED) {
            return Some(Doubt::Locks);
        }
        let hang_over = self.along_surface.is_some_and(|share| share > ALONG);
        if self.relative_rms > OVERHANG && hang_over {
            return Some(Doubt::LargeDistances);
        }
        let disagree = self.normal_angle.is_none_or(|angle| angle > ANGLE);
        (self.relative_rms > LARGE[left_out.min(2)] && disagree).then_some(Doubt::LargeDistances)
    }

    /// Whether the distances are too large for those of one scan on another: much larger than the noise of the points, whose normals
    /// disagree with those of the other scan.
    #[must_use]
    pub fn is_large_for_scans(&self) -> bool {
        let disagree = self.normal_angle.is_none_or(|angle| angle > ANGLE);
        self.exceeds_noise() && self.relative_rms > LARGE_OF_CLOUDS && disagree
    }

    /// Whether the distances are much larger than the noise that the points show among themselves.
    #[must_use]
    pub fn exceeds_noise(&self) -> bool {
        self.own_noise.is_some_and(|noise| self.relative_rms > DISAGREEING * noise)
    }
}

impl fmt::Display for Support {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{:.1} % of the points count, rms {:.2} % of their size",
            100.0 * self.share,
            100.0 * self.relative_rms
        )?;
        if let Some(noise) = self.own_noise {
            write!(f, ", own noise {:.2} %", 100.0 * noise)?;
        }
        if let Some(angle) = self.normal_angle {
            write!(f, ", normals {:.0} degrees apart", angle.to_degrees())?;
        }
        if let Some(share) = self.along_surface.filter(|share| *share > ALONG) {
            write!(f, ", {:.0} % of their squares along the surface of the points", 100.0 * share)?;
        }
        if let Some(background) = self.background {
            write!(f, ", density beyond the limit {background:.2} of that within")?;
        }
        if let Some(rms) = self.unlocked_rms {
            write!(f, ", rms without locks {:.2} %", 100.0 * rms)?;
        }
        if let Some(size) = self.relative_size {
            write!(f, ", {size:.2e} of the size of the model")?;
        }
        Ok(())
    }
}

/// The diagonal of the box around points.
fn diagonal<'a, const D: usize>(points: impl Iterator<Item = &'a SVector<f64, D>>) -> f64 {
    let empty = (SVector::<f64, D>::repeat(f64::INFINITY), SVector::<f64, D>::repeat(f64::NEG_INFINITY));
    let (low, high) = points.fold(empty, |(low, high), x| (low.inf(x), high.sup(x)));
    if low[0] <= high[0] { (high - low).norm() } else { 0.0 }
}

/// Density of the distances beyond the limit over that within. Points that are left out for where their foot is do not take part.
fn background<const D: usize>(outcome: &Outcome<D>, share: f64) -> Option<f64> {
    let limit = outcome.weighting.scale().filter(|limit| *limit > 0.0 && share < ALL)?;
    let distances = outcome.view.distances(&outcome.base);
    let within = distances.iter().filter(|d| **d <= limit).count();
    let beyond = distances.iter().filter(|d| **d > limit && **d <= (1.0 + BEYOND) * limit).count();
    (within > 0).then(|| beyond as f64 / BEYOND / within as f64)
}

/// What the neighbourhoods of the points show.
struct OwnShape {
    /// How far points deviate from smooth surfaces through their neighbours, in the source's unit.
    noise: Option<f64>,
    /// Median angle between the normals of planes through these and of the model.
    angle: Option<f64>,
    /// Share of the squared distances that lies in those planes.
    along: Option<f64>,
}

impl OwnShape {
    fn of<const D: usize>(outcome: &Outcome<D>, cloud: &Prepared<D>, used: &[usize]) -> Self {
        let step = used.len().div_ceil(SAMPLE).max(1);
        let picked: Vec<usize> = used.iter().copied().step_by(step).collect();
        let points: Vec<Point<f64, D>> = picked.iter().map(|&i| cloud.points[i].into()).collect();
        let planes = planes(&points);
        let noise = median(planes.iter().map(|plane| plane.roughness).collect());
        let (mut angles, mut all, mut along) = (Vec::new(), 0.0, 0.0);
        let flat = planes.iter().zip(&picked).filter(|(plane, _)| plane.is_flat);
        for (plane, &i) in flat {
            let frame = &outcome.view.frames[i];
            let cosine = outcome.view.pose.rotate(&plane.normal).dot(&frame.normal()).abs().min(1.0);
            let square = frame.distance * frame.distance;
            all += square;
            along += square * (1.0 - cosine * cosine);
            if !frame.on_boundary && frame.tangent_dimension == D - 1 {
                angles.push(cosine.acos());
            }
        }
        // Where hardly any neighbourhood is flat, there is nothing to compare.
        let angle = if 4 * angles.len() >= planes.len() { median(angles) } else { None };
        Self { noise, angle, along: (all > 0.0).then(|| along / all) }
    }
}
