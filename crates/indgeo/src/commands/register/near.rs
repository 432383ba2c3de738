//! Models that nearly have a symmetry: most of the model lies on itself in other positions, too, and only what is different tells them
//! apart.

use crate::error::Error;
use industrial_geometry::register::{Pose, RegisterReport};

/// Score of a position over that of another one below which it is better, and above which it is worse; between these the points do not
/// tell the two apart.
const BETTER: f64 = 0.8;
const WORSE: f64 = 1.25;
/// Scores that differ by less do not differ: those of points without noise are nearly 0.
const SAME: f64 = 1e-5;
/// Largest score of a position that fits.
const FITTING: f64 = 0.1;
/// Most motions that are tried.
const TRIED: usize = 12;

/// What came of the other positions.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Others {
    /// Whether one of them was better, and taken.
    pub(crate) is_taken: bool,
    /// Those in which the points fit about as well.
    as_good: usize,
}

impl Others {
    /// What is to be said about them.
    pub(crate) fn warning(self) -> Option<String> {
        let taken = self.is_taken.then_some(
            "the model nearly has a symmetry, and the points fit distinctly better in the position that it leads to, which was taken",
        );
        let open = (self.as_good > 0).then(|| {
            format!(
                "the model nearly has a symmetry, and the points fit {} as well: they are not from where the model tells them apart",
                if self.as_good == 1 {
                    "in another position about".to_owned()
                } else {
                    format!("in {} other positions about", self.as_good)
                }
            )
        });
        taken.map(str::to_owned).into_iter().chain(open).reduce(|all, one| format!("{all}; {one}"))
    }
}

/// The result, or the better one of another position to which a near symmetry of the model leads.
///
/// `few` registers as many points as tell whether a position is worth while, `all` registers all.
pub(crate) fn best(
    motions: &[Pose<3>],
    result: RegisterReport<3>,
    score: impl Fn(&Pose<3>) -> f64,
    few: impl Fn(&Pose<3>) -> Result<RegisterReport<3>, Error>,
    all: impl Fn(&Pose<3>) -> Result<RegisterReport<3>, Error>,
) -> Result<(RegisterReport<3>, Others), Error> {
    let own = score(&result.pose);
    let mut scored = Vec::new();
    // The positions in which the points fit best before they are registered there come first.
    let mut starts: Vec<(f64, Pose<3>)> = motions
        .iter()
        .map(|motion| result.pose.followed_by(motion))
        .map(|pose| (score(&pose), pose))
        .collect();
    starts.sort_by(|a, b| a.0.total_cmp(&b.0));
    for (_, start) in starts.iter().take(TRIED) {
        let found = few(start)?;
        if found.is_converged() {
            scored.push((score(&found.pose), found.pose));
        }
    }
    scored.sort_by(|a, b| a.0.total_cmp(&b.0));
    let is_better = |other: f64| other < BETTER * own - SAME;
    let as_good = |own: f64| {
        let alike = |other: f64| other <= WORSE * own + SAME && other >= BETTER * own - SAME;
        scored.iter().filter(|other| alike(other.0) && own < FITTING).count()
    };
    let Some((_, pose)) = scored.first().filter(|(other, _)| is_better(*other)) else {
        return Ok((result, Others { is_taken: false, as_good: as_good(own) }));
    };
    let other = all(pose)?;
    let its = score(&other.pose);
    if !other.is_converged() || !is_better(its) {
        return Ok((result, Others { is_taken: false, as_good: as_good(own) }));
    }
    // What was told of the way there is that of the first result.
    let other = RegisterReport {
        initial_rms: result.initial_rms,
        iterations: result.iterations + other.iterations,
        evaluations: result.evaluations + other.evaluations,
        history: [result.history, other.history].concat(),
        ..other
    };
    let as_good = as_good(its).saturating_sub(1);
    Ok((other, Others { is_taken: true, as_good }))
}
