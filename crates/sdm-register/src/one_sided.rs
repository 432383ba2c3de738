//! Motions that nothing but a border of the shape resists, and to one side only.
//!
//! Points that hang over an end of a groove are drawn back to it, and no further: along the groove the place is one of many. Ends on both
//! sides leave one place.

use crate::constraint::Freedom;
use crate::eigen::Eigen;
use crate::iterate::{Outcome, fewest};
use crate::solve::Scaled;
use crate::source::Prepared;
use crate::view::Terms;
use nalgebra::{DMatrix, DVector};

/// Share of what the border resists that the weaker of both sides needs for the motion to be fixed.
const OTHER_SIDE: f64 = 0.1;
/// Share of the largest eigenvalue above which a motion is resisted by more than some points at a border.
const STRONG: f64 = 0.3;

/// The tangent matrix without what the border of the shape resists to one side only; `None` where there is nothing of that kind.
pub(crate) fn without<const D: usize>(
    outcome: &Outcome<D>,
    cloud: &Prepared<D>,
    freedom: &Freedom<D>,
    terms: &Terms,
    (tangent, scaled): (&DMatrix<f64>, &Scaled),
    (length, tolerance): (f64, f64),
) -> Option<DMatrix<f64>> {
    let view = &outcome.view;
    if !scaled.axes().iter().any(|(share, _)| *share < STRONG) {
        return None;
    }
    let is_at_border =
        |i: usize| outcome.base[i] > 0.0 && view.frames[i].on_boundary && view.frames[i].distance != 0.0;
    let border: Vec<usize> = (0..view.frames.len()).filter(|&i| is_at_border(i)).collect();
    if border.is_empty() {
        return None;
    }
    let mut base = outcome.base.clone();
    for &i in &border {
        base[i] = 0.0;
    }
    let inner = view.system(cloud, &base, &outcome.weighting, terms);
    if inner.count < fewest(D) {
        return None;
    }
    let inner = Scaled::new(&freedom.reduce(&inner.tangent), &freedom.is_translation, length, tolerance);
    let steps = inner.free_steps();
    // How fast each point at the border leaves it, by each of the motions that the inner points leave free.
    let rates: Vec<DVector<f64>> = border
        .iter()
        .map(|&i| {
            let place = view.pose.rotate(&cloud.points[i]) * view.pose.scale;
            let frame = &view.frames[i];
            let outwards = frame.normal() * frame.distance.signum();
            let weight = (outcome.base[i] * outcome.weighting.evaluate(view.distance(i)).weight).sqrt();
            DVector::from_fn(steps.len(), |k, _| {
                weight * outwards.dot(&freedom.velocity(&steps[k]).at(&place))
            })
        })
        .collect();
    let gram = rates.iter().fold(DMatrix::zeros(steps.len(), steps.len()), |sum, r| sum + r * r.transpose());
    let eigen = Eigen::new(gram);
    let units =
        DVector::from_fn(
            freedom.is_translation.len(),
            |i, _| {
                if freedom.is_translation[i] { length } else { 1.0 }
            },
        );
    let mut keeps = DMatrix::identity(units.len(), units.len());
    let mut is_changed = false;
    for column in eigen.vectors.column_iter() {
        let sides = rates.iter().fold([0.0, 0.0], |[out, back], r| {
            let rate = r.dot(&column);
            if rate > 0.0 { [out + rate * rate, back] } else { [out, back + rate * rate] }
        });
        if sides[0].min(sides[1]) <= OTHER_SIDE * (sides[0] + sides[1]) {
            let step =
                steps.iter().zip(column.iter()).fold(DVector::zeros(units.len()), |sum, (s, c)| sum + s * *c);
            let scaled = step.component_div(&units);
            keeps -= &scaled * scaled.transpose();
            is_changed = true;
        }
    }
    let keeps = DMatrix::from_fn(units.len(), units.len(), |i, j| units[i] * keeps[(i, j)] / units[j]);
    is_changed.then(|| keeps.transpose() * tangent * keeps)
}
