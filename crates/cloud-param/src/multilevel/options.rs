//! Options and report of a multilevel approximation.

use crate::Error;

/// How the proposals of several data for one coefficient are averaged.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(rename_all = "snake_case"))]
pub enum Weighting {
    /// With the squares of the basis functions ([MPK, eq. (5)]): the least local error.
    #[default]
    Squared,
    /// With the basis functions ([MPK, eq. (6)], due to Hjelle): less sensitive to outliers.
    ///
    /// The denominator is the sum of the weights; with the sum of their squares, as printed, the levels diverge.
    Linear,
}

/// What is taken off the data before the first level.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(rename_all = "snake_case"))]
pub enum Trend {
    /// The mean height.
    Mean,
    /// The plane of least squares.
    #[default]
    Plane,
}

/// Options of [`multilevel`](crate::multilevel).
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct MultilevelOptions {
    /// How data that share a coefficient are averaged.
    pub weighting: Weighting,
    /// What is taken off first.
    pub trend: Trend,
    /// Pieces of the coarsest lattice in `x` and `y`; default one along the shorter side, nearly square ones.
    pub spans: Option<[usize; 2]>,
    /// Most levels; default 12.
    pub max_levels: usize,
    /// Root mean square distance that is good enough, as a share of the range of the heights; default 1e-4.
    pub tolerance: f64,
    /// Data per piece, on average, below which no finer level is begun; default 1. With 0 only the number of levels
    /// counts.
    pub data_per_piece: f64,
}

impl Default for MultilevelOptions {
    fn default() -> Self {
        Self {
            weighting: Weighting::default(),
            trend: Trend::default(),
            spans: None,
            max_levels: 12,
            tolerance: 1e-4,
            data_per_piece: 1.0,
        }
    }
}

/// Largest number of coefficients of a lattice.
const MAX_COEFFICIENTS: usize = 1 << 26;

impl MultilevelOptions {
    /// The same options with another weighting.
    #[must_use]
    pub fn with_weighting(self, weighting: Weighting) -> Self {
        Self { weighting, ..self }
    }

    /// The same options with another trend.
    #[must_use]
    pub fn with_trend(self, trend: Trend) -> Self {
        Self { trend, ..self }
    }

    /// The same options with a given coarsest lattice.
    #[must_use]
    pub fn with_spans(self, x: usize, y: usize) -> Self {
        Self { spans: Some([x, y]), ..self }
    }

    /// The same options with another limit on the levels.
    #[must_use]
    pub fn with_max_levels(self, max_levels: usize) -> Self {
        Self { max_levels, ..self }
    }

    /// The same options with another tolerance.
    #[must_use]
    pub fn with_tolerance(self, tolerance: f64) -> Self {
        Self { tolerance, ..self }
    }

    /// The same options with another limit on the resolution.
    #[must_use]
    pub fn with_data_per_piece(self, data_per_piece: f64) -> Self {
        Self { data_per_piece, ..self }
    }

    pub(super) fn check(&self) -> Result<(), Error> {
        let at_least_0 = |name, value: f64| {
            if value >= 0.0 && value.is_finite() {
                Ok(())
            } else {
                Err(Error::Option { name, value, allowed: "a number of at least 0" })
            }
        };
        at_least_0("tolerance", self.tolerance)?;
        at_least_0("data_per_piece", self.data_per_piece)?;
        if self.max_levels == 0 {
            return Err(Error::Option { name: "max_levels", value: 0.0, allowed: "at least 1" });
        }
        match self.spans {
            Some([x, y]) if x == 0 || y == 0 || x.saturating_mul(y) > MAX_COEFFICIENTS => {
                Err(Error::Option {
                    name: "spans",
                    value: x.min(y) as f64,
                    allowed: "at least 1, and not too many",
                })
            }
            _ => Ok(()),
        }
    }

    /// Whether a lattice may be refined.
    pub(super) fn admits(&self, spans: [usize; 2], data: usize) -> bool {
        let pieces = spans[0].saturating_mul(spans[1]).saturating_mul(4);
        pieces <= MAX_COEFFICIENTS && data as f64 >= self.data_per_piece * pieces as f64
    }
}

/// How a multilevel approximation ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(rename_all = "snake_case"))]
#[non_exhaustive]
pub enum MultilevelStatus {
    /// The tolerance is met.
    Converged,
    /// The limit on the levels was reached first.
    MaxLevels,
    /// A finer lattice would have too few data.
    Resolution,
}

/// One level.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct LevelRecord {
    /// Pieces in `x` and `y`.
    pub spans: [usize; 2],
    /// Root mean square of the distances in height after the level.
    pub rms: f64,
    /// The largest of them.
    pub max: f64,
}

/// What a multilevel approximation achieved.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct MultilevelReport {
    /// Points given.
    pub points: usize,
    /// Points that are finite and inside the domain.
    pub used: usize,
    /// How it ended.
    pub status: MultilevelStatus,
    /// Root mean square distance in height at the end.
    pub rms: f64,
    /// Largest distance in height at the end.
    pub max: f64,
    /// Every level.
    pub history: Vec<LevelRecord>,
}

impl MultilevelReport {
    pub(super) fn new(points: usize, used: usize, data: &[[f64; 3]]) -> Self {
        let (rms, max) = size(data);
        Self { points, used, status: MultilevelStatus::MaxLevels, rms, max, history: Vec::new() }
    }

    pub(super) fn push(&mut self, spans: [usize; 2], data: &[[f64; 3]]) {
        (self.rms, self.max) = size(data);
        self.history.push(LevelRecord { spans, rms: self.rms, max: self.max });
    }
}

fn size(data: &[[f64; 3]]) -> (f64, f64) {
    let (sum, max) = data.iter().fold((0.0, 0.0f64), |(s, m), d| (s + d[2] * d[2], m.max(d[2].abs())));
    ((sum / data.len().max(1) as f64).sqrt(), max)
}
