//! Models that nearly have a symmetry: most of the model lies on itself in other positions, too, and only what is different tells them
//! apart.

use crate::error::Error;
use industrial_geometry::register::{Comparison, Pose, RegisterReport};

/// Most positions that are tried, and of those that fit as well, most that are looked at with all points.
const TRIED: usize = 12;
const LOOKED_AT: usize = 3;
/// Largest score of a position that fits.
const FITTING: f64 = 0.5;
/// How often the position may change.
const ROUNDS: usize = 3;

/// What came of the other positions.
#[derive(Clone, Debug, Default)]
pub(crate) struct Others {
    /// Whether one of them was better, and taken.
    pub(crate) is_taken: bool,
    /// Those in which the points fit about as well.
    pub(crate) as_good: Vec<Pose<3>>,
}

impl Others {
    /// What is to be said about the one that was taken.
    pub(crate) fn warning(&self) -> Option<String> {
        self.is_taken.then(|| {
            "the model nearly has a symmetry, and the points fit distinctly better in the position that it leads to, which was taken"
                .to_owned()
        })
    }
}

/// What is known of positions, and how to get to others.
pub(crate) trait Positions {
    /// Poses to which near symmetries of the model lead from a pose, roughly.
    fn beside(&self, pose: &Pose<3>) -> Vec<Pose<3>>;
    /// Mean squared distance of the points with a limit, as a share of the limit squared.
    fn score(&self, pose: &Pose<3>) -> f64;
    /// Which of two poses the points fit better.
    fn comparison(&self, poses: [&Pose<3>; 2]) -> Comparison;
    /// Whether two poses take the points to nearly the same places.
    fn is_same(&self, one: &Pose<3>, other: &Pose<3>) -> bool;
    /// Whether the model does not tell two poses apart.
    fn are_equivalent(&self, one: &Pose<3>, other: &Pose<3>) -> bool;
    /// Registers as many points as tell whether a position is worth while.
    fn few(&self, start: &Pose<3>) -> Result<RegisterReport<3>, Error>;
    /// Registers all points.
    fn all(&self, start: &Pose<3>) -> Result<RegisterReport<3>, Error>;
}

/// The result, or the better one of another position to which a near symmetry of the model leads; and the positions in which
/// the points fit about as well.
pub(crate) fn best(
    positions: &dyn Positions,
    result: RegisterReport<3>,
) -> Result<(RegisterReport<3>, Others), Error> {
    let mut best = result;
    let mut others = Others::default();
    for _ in 0..ROUNDS {
        let found = rivals(positions, &best.pose)?;
        // The first of those that no other one beats.
        let leader = found.iter().fold(best.pose, |leader, pose| {
            if positions.comparison([&leader, pose]).is_second_better() { *pose } else { leader }
        });
        if positions.is_same(&leader, &best.pose) {
            others.as_good = as_good(positions, &best, &found)?;
            break;
        }
        let other = positions.all(&leader)?;
        if !positions.comparison([&best.pose, &other.pose]).is_second_better() {
            others.as_good = as_good(positions, &best, &found)?;
            break;
        }
        // Even where the iteration came to no rest, the points do not belong where they were.
        others.is_taken = true;
        // What was told of the way there is that of the first result.
        best = RegisterReport {
            initial_rms: best.initial_rms,
            iterations: best.iterations + other.iterations,
            evaluations: best.evaluations + other.evaluations,
            history: [best.history, other.history].concat(),
            ..other
        };
    }
    Ok((best, others))
}

/// Where registrations of few points from the most promising positions lead, if not to the pose itself.
fn rivals(positions: &dyn Positions, pose: &Pose<3>) -> Result<Vec<Pose<3>>, Error> {
    // The positions in which the points fit best before they are registered there come first.
    let beside = positions.beside(pose);
    let mut starts: Vec<(f64, Pose<3>)> =
        beside.into_iter().map(|start| (positions.score(&start), start)).collect();
    starts.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut tried: Vec<Pose<3>> = Vec::new();
    let mut found: Vec<Pose<3>> = Vec::new();
    for (_, start) in &starts {
        if tried.iter().any(|known| positions.is_same(known, start)) {
            continue;
        }
        if tried.len() == TRIED {
            break;
        }
        tried.push(*start);
        // Where hardly anything fixes a turn the iteration may be slow, and its end worth a comparison all the same.
        let end = positions.few(start)?;
        let is_new = |known: &Pose<3>| !positions.is_same(known, &end.pose);
        if end.pose.is_finite() && is_new(pose) && found.iter().all(is_new) {
            found.push(end.pose);
        }
    }
    Ok(found)
}

/// Those of other poses in which the points fit about as well, though the model is not the same there.
fn as_good(
    positions: &dyn Positions,
    result: &RegisterReport<3>,
    others: &[Pose<3>],
) -> Result<Vec<Pose<3>>, Error> {
    let pose = &result.pose;
    // Of motions that the points leave free there is no other position.
    if positions.score(pose) > FITTING || !result.free_motions.is_empty() {
        return Ok(Vec::new());
    }
    let is_open = |other: &Pose<3>| {
        !positions.comparison([pose, other]).is_first_better() && !positions.are_equivalent(pose, other)
    };
    let mut open = Vec::new();
    for other in others.iter().filter(|other| is_open(other)).take(LOOKED_AT) {
        // Few points know a pose roughly.
        let end = positions.all(other)?;
        if end.pose.is_finite() && !positions.is_same(pose, &end.pose) && is_open(&end.pose) {
            open.push(end.pose);
        }
    }
    Ok(open)
}
