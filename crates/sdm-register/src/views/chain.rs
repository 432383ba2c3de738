//! Initial poses out of coarse registrations of pairs.

use footpoint::Progress;
use std::ops::ControlFlow;

use super::{View, ViewsOptions};
use crate::start::{CoarseStart, OrientedPoints, StartOptions};
use crate::{Error, Pose};

/// The least excess of matched points (see [`excess`](crate::start::StartCandidate::excess)) that links two views, as a share of a view.
const LEAST_EXCESS: f64 = 0.06;

/// Distance up to which points count: small, since parts of smooth shapes fit others roughly in many ways.
const TOLERANCE: f64 = 0.004;

/// Poses in the frame of the first view, by a tree of the pairs that fit best. Views that fit none keep their frames.
pub(crate) fn initial_poses(
    views: &[View],
    options: &ViewsOptions,
    progress: Progress<'_>,
) -> Result<Vec<Pose<3>>, Error> {
    let clouds = views.iter().map(oriented).collect::<Result<Vec<_>, Error>>()?;
    let start_options = StartOptions::default()
        .with_seed(options.seed)
        .with_oriented(options.oriented)
        .with_tolerance(TOLERANCE)
        .with_max_rounds(20);
    let (mut links, mut tried) = (Vec::new(), 0);
    let total = views.len() * (views.len() - 1) / 2;
    'pairs: for i in 0..views.len() {
        let start = CoarseStart::new(&clouds[i], &start_options)?;
        for j in i + 1..views.len() {
            if progress(tried, total).is_break() {
                break 'pairs;
            }
            let report = start.search(&clouds[j], &|_, _| ControlFlow::Continue(()))?;
            tried += 1;
            let best = report
                .candidates
                .iter()
                .max_by(|a, b| a.excess(report.tolerance).total_cmp(&b.excess(report.tolerance)));
            if let Some(best) = best.filter(|best| best.excess(report.tolerance) >= LEAST_EXCESS) {
                links.push((best.excess(report.tolerance), [i, j], best.pose));
            }
        }
    }
    links.sort_by(|a, b| b.0.total_cmp(&a.0));
    let mut poses: Vec<Option<Pose<3>>> = vec![None; views.len()];
    poses[0] = Some(Pose::identity());
    // The best link from what is placed to what is not, again and again (Prim).
    loop {
        let next = links.iter().find(|(_, [i, j], _)| poses[*i].is_some() != poses[*j].is_some());
        let Some((_, [i, j], pose)) = next else {
            match poses.iter().position(Option::is_none) {
                Some(loose) => poses[loose] = Some(Pose::identity()),
                None => break,
            }
            continue;
        };
        match (poses[*i], poses[*j]) {
            (Some(base), None) => poses[*j] = Some(pose.followed_by(&base)),
            (None, Some(base)) => poses[*i] = Some(pose.inverse().followed_by(&base)),
            _ => break,
        }
    }
    Ok(poses.into_iter().map(Option::unwrap_or_default).collect())
}

/// The points of a view, with normals by the plane through neighbours where it has none.
fn oriented(view: &View) -> Result<OrientedPoints, Error> {
    match view.normals() {
        Some(normals) => OrientedPoints::new(view.points(), normals),
        None => OrientedPoints::without_normals(view.points()),
    }
}
