//! Turns of a shape about its own axes that lay most of it on itself.

use super::axes::principal_axes;
use super::placement::Placement;
use super::score::Scorer;
use super::{OrientedPoints, thin_evenly};
use crate::{parallel, rotation};
use nalgebra::{Matrix3, Vector3};
use std::f64::consts::{PI, TAU};

/// Turns about an axis: one every two degrees.
const STEPS: usize = 180;
/// Turns next to the identity that are not another position.
const NEXT: usize = 6;
/// Points that are turned.
const POINTS: usize = 300;
/// Distance, as a share of the size, up to which a turned point lies on the shape.
const LIMIT: f64 = 0.025;
/// Share of the points that a turn lays on the shape, at least.
const MOST: f64 = 0.75;
/// Share of the turns about an axis that do so where the shape is nearly one of revolution.
const ROUND: f64 = 0.9;

/// All turns about an axis, in order: by themselves, or each after half a turn about a line across.
#[derive(Debug)]
pub(crate) struct Ring {
    pub(crate) axis: Vector3<f64>,
    pub(crate) rotations: Vec<Matrix3<f64>>,
    /// Whether most of the shape lies on itself after each.
    pub(crate) is_near: Vec<bool>,
}

impl Ring {
    /// Whether hardly any turn takes the shape off itself.
    pub(crate) fn is_round(&self) -> bool {
        let near = self.is_near.iter().filter(|near| **near).count();
        near as f64 > ROUND * self.is_near.len() as f64
    }
}

/// Turns about the principal axes of a shape through its centre, from which they are measured.
#[derive(Debug)]
pub(crate) struct Turning {
    pub(crate) centre: Vector3<f64>,
    /// Two for each axis: turns, and turns after half a turn across.
    pub(crate) rings: Vec<Ring>,
    /// Whether all turns lay most of the shape on itself, as those of a sphere.
    pub(crate) is_spherical: bool,
}

impl Turning {
    /// Of points spread evenly over a shape; `None` where no turn lays most of it on itself.
    pub(crate) fn of(samples: &OrientedPoints) -> Option<Self> {
        let bounds = samples.bounding_box().filter(|bounds| bounds.diagonal() > 0.0)?;
        let size = bounds.diagonal();
        let (centre, axes) = principal_axes(samples.points());
        let shape = samples.scaled(&thin_evenly(samples.len(), 20 * POINTS), &centre, size);
        let some = shape.scaled(&thin_evenly(shape.len(), POINTS), &Vector3::zeros(), 1.0);
        let scorer = Scorer::new(shape, false);
        let ring = |k: usize| {
            let axis = axes.column(k / 2).into_owned();
            let across = axes.column((k / 2 + 1) % 3) * PI;
            let first =
                if k.is_multiple_of(2) { Matrix3::identity() } else { rotation::exponential::<3>(&across).0 };
            let rotations: Vec<Matrix3<f64>> = (0..STEPS)
                .map(|i| rotation::exponential::<3>(&(axis * (TAU * i as f64 / STEPS as f64))).0 * first)
                .collect();
            let is_near = rotations.iter().map(|rotation| {
                let placement = Placement { rotation: *rotation, shift: Vector3::zeros() };
                scorer.share_and_rms(&placement, &some, some.len(), LIMIT).0 >= MOST
            });
            Ring { axis, is_near: is_near.collect(), rotations }
        };
        let rings = parallel::tasks(6, ring);
        let is_spherical = rings.iter().all(Ring::is_round);
        // What is next to the identity is none.
        let is_far = |k: usize, i: usize| !k.is_multiple_of(2) || (NEXT..=STEPS - NEXT).contains(&i);
        let has_any =
            rings.iter().enumerate().any(|(k, ring)| (0..STEPS).any(|i| ring.is_near[i] && is_far(k, i)));
        has_any.then_some(Self { centre, rings, is_spherical })
    }
}
