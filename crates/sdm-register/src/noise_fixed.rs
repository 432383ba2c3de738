//! Motions that nothing but the noise of estimated normals fixes.
//!
//! The normals of a cloud are estimated. Where a motion slides the true surface along itself, the noise of the normals still resists it,
//! by the sum of its squares, so that a cylinder of points seems to fix its place along the axis. The noise of the moving cloud is
//! another one: where the normals that both clouds have at the same place do not resist a motion together, the shape does not.

use crate::constraint::Freedom;
use crate::iterate::Outcome;
use crate::neighbourhood::{SAMPLE, planes};
use crate::solve::Scaled;
use crate::source::Prepared;
use nalgebra::{DVector, Point, SVector};

/// Share of the largest eigenvalue below which a motion is looked at.
const WEAK: f64 = 0.05;
/// Part of what resists a motion that both clouds have to agree on.
const AGREED: f64 = 0.3;
/// Fewest points with normals of their own that tell.
const FEWEST: usize = 40;
/// How far above an eigenvalue, and below the next one, the limit lies.
const MARGIN: f64 = 3.0;

/// A point with what both clouds say about the surface there.
struct Seen<const D: usize> {
    /// Relative to the origin of the motion.
    position: SVector<f64, D>,
    model: SVector<f64, D>,
    /// The normal of its own neighbours, on the side of the model's; `None` where these are not flat.
    own: Option<SVector<f64, D>>,
}

/// The share of the largest eigenvalue up to which motions are fixed by the noise of the normals alone; 0 where none is.
pub(crate) fn noise_share<const D: usize>(
    outcome: &Outcome<D>,
    cloud: &Prepared<D>,
    freedom: &Freedom<D>,
    scaled: &Scaled,
) -> f64 {
    let axes = scaled.axes();
    if !axes.iter().any(|(share, _)| *share < WEAK) {
        return 0.0;
    }
    let seen = seen(outcome, cloud);
    if seen.iter().filter(|point| point.own.is_some()).count() < FEWEST {
        return 0.0;
    }
    let is_noise = |step: &DVector<f64>| {
        let velocity = freedom.velocity(step);
        let (mut resisted, mut agreed) = (0.0, 0.0);
        for point in &seen {
            let v = velocity.at(&point.position);
            let along = point.model.dot(&v);
            resisted += along * along;
            // Where the own neighbours tell nothing, the model is believed.
            agreed += along * point.own.map_or(along, |own| own.dot(&v));
        }
        agreed < AGREED * resisted
    };
    let found = axes.iter().take_while(|(share, step)| *share < WEAK && is_noise(step)).count();
    let Some((last, _)) = found.checked_sub(1).and_then(|last| axes.get(last)) else { return 0.0 };
    let next = axes.get(found).map_or(1.0, |axis| axis.0);
    (MARGIN * last).min((last * next).sqrt())
}

fn seen<const D: usize>(outcome: &Outcome<D>, cloud: &Prepared<D>) -> Vec<Seen<D>> {
    let view = &outcome.view;
    let counts = |i: &usize| {
        outcome.base[*i] > 0.0
            && outcome.weighting.evaluate(view.distance(*i)).weight > 0.0
            && view.frames[*i].tangent_dimension == D - 1
    };
    let used: Vec<usize> = (0..cloud.points.len()).filter(counts).collect();
    let picked: Vec<usize> = used.iter().copied().step_by(used.len().div_ceil(SAMPLE).max(1)).collect();
    let points: Vec<Point<f64, D>> = picked.iter().map(|&i| cloud.points[i].into()).collect();
    let of = |(plane, &i): (&crate::neighbourhood::Plane<D>, &usize)| {
        let model = view.frames[i].normal();
        let own = view.pose.rotate(&plane.normal);
        let own = if own.dot(&model) < 0.0 { -own } else { own };
        Seen {
            position: view.pose.rotate(&cloud.points[i]) * view.pose.scale,
            model,
            own: plane.is_flat.then_some(own),
        }
    };
    planes(&points).iter().zip(&picked).map(of).collect()
}
