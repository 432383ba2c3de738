//! What a coarse start found.

use std::fmt;

use super::StartMethod;
use crate::Pose;

/// How the search ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(rename_all = "snake_case"))]
#[non_exhaustive]
pub enum StartStatus {
    /// The first candidate stands out.
    Found,
    /// Other candidates are nearly as good, or the shape lets the cloud move freely along it (plane, sphere, cylinder):
    /// the first candidate is one of several poses.
    Ambiguous,
    /// No pose lays the asked share of the cloud on the model. The candidates are the best that were met.
    NotFound,
    /// The caller cancelled; the candidates are those met so far.
    Cancelled,
}

impl StartStatus {
    /// The name used in files: `found`, `ambiguous`, …
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Found => "found",
            Self::Ambiguous => "ambiguous",
            Self::NotFound => "not_found",
            Self::Cancelled => "cancelled",
        }
    }
}

impl fmt::Display for StartStatus {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// A pose to start from.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct StartCandidate {
    /// Maps the cloud into the frame of the model.
    pub pose: Pose<3>,
    /// `mean max(0, 1 − d²/τ²)` over the cloud, `τ` being the tolerance: between 0 and 1, larger is better.
    pub score: f64,
    /// Share of the cloud within the tolerance.
    pub share: f64,
    /// Root mean square distance of that share, in the units of the model.
    pub rms: f64,
    /// In how many rounds the pose was met.
    pub votes: usize,
    /// Where the pose came from.
    pub method: StartMethod,
}

impl StartCandidate {
    /// Share of the cloud that lies on the model beyond what chance explains: an estimate of the overlap, and little where surfaces
    /// merely cross.
    ///
    /// Points that are near by chance have distances spread evenly up to the tolerance `τ`, with the mean square `τ²/3`: they add
    /// nothing to `Σ (1 − 3 d²/τ²)`, whereas a point that belongs there adds nearly 1.
    #[must_use]
    pub fn excess(&self, tolerance: f64) -> f64 {
        self.share * (1.0 - 3.0 * (self.rms / tolerance).powi(2))
    }
}

/// The candidates of a coarse start, the best first.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct StartReport {
    /// How the search ended.
    pub status: StartStatus,
    /// Poses that differ from each other, by descending score.
    pub candidates: Vec<StartCandidate>,
    /// Independent motions of the best pose that the shape does not resist: 3 for a plane or sphere, 2 for a cylinder.
    pub free_motions: usize,
    /// Distance up to which points counted as lying on the model, in the units of the model: the tolerance of the options, or
    /// three times the spread of the distances where the cloud deviates more.
    pub tolerance: f64,
    /// Number of rounds over pairs.
    pub rounds: usize,
    /// Number of poses that were tried.
    pub tried: usize,
}

impl StartReport {
    /// The best pose, if any was met.
    #[must_use]
    pub fn best(&self) -> Option<&StartCandidate> {
        self.candidates.first()
    }
}

impl fmt::Display for StartReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {} candidates of {} poses", self.status, self.candidates.len(), self.tried)?;
        match self.best() {
            Some(best) => write!(
                f,
                ", best score {:.3} ({:.1} % of the cloud, rms {:.2e})",
                best.score,
                100.0 * best.share,
                best.rms
            ),
            None => Ok(()),
        }
    }
}
