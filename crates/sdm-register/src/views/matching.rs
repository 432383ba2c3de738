//! Points of one view matched with the surfaces of another.

use std::ops::Range;

use nalgebra::Vector3;

use super::view::Prepared;
use crate::parallel;
use crate::start::Placement;

/// The rules by which a point and a surface belong together.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Rules {
    /// The largest distance, in the scaled frame.
    pub(crate) limit: f64,
    /// Cosine of the largest angle between normals.
    pub(crate) cosine: f64,
    /// Whether the signs of normals count.
    pub(crate) oriented: bool,
}

/// A point and the surface it was matched with, in the common frame.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Match {
    pub(crate) point: Vector3<f64>,
    pub(crate) normal: Vector3<f64>,
    /// Signed distance along the normal.
    pub(crate) distance: f64,
}

/// A directed pair of views: points of the first, surfaces of the second.
#[derive(Debug, Clone)]
pub(crate) struct Matches {
    pub(crate) views: [usize; 2],
    pub(crate) list: Vec<Match>,
    /// Number of points that were tried.
    pub(crate) tried: usize,
}

/// Points per task.
const CHUNK: usize = 250;

/// Matches of the first `count` sample points of each pair's first view, in the order of the pairs.
pub(crate) fn find(
    views: &mut [Prepared],
    poses: &[Placement],
    pairs: &[[usize; 2]],
    count: usize,
    rules: &Rules,
) -> Vec<Matches> {
    // The surfaces of the points themselves tell their normals and whether they lie on a border.
    for view in views.iter_mut() {
        let wanted: Vec<usize> = view.sample.iter().take(count).copied().collect();
        view.fit(wanted.into_iter());
    }
    let tasks: Vec<(usize, Range<usize>)> = (pairs.iter().enumerate())
        .flat_map(|(k, [i, _])| {
            let tried = count.min(views[*i].sample.len());
            (0..tried).step_by(CHUNK).map(move |start| (k, start..(start + CHUNK).min(tried)))
        })
        .collect();
    let (seen, at): (&[Prepared], _) = (views, poses);
    let nearest = parallel::tasks(tasks.len(), |t| {
        let (k, range) = &tasks[t];
        let [i, j] = pairs[*k];
        range
            .clone()
            .map(|s| nearest_in(&seen[i], &seen[j], &at[i], &at[j], s, rules.limit))
            .collect::<Vec<_>>()
    });
    let mut wanted = vec![Vec::new(); views.len()];
    for ((k, _), found) in tasks.iter().zip(&nearest) {
        wanted[pairs[*k][1]].extend(found.iter().flatten().copied());
    }
    for (view, wanted) in views.iter_mut().zip(wanted) {
        view.fit(wanted.into_iter());
    }
    let seen: &[Prepared] = views;
    let matched = parallel::tasks(tasks.len(), |t| {
        let (k, range) = &tasks[t];
        let [i, j] = pairs[*k];
        let found = range.clone().zip(&nearest[t]).filter_map(|(s, index)| {
            match_of(&seen[i], &seen[j], [&at[i], &at[j]], seen[i].sample[s], (*index)?, rules)
        });
        found.collect::<Vec<_>>()
    });
    let mut out: Vec<Matches> = (pairs.iter())
        .map(|&views| Matches { views, list: Vec::new(), tried: count.min(seen[views[0]].sample.len()) })
        .collect();
    for ((k, _), found) in tasks.iter().zip(matched) {
        out[*k].list.extend(found);
    }
    out
}

fn nearest_in(
    from: &Prepared,
    to: &Prepared,
    from_pose: &Placement,
    to_pose: &Placement,
    sample: usize,
    limit: f64,
) -> Option<usize> {
    let x = to_pose.apply_inverse(&from_pose.apply(&from.points[from.sample[sample]].coords));
    if !to.bounds.inflated(limit).contains(&x) {
        return None;
    }
    to.nearest(&x)
}

fn match_of(
    from: &Prepared,
    to: &Prepared,
    [from_pose, to_pose]: [&Placement; 2],
    point: usize,
    nearest: usize,
    rules: &Rules,
) -> Option<Match> {
    let (own, other) = (from.surface(point)?, to.surface(nearest)?);
    if own.border || other.border {
        return None;
    }
    let x = from_pose.apply(&from.points[point].coords);
    let height = other.height(&to_pose.apply_inverse(&x))?;
    let normal = to_pose.rotation * height.normal;
    let cosine = normal.dot(&(from_pose.rotation * own.normal()));
    let fits = if rules.oriented { cosine } else { cosine.abs() } >= rules.cosine;
    (fits && height.value.abs() <= rules.limit).then_some(Match { point: x, normal, distance: height.value })
}
