//! The virtual turntable: a cloud seen from all sides of its axis.

mod axis;
mod circle;
mod coverage;
mod normal_lines;

pub use axis::{AxisChoice, AxisEstimate, AxisOrigin, estimate_axis};
pub use circle::{Circle, bounding_circle};
pub use coverage::Coverage;

use crate::{AxisFrame, Error, Sharpness, View, parallel, visible_points};
use nalgebra::{Vector2, Vector3};
use std::f64::consts::TAU;

/// Most views that are tried when their number is chosen.
const MOST_VIEWS: usize = 12;
/// Share of the points that some view should see.
const SEEN: f64 = 0.995;
/// Gain in the share of points seen below which more views are not worth it.
const GAIN: f64 = 0.01;

/// A cloud on a turntable ([MPK, sec. 3.2]): the axis goes through the centre of the circle around the cloud as it is seen
/// along the axis.
#[derive(Clone, Debug, PartialEq)]
pub struct Turntable {
    /// Coordinates: two across the axis, and the height along it.
    pub frame: AxisFrame,
    /// Radius of the bounding circle.
    pub radius: f64,
    /// Lowest and highest point along the axis.
    pub heights: [f64; 2],
}

/// What is seen from one side of a turntable.
#[derive(Clone, Debug, PartialEq)]
pub struct TurntableView {
    /// Angle by which the table is turned, radians.
    pub angle: f64,
    /// For each point whether it is visible.
    pub visible: Vec<bool>,
}

impl Turntable {
    /// Puts a cloud on a table with an axis of the given direction.
    ///
    /// # Errors
    /// [`Error::TooFewPoints`] without a finite point; [`Error::Option`] for a direction that is zero or not finite.
    pub fn new(points: &[Vector3<f64>], direction: &Vector3<f64>) -> Result<Self, Error> {
        let finite = || points.iter().filter(|p| p.iter().all(|c| c.is_finite()));
        let Some(first) = finite().next() else {
            return Err(Error::TooFewPoints { total: points.len(), usable: 0, needed: 1 });
        };
        let frame = AxisFrame::new(*first, direction)?;
        let local: Vec<Vector3<f64>> = finite().map(|p| frame.to_local(p)).collect();
        let across: Vec<Vector2<f64>> = local.iter().map(|p| p.xy()).collect();
        let circle = bounding_circle(&across)?;
        let (low, high) =
            local.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), p| (l.min(p.z), h.max(p.z)));
        let middle = 0.5 * (low + high);
        let origin = frame.to_world(&Vector3::new(circle.centre.x, circle.centre.y, middle));
        Ok(Self {
            frame: AxisFrame { origin, ..frame },
            radius: circle.radius,
            heights: [low - middle, high - middle],
        })
    }

    /// A point as it is seen with the table turned by `angle` ([MPK, eq. (17)]): to the right, towards the eye, up.
    #[must_use]
    pub fn turned(&self, point: &Vector3<f64>, angle: f64) -> Vector3<f64> {
        turn(&self.frame.to_local(point), angle)
    }

    /// The inverse of [`turned`](Self::turned) ([MPK, eq. (18)]).
    #[must_use]
    pub fn turned_back(&self, seen: &Vector3<f64>, angle: f64) -> Vector3<f64> {
        self.frame.to_world(&turn(seen, -angle))
    }

    /// The visible points of `count` views, evenly spaced around the axis.
    ///
    /// # Errors
    /// As [`visible_points`].
    pub fn views(
        &self,
        points: &[Vector3<f64>],
        count: usize,
        sharpness: Sharpness,
    ) -> Result<Vec<TurntableView>, Error> {
        let view = |i: usize| {
            let angle = TAU * i as f64 / count as f64;
            let towards = self.frame.axes[1] * angle.cos() - self.frame.axes[0] * angle.sin();
            let seen = visible_points(points, View::Along(-towards), sharpness)?;
            Ok(TurntableView { angle, visible: seen.visible })
        };
        parallel::tasks(count, view).into_iter().collect()
    }

    /// As many views as the shape asks for: from four on, more as long as they show more of the cloud.
    ///
    /// Returns the views and the share of the points that at least one of them shows.
    ///
    /// # Errors
    /// As [`visible_points`].
    pub fn views_as_needed(
        &self,
        points: &[Vector3<f64>],
        sharpness: Sharpness,
    ) -> Result<(Vec<TurntableView>, f64), Error> {
        let share = |views: &[TurntableView]| {
            let seen = (0..points.len()).filter(|&i| views.iter().any(|view| view.visible[i])).count();
            seen as f64 / points.len().max(1) as f64
        };
        let mut views = self.views(points, 4, sharpness)?;
        let mut seen = share(&views);
        while views.len() < MOST_VIEWS && seen < SEEN {
            let more = self.views(points, views.len() + 2, sharpness)?;
            let now = share(&more);
            if now < seen + GAIN {
                break;
            }
            (views, seen) = (more, now);
        }
        Ok((views, seen))
    }
}

/// Turns across the axis: afterwards the first coordinate is to the right, the second towards the eye.
pub(crate) fn turn(local: &Vector3<f64>, angle: f64) -> Vector3<f64> {
    let (sin, cos) = angle.sin_cos();
    Vector3::new(local.x * cos + local.y * sin, local.y * cos - local.x * sin, local.z)
}
