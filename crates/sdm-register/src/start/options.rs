//! Options of a coarse start.

use crate::Error;

/// Where the poses that a coarse start tries come from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "snake_case"))]
pub enum StartMethod {
    /// Principal axes and pairs.
    #[default]
    Automatic,
    /// Principal axes alone, in all ways that the axes and their ties allow. For whole scans of shapes that are no bodies
    /// of revolution; some milliseconds.
    PrincipalAxes,
    /// Pairs of oriented points alone. For any rotation, parts of the shape and outliers.
    PointPairs,
}

impl StartMethod {
    /// The name used in files and options: `automatic`, `principal_axes`, `point_pairs`.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Automatic => "automatic",
            Self::PrincipalAxes => "principal_axes",
            Self::PointPairs => "point_pairs",
        }
    }
}

/// How a coarse start looks for poses.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(default))]
pub struct StartOptions {
    /// Where poses come from; default [`StartMethod::Automatic`].
    pub method: StartMethod,
    /// Number of candidates that are reported; default 6.
    pub candidates: usize,
    /// The smallest share of the cloud that must lie on the model for a pose to count as found; default 0.15.
    pub min_share: f64,
    /// Distance up to which a point of the cloud counts as lying on the model, as a share of the diagonal of the model's
    /// box; default 0.012. Clouds that deviate more are judged by three times the spread of their distances.
    pub tolerance: f64,
    /// Whether the normals of cloud and model point to the same side of the surface; default false: then their signs are
    /// ignored. True is faster and tells thin walls apart.
    pub oriented: bool,
    /// Rounds of 100 pairs each before the search gives up; default 40. It ends sooner when the best pose has been met
    /// several times.
    pub max_rounds: usize,
    /// Seed of the random choices; default 1. The same seed gives the same result.
    pub seed: u64,
}

impl Default for StartOptions {
    fn default() -> Self {
        Self {
            method: StartMethod::Automatic,
            candidates: 6,
            min_share: 0.15,
            tolerance: 0.012,
            oriented: false,
            max_rounds: 40,
            seed: 1,
        }
    }
}

impl StartOptions {
    /// Sets where poses come from.
    #[must_use]
    pub fn with_method(mut self, method: StartMethod) -> Self {
        self.method = method;
        self
    }

    /// Sets the number of candidates that are reported.
    #[must_use]
    pub fn with_candidates(mut self, candidates: usize) -> Self {
        self.candidates = candidates;
        self
    }

    /// Sets the smallest share of the cloud that must lie on the model.
    #[must_use]
    pub fn with_min_share(mut self, min_share: f64) -> Self {
        self.min_share = min_share;
        self
    }

    /// Sets the relative distance up to which a point counts as lying on the model.
    #[must_use]
    pub fn with_tolerance(mut self, tolerance: f64) -> Self {
        self.tolerance = tolerance;
        self
    }

    /// Sets whether the signs of the normals are to be trusted.
    #[must_use]
    pub fn with_oriented(mut self, oriented: bool) -> Self {
        self.oriented = oriented;
        self
    }

    /// Sets the largest number of rounds.
    #[must_use]
    pub fn with_max_rounds(mut self, max_rounds: usize) -> Self {
        self.max_rounds = max_rounds;
        self
    }

    /// Sets the seed of the random choices.
    #[must_use]
    pub fn with_seed(mut self, seed: u64) -> Self {
        self.seed = seed;
        self
    }

    pub(crate) fn validate(&self) -> Result<(), Error> {
        for (name, value, inside, range) in [
            ("min_share", self.min_share, (0.0..=1.0).contains(&self.min_share), "[0, 1]"),
            ("tolerance", self.tolerance, self.tolerance > 0.0 && self.tolerance <= 0.05, "(0, 0.05]"),
        ] {
            if !inside {
                return Err(Error::Option { name, value, allowed: range });
            }
        }
        Ok(())
    }
}
