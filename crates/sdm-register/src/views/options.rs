//! Options of a registration of many views.

use crate::Error;

/// How many views are registered at once.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(default))]
pub struct ViewsOptions {
    /// The largest distance between points of different views that are taken for the same place at the initial poses, as a
    /// share of the diagonal of a view; default 0.1.
    pub max_distance: f64,
    /// The largest angle between normals of the same place, in radians; default π/4.
    pub max_angle: f64,
    /// Share of a view that another one must cover for the two to be linked; default 0.05.
    pub min_overlap: f64,
    /// Whether the normals of all views point to the same side of the surface; default false: then their signs are ignored.
    pub oriented: bool,
    /// Number of points of each view that are matched with the others; default 1500.
    pub points_per_view: usize,
    /// Number of neighbours that the surface around a point is fitted to; default 28. More are better on noisy scans.
    pub neighbours: usize,
    /// The largest number of steps; default 60.
    pub max_iterations: usize,
    /// Steps that move no view by more than this share of the diagonal end the iteration; default 1e-9. So do steps below a
    /// tenth of the standard error of the mean distance.
    pub tolerance: f64,
    /// Seed of the random choice of points; default 1.
    pub seed: u64,
}

impl Default for ViewsOptions {
    fn default() -> Self {
        Self {
            max_distance: 0.1,
            max_angle: std::f64::consts::FRAC_PI_4,
            min_overlap: 0.05,
            oriented: false,
            points_per_view: 1500,
            neighbours: 28,
            max_iterations: 60,
            tolerance: 1e-9,
            seed: 1,
        }
    }
}

impl ViewsOptions {
    /// Sets the largest relative distance at the initial poses.
    #[must_use]
    pub fn with_max_distance(mut self, max_distance: f64) -> Self {
        self.max_distance = max_distance;
        self
    }

    /// Sets the largest angle between normals, in radians.
    #[must_use]
    pub fn with_max_angle(mut self, max_angle: f64) -> Self {
        self.max_angle = max_angle;
        self
    }

    /// Sets the share of a view that links it to another one.
    #[must_use]
    pub fn with_min_overlap(mut self, min_overlap: f64) -> Self {
        self.min_overlap = min_overlap;
        self
    }

    /// Sets whether the signs of normals are to be trusted.
    #[must_use]
    pub fn with_oriented(mut self, oriented: bool) -> Self {
        self.oriented = oriented;
        self
    }

    /// Sets the number of points of each view that are matched.
    #[must_use]
    pub fn with_points_per_view(mut self, points_per_view: usize) -> Self {
        self.points_per_view = points_per_view;
        self
    }

    /// Sets the number of neighbours for the surface around a point.
    #[must_use]
    pub fn with_neighbours(mut self, neighbours: usize) -> Self {
        self.neighbours = neighbours;
        self
    }

    /// Sets the largest number of steps.
    #[must_use]
    pub fn with_max_iterations(mut self, max_iterations: usize) -> Self {
        self.max_iterations = max_iterations;
        self
    }

    /// Sets the relative size of steps that end the iteration.
    #[must_use]
    pub fn with_tolerance(mut self, tolerance: f64) -> Self {
        self.tolerance = tolerance;
        self
    }

    /// Sets the seed of the random choice of points.
    #[must_use]
    pub fn with_seed(mut self, seed: u64) -> Self {
        self.seed = seed;
        self
    }

    pub(crate) fn validate(&self) -> Result<(), Error> {
        let positive = |value: f64| value > 0.0 && value.is_finite();
        for (name, value, inside, range) in [
            ("max_distance", self.max_distance, positive(self.max_distance), "(0, ∞)"),
            ("max_angle", self.max_angle, positive(self.max_angle), "(0, ∞)"),
            ("min_overlap", self.min_overlap, (0.0..=1.0).contains(&self.min_overlap), "[0, 1]"),
            ("points_per_view", self.points_per_view as f64, self.points_per_view >= 3, "[3, ∞)"),
            ("neighbours", self.neighbours as f64, self.neighbours >= 3, "[3, ∞)"),
            ("tolerance", self.tolerance, self.tolerance >= 0.0, "[0, ∞)"),
        ] {
            if !inside {
                return Err(Error::Option { name, value, allowed: range });
            }
        }
        Ok(())
    }
}
