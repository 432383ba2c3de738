//! The search: propose, score, improve, rank.

use footpoint::Progress;
use nalgebra::Vector3;

use super::pairs::{PairTable, SHORTEST};
use super::placement::Placement;
use super::pool::{Pool, SAME, distinct};
use super::random::Random;
use super::refine::{OUTLYING, free_motions, refine};
use super::score::Scorer;
use super::thin::thin;
use super::{OrientedPoints, StartCandidate, StartMethod, StartOptions, StartReport, StartStatus, axes};
use crate::{Error, parallel};

/// Points of the model that score, that make pairs, and the fewest that make a shape.
const MODEL_POINTS: usize = 20_000;
const PAIR_POINTS: usize = 900;
const FEWEST: usize = 3;

/// Points of the cloud: all in all, for improving, for scoring what was improved, and for a first, a second and a third look.
const CLOUD_POINTS: usize = 3000;
const REFINE_POINTS: usize = 300;
const SCORE_POINTS: usize = 1000;
const FIRST_LOOK: usize = 8;
const SECOND_LOOK: usize = 32;
const THIRD_LOOK: usize = 128;

/// Pairs per round, poses per pair, poses that are improved per round.
const PAIRS: usize = 100;
const POSES_PER_PAIR: usize = 300;
const IMPROVED: usize = 24;

/// Distance limit while poses are coarse, and for the ranking of improved ones.
const COARSE: f64 = 0.05;
const MEDIUM: f64 = 0.025;

/// Distance limit down to which poses are improved before they are ranked the first time.
const FINE: f64 = 0.015;

/// The largest tolerance to which deviations of the cloud from the model lead.
const WIDEST: f64 = 0.04;

/// The search ends when its best pose was met in this many rounds.
const VOTES: usize = 3;

/// Radius of inertia of a body of the size 1, about.
const RADIUS: f64 = 0.3;

/// Scores above this share of the best one make the best one ambiguous.
const RIVAL: f64 = 0.97;

/// A model, prepared for coarse starts of any number of clouds.
#[derive(Debug)]
pub struct CoarseStart {
    options: StartOptions,
    centre: Vector3<f64>,
    scale: f64,
    samples: OrientedPoints,
    scorer: Scorer,
    table: PairTable,
}

/// Poses of a cloud on a model, from any position.
///
/// For one cloud; [`CoarseStart`] is for several clouds on the same model.
///
/// # Errors
/// As for [`CoarseStart::new`] and [`CoarseStart::search`].
pub fn coarse_start(
    model: &OrientedPoints,
    cloud: &OrientedPoints,
    options: &StartOptions,
    progress: Progress<'_>,
) -> Result<StartReport, Error> {
    CoarseStart::new(model, options)?.search(cloud, progress)
}

impl CoarseStart {
    /// Prepares a model: some 10,000 evenly spread points are enough.
    ///
    /// # Errors
    /// [`Error::Input`] if there are too few points or all are the same; [`Error::Option`].
    pub fn new(model: &OrientedPoints, options: &StartOptions) -> Result<Self, Error> {
        options.validate()?;
        let bounds = model.bounding_box().filter(|_| model.len() >= FEWEST);
        let bounds = bounds.ok_or_else(|| too_few(model).of("model"))?;
        let (centre, scale) = (bounds.centre(), bounds.diagonal());
        if scale <= 0.0 || !scale.is_finite() {
            return Err(Error::Collinear { width: 0.0, length: scale }.of("model"));
        }
        let mut random = Random::new(options.seed);
        let samples =
            model.scaled(&thin(model.points(), scale / 16.0, MODEL_POINTS, &mut random), &centre, scale);
        let few: Vec<usize> = (0..samples.len().min(PAIR_POINTS)).collect();
        let (table, scorer) = (
            PairTable::new(samples.scaled(&few, &Vector3::zeros(), 1.0), options.oriented),
            Scorer::new(samples.clone(), options.oriented),
        );
        Ok(Self { options: options.clone(), centre, scale, samples, scorer, table })
    }

    /// Looks for poses of a cloud.
    ///
    /// `progress` is told the number of finished rounds and the largest number of rounds, and may cancel.
    ///
    /// # Errors
    /// [`Error::Input`] if there are too few points or all are the same.
    pub fn search(&self, cloud: &OrientedPoints, progress: Progress<'_>) -> Result<StartReport, Error> {
        self.look(cloud, progress)?.report(self.options.tolerance)
    }

    /// [`CoarseStart::search`] before anything is judged, for reports at several tolerances.
    ///
    /// # Errors
    /// As for [`CoarseStart::search`].
    pub fn look(&self, cloud: &OrientedPoints, progress: Progress<'_>) -> Result<StartSearch<'_>, Error> {
        if cloud.len() < FEWEST {
            return Err(too_few(cloud).of("cloud"));
        }
        let mut random = Random::new(self.options.seed.wrapping_add(1));
        let kept = thin(cloud.points(), self.scale / 16.0, CLOUD_POINTS, &mut random);
        let centre = median(&kept.iter().map(|&i| cloud.points()[i]).collect::<Vec<_>>());
        let cloud = cloud.scaled(&kept, &centre, self.scale);
        let mut run = Run::new(self, cloud, random)?;
        if self.options.method != StartMethod::PointPairs {
            run.try_axes();
        }
        let rounds =
            if self.options.method == StartMethod::PrincipalAxes { 0 } else { self.options.max_rounds };
        let mut cancelled = false;
        for round in 1..=rounds {
            if progress(round - 1, rounds).is_break() {
                cancelled = true;
                break;
            }
            run.round(round);
            if run.pool.entries.first().is_some_and(|best| best.votes >= VOTES) {
                break;
            }
        }
        Ok(StartSearch { run, centre, cancelled })
    }
}

/// The poses that a search met.
#[derive(Debug)]
pub struct StartSearch<'a> {
    run: Run<'a>,
    /// Of the cloud.
    centre: Vector3<f64>,
    cancelled: bool,
}

impl StartSearch<'_> {
    /// The best of them, improved and ranked by what lies within a [tolerance](StartOptions::tolerance).
    ///
    /// # Errors
    /// [`Error::Option`] if the tolerance is none.
    pub fn report(&self, tolerance: f64) -> Result<StartReport, Error> {
        self.run.start.options.clone().with_tolerance(tolerance).validate()?;
        Ok(self.run.report(&self.centre, self.cancelled, tolerance))
    }
}

/// Placements of points on themselves, by their principal axes.
pub(crate) fn axis_placements(points: &OrientedPoints) -> Vec<Placement> {
    axes::candidates(points, points)
}

/// Improves placements of points on themselves, whose size is 1, by `count` of them; of those that are the same, one is returned,
/// with the share of the points that comes to lie near.
pub(crate) fn refine_placement(
    points: &OrientedPoints,
    placements: &[Placement],
    count: usize,
) -> Vec<(f64, Placement)> {
    let some: Vec<usize> = (0..points.len()).step_by((points.len() / count.max(1)).max(1)).collect();
    let (scorer, cloud) = (Scorer::new(points.clone(), false), points.scaled(&some, &Vector3::zeros(), 1.0));
    let found = parallel::tasks(placements.len(), |k| {
        let placement = refine(placements[k], &scorer, &cloud, cloud.len(), FINE);
        (scorer.share_and_rms(&placement, &cloud, cloud.len(), MEDIUM).0, placement)
    });
    distinct(found, SAME, RADIUS, placements.len())
}

/// The state of one search.
#[derive(Debug)]
struct Run<'a> {
    start: &'a CoarseStart,
    cloud: OrientedPoints,
    radius: f64,
    random: Random,
    pool: Pool,
    /// The best mean score of the second look so far: what does not reach a part of it in the first look is dropped.
    best_rate: f64,
    tried: usize,
    rounds: usize,
}

impl<'a> Run<'a> {
    fn new(start: &'a CoarseStart, cloud: OrientedPoints, random: Random) -> Result<Self, Error> {
        let mut distances: Vec<f64> = cloud.points().iter().map(Vector3::norm).collect();
        distances.sort_by(f64::total_cmp);
        let radius = distances.get(distances.len() / 2).copied().unwrap_or(0.0);
        if distances.last().is_none_or(|&farthest| farthest <= 0.0) {
            return Err(Error::Collinear { width: 0.0, length: 0.0 }.of("cloud"));
        }
        let pool = Pool::new(radius);
        Ok(Self { start, cloud, radius, random, pool, best_rate: 0.1, tried: 0, rounds: 0 })
    }

    fn try_axes(&mut self) {
        let candidates = axes::candidates(&self.cloud, &self.start.samples);
        self.tried += candidates.len();
        let count = THIRD_LOOK.min(self.cloud.len());
        let scores = parallel::tasks(candidates.len(), |i| {
            self.start.scorer.sum(&candidates[i], &self.cloud, 0..count, COARSE)
        });
        let scored = scores.into_iter().zip(candidates).collect();
        self.improve(scored, StartMethod::PrincipalAxes, 0);
    }

    /// One round over pairs of the cloud.
    fn round(&mut self, round: usize) {
        self.rounds = round;
        let pairs = self.draw_pairs();
        let found = parallel::tasks(pairs.len(), |k| self.poses_of(pairs[k]));
        self.tried += found.iter().map(|(tried, _)| tried).sum::<usize>();
        let scored: Vec<_> = found.into_iter().flat_map(|(_, scored)| scored).collect();
        let best = scored.iter().map(|(score, _)| *score).fold(0.0, f64::max);
        self.best_rate = self.best_rate.max(best / THIRD_LOOK.min(self.cloud.len()) as f64);
        self.improve(scored, StartMethod::PointPairs, round);
    }

    fn draw_pairs(&mut self) -> Vec<[usize; 2]> {
        let mut pairs = Vec::with_capacity(PAIRS);
        for _ in 0..20 * PAIRS {
            let pair = [self.random.below(self.cloud.len()), self.random.below(self.cloud.len())];
            let [a, b] = pair.map(|i| self.cloud.points()[i]);
            if (SHORTEST..2.0 * 0.36).contains(&(a - b).norm()) {
                pairs.push(pair);
                if pairs.len() == PAIRS {
                    break;
                }
            }
        }
        pairs
    }

    /// The best poses by one pair, and how many were tried.
    fn poses_of(&self, pair: [usize; 2]) -> (usize, Vec<(f64, Placement)>) {
        let [first, second, third] =
            [FIRST_LOOK, SECOND_LOOK, THIRD_LOOK].map(|count| count.min(self.cloud.len()));
        let scorer = &self.start.scorer;
        // Few points tell little, so they are asked for less.
        // A rough fit of much of the cloud must not hide an exact fit of a small part.
        let rate = self.best_rate.min(2.0 * self.start.options.min_share);
        let (least, needed) = (0.25 * rate * first as f64, 0.5 * rate * second as f64);
        let (mut tried, mut scored) = (0, Vec::new());
        self.start.table.matches(&self.cloud, pair, POSES_PER_PAIR, |placement| {
            tried += 1;
            let mut score = scorer.sum(&placement, &self.cloud, 0..first, COARSE);
            if score <= least {
                return;
            }
            score += scorer.sum(&placement, &self.cloud, first..second, COARSE);
            if score > needed {
                score += scorer.sum(&placement, &self.cloud, second..third, COARSE);
                scored.push((score, placement));
            }
        });
        (tried, distinct(scored, 2.0 * SAME, self.radius, 3))
    }

    /// Improves the best of scored poses and adds them to the pool.
    fn improve(&mut self, scored: Vec<(f64, Placement)>, method: StartMethod, round: usize) {
        let best = distinct(scored, 2.0 * SAME, self.radius, IMPROVED);
        let (refine_count, score_count) =
            (REFINE_POINTS.min(self.cloud.len()), SCORE_POINTS.min(self.cloud.len()));
        let scorer = &self.start.scorer;
        let improved = parallel::tasks(best.len(), |k| {
            let placement = refine(best[k].1, scorer, &self.cloud, refine_count, FINE);
            let score = scorer.sum(&placement, &self.cloud, 0..score_count, MEDIUM);
            (score / score_count.max(1) as f64, placement)
        });
        for (score, placement) in improved {
            self.pool.add(placement, score, method, round);
        }
    }

    fn report(&self, cloud_centre: &Vector3<f64>, cancelled: bool, tolerance: f64) -> StartReport {
        let (scorer, options) = (&self.start.scorer, &self.start.options);
        let all = self.cloud.len();
        let entries = &self.pool.entries[..self.pool.entries.len().min(2 * options.candidates)];
        let improved = parallel::tasks(entries.len(), |k| {
            refine(entries[k].placement, scorer, &self.cloud, all, tolerance)
        });
        // A cloud that deviates from the model by more than the tolerance is judged by the deviation of the best pose.
        let spreads = parallel::tasks(improved.len(), |k| scorer.spread(&improved[k], &self.cloud, all));
        let least = spreads.iter().copied().fold(f64::INFINITY, f64::min);
        let tolerance = tolerance.max((OUTLYING * least).min(WIDEST));
        let polished: Vec<(f64, Placement)> = parallel::tasks(improved.len(), |k| {
            (scorer.sum(&improved[k], &self.cloud, 0..all, tolerance) / all as f64, improved[k])
        });
        let ranked = distinct(polished.clone(), 0.5 * SAME, self.radius, options.candidates);
        let mut candidates = Vec::new();
        for (score, placement) in &ranked {
            let entry = polished.iter().position(|(_, other)| other == placement).map_or(0, |index| index);
            let (share, rms) = scorer.share_and_rms(placement, &self.cloud, all, tolerance);
            candidates.push(StartCandidate {
                pose: placement.to_pose(cloud_centre, &self.start.centre, self.start.scale),
                score: *score,
                share,
                rms: rms * self.start.scale,
                votes: entries[entry].votes,
                method: entries[entry].method,
            });
        }
        let free = ranked
            .first()
            .map_or(0, |(_, placement)| free_motions(placement, scorer, &self.cloud, all, tolerance));
        let found = candidates.first().is_some_and(|best| best.share >= options.min_share);
        let rivals = candidates.len() > 1 && candidates[1].score > RIVAL * candidates[0].score;
        let status = match (cancelled, found, free > 0 || rivals) {
            (true, ..) => StartStatus::Cancelled,
            (_, false, _) => StartStatus::NotFound,
            (.., true) => StartStatus::Ambiguous,
            _ => StartStatus::Found,
        };
        StartReport {
            status,
            candidates,
            free_motions: free,
            tolerance: tolerance * self.start.scale,
            rounds: self.rounds,
            tried: self.tried,
        }
    }
}

fn too_few(points: &OrientedPoints) -> Error {
    Error::TooFewPoints { total: points.len() + points.dropped(), finite: points.len(), needed: FEWEST }
}

/// The median of each coordinate.
fn median(points: &[Vector3<f64>]) -> Vector3<f64> {
    Vector3::from_fn(|axis, _| {
        let mut values: Vec<f64> = points.iter().map(|point| point[axis]).collect();
        values.sort_by(f64::total_cmp);
        values.get(values.len() / 2).copied().unwrap_or(0.0)
    })
}
