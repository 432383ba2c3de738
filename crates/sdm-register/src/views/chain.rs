//! Coarse registrations of pairs of views: initial poses, and whether the poses of an end are the only ones that the views allow.

use footpoint::Progress;
use nalgebra::Vector3;
use std::ops::ControlFlow;

use super::graph::components;
use super::{View, ViewsOptions, ViewsReport, ViewsStatus};
use crate::start::{CoarseStart, OrientedPoints, StartCandidate, StartOptions};
use crate::{Error, Pose};

/// The least excess of matched points (see [`excess`](crate::start::StartCandidate::excess)) that links two views, as a share of a view.
const LEAST_EXCESS: f64 = 0.06;

/// Distance up to which points count: small, since parts of smooth shapes fit others roughly in many ways.
const TOLERANCE: f64 = 0.004;

/// Excess of another place of a view over that of the best one from which the two are rivals: views of parts with flat sides lie on each
/// other in many places, none of which they tell from the right one.
const RIVAL: f64 = 0.75;

/// Root mean square displacement of a view, as a share of its size, up to which two places of it are one, and points that tell.
const SAME: f64 = 0.05;
const COMPARED: usize = 200;

/// Share of a view that another one covers, from which the two have so much in common that given poses need no search.
const MUCH: f64 = 0.5;

/// Where two views fit best, by a search over all positions.
#[derive(Debug, Clone)]
struct Link {
    /// The second one is moved to the first.
    views: [usize; 2],
    excess: f64,
    pose: Pose<3>,
    /// Whether the second view fits nearly as well in another place.
    has_rivals: bool,
}

/// Searches over all positions of all pairs of views.
///
/// They tell initial poses for views about which nothing is known, and whether an end is the only one: views of which no pair with a place
/// of its own confirms where they lie may lie elsewhere as well.
#[derive(Debug, Clone)]
pub struct PairSearch {
    /// By descending excess.
    links: Vec<Link>,
    views: usize,
}

impl PairSearch {
    /// Searches all pairs, or those until `progress` cancels; it is told the number of pairs that were searched, and that of all.
    ///
    /// # Errors
    /// As for [`register_views_from`](super::register_views_from).
    pub fn new(views: &[View], options: &ViewsOptions, progress: Progress<'_>) -> Result<Self, Error> {
        options.validate()?;
        super::register::check(views)?;
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
                let excess = |one: &StartCandidate| one.excess(report.tolerance);
                let best = report.candidates.iter().max_by(|a, b| excess(a).total_cmp(&excess(b)));
                let Some(best) = best.filter(|best| excess(best) >= LEAST_EXCESS) else { continue };
                let is_rival = |other: &StartCandidate| {
                    excess(other) >= RIVAL * excess(best) && !is_same(&views[j], &other.pose, &best.pose)
                };
                let has_rivals = report.candidates.iter().any(is_rival);
                links.push(Link { views: [i, j], excess: excess(best), pose: best.pose, has_rivals });
            }
        }
        links.sort_by(|a, b| b.excess.total_cmp(&a.excess));
        Ok(Self { links, views: views.len() })
    }

    /// Poses in the frame of the first view, by a tree of the pairs that fit best. Views that fit none keep their frames.
    #[must_use]
    pub fn poses(&self) -> Vec<Pose<3>> {
        let mut poses: Vec<Option<Pose<3>>> = vec![None; self.views];
        if let Some(first) = poses.first_mut() {
            *first = Some(Pose::identity());
        }
        // The best link from what is placed to what is not, again and again (Prim).
        loop {
            let next = self.links.iter().find(|link| {
                let [i, j] = link.views;
                poses[i].is_some() != poses[j].is_some()
            });
            let Some(Link { views: [i, j], pose, .. }) = next else {
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
        poses.into_iter().map(Option::unwrap_or_default).collect()
    }

    /// An end with what the searches say about it: [`ViewsStatus::Ambiguous`] if it converged, but the pairs that fit in one place only, and
    /// lie there, do not hang together all views.
    #[must_use]
    pub fn judged(&self, views: &[View], report: ViewsReport) -> ViewsReport {
        if report.status != ViewsStatus::Converged || report.views.len() != self.views {
            return report;
        }
        let confirmed = |pair: [usize; 2]| {
            let link = self.links.iter().find(|link| link.views == pair && !link.has_rivals);
            link.is_some_and(|link| {
                let [i, j] = pair.map(|view| report.views[view].pose);
                is_same(&views[pair[1]], &j.followed_by(&i.inverse()), &link.pose)
            })
        };
        let of_pairs: Vec<bool> = report.pairs.iter().map(|pair| confirmed(pair.views)).collect();
        let edges = report.pairs.iter().zip(&of_pairs).filter(|(_, is)| **is).map(|(pair, _)| pair.views);
        let parts = components(self.views, edges);
        if parts.len() < 2 {
            return report;
        }
        let part = |view: usize| parts.iter().position(|members| members.contains(&view));
        let mut report = report;
        for pair in &mut report.pairs {
            pair.is_ambiguous = part(pair.views[0]) != part(pair.views[1]);
        }
        ViewsReport { status: ViewsStatus::Ambiguous, ..report }
    }
}

/// Whether the views of an end have so much in common that it need not be asked whether they lie elsewhere as well.
#[must_use]
pub fn have_much_in_common(report: &ViewsReport) -> bool {
    let linked = report.pairs.iter().filter(|pair| pair.overlap[0].max(pair.overlap[1]) >= MUCH);
    components(report.views.len(), linked.map(|pair| pair.views)).len() == 1
}

/// Whether two poses of a view take it to nearly the same place.
fn is_same(view: &View, one: &Pose<3>, other: &Pose<3>) -> bool {
    let step = view.points().len().div_ceil(COMPARED).max(1);
    let some: Vec<&Vector3<f64>> = view.points().iter().step_by(step).collect();
    let squares: f64 = some.iter().map(|x| (one.apply(x) - other.apply(x)).norm_squared()).sum();
    let size = view.bounding_box().map_or(0.0, |bounds| bounds.diagonal());
    squares <= (SAME * size).powi(2) * some.len() as f64
}

/// The points of a view, with normals by the plane through neighbours where it has none.
fn oriented(view: &View) -> Result<OrientedPoints, Error> {
    match view.normals() {
        Some(normals) => OrientedPoints::new(view.points(), normals),
        None => OrientedPoints::without_normals(view.points()),
    }
}
