//! Tables of footpoints and of iterations.

use industrial_geometry::fit::FitStep;
use industrial_geometry::fit::curve::{CurvePart, PointFoot};
use industrial_geometry::nurbs::nalgebra::SVector;
use std::fmt::Write as _;

/// The foot of each point, and the curve that it is on.
pub(super) fn feet_of<const D: usize>(
    count: usize,
    found: &[CurvePart<D>],
) -> Vec<Option<(PointFoot<D>, usize)>> {
    let mut feet = vec![None; count];
    for (k, part) in found.iter().enumerate() {
        for (&i, foot) in part.points.iter().zip(&part.fit.feet) {
            feet[i] = Some((*foot, k));
        }
    }
    feet
}

/// One line per point; empty cells where there is no foot.
pub(super) fn feet<const D: usize>(points: &[SVector<f64, D>], found: &[CurvePart<D>]) -> String {
    let feet = feet_of(points.len(), found);
    let several = found.len() > 1;
    let axes = &["x", "y", "z"][..D.min(3)];
    let header = axes.iter().map(|a| (*a).to_owned()).chain(axes.iter().map(|a| format!("foot_{a}")));
    let last = ["distance", "t"].into_iter().chain(several.then_some("curve"));
    let mut text = header.chain(last.map(str::to_owned)).collect::<Vec<_>>().join(",");
    text.push('\n');
    for (point, foot) in points.iter().zip(feet) {
        let nothing = PointFoot { parameter: f64::NAN, foot: SVector::repeat(f64::NAN), distance: f64::NAN };
        let (foot, curve) = foot.unwrap_or((nothing, 0));
        let cells = point.iter().chain(foot.foot.iter()).chain([&foot.distance, &foot.parameter]);
        line(&mut text, cells.copied().chain(several.then_some(curve as f64)));
    }
    text
}

/// One line per iteration.
pub(super) fn history(records: &[FitStep]) -> String {
    let mut text = String::from("iteration,controls,lambda,rms,max,cost,displacement,factor,damping\n");
    for r in records {
        let counts = [r.iteration as f64, r.coefficients as f64];
        let rest = [r.lambda, r.rms, r.max, r.cost, r.displacement, r.factor, r.damping];
        line(&mut text, counts.into_iter().chain(rest));
    }
    text
}

fn line(text: &mut String, values: impl Iterator<Item = f64>) {
    for (k, value) in values.enumerate() {
        if k > 0 {
            text.push(',');
        }
        // Writing to memory cannot fail.
        let _ = match value.abs() {
            size if !size.is_finite() => Ok(()),
            size if size > 0.0 && !(1e-5..1e16).contains(&size) => write!(text, "{value:e}"),
            _ => write!(text, "{value}"),
        };
    }
    text.push('\n');
}
