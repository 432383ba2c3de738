//! How hard a projection tries.

use crate::Error;

/// What is done to find the footpoint.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(rename_all = "snake_case"))]
pub enum Mode {
    /// Global search with a proof that no other point is nearer (but for the gap).
    #[default]
    Certified,
    /// Local iterations from the most promising places only; no proof.
    ///
    /// Every piece whose bounds do not exclude a nearer point (the 32 nearest at most) is sampled on a grid, eight
    /// places or more in each direction, and the distance is followed from each dip that may lead lower. The answer is
    /// always a true point of the shape with its distance, and a local minimum; another minimum that is nearer is
    /// missed only where it hides between samples. Patches with a collapsed edge are searched as for a proof, since next
    /// to a pole no sample leads to the foot. For wavy surfaces and tight turns within one piece, certify.
    Fast,
    /// One local iteration, from the place next to the point of a few on the pieces around it; no proof.
    ///
    /// The answer is a true point of the shape with its distance, and a local minimum, but often not the nearest one where
    /// the shape comes near the point twice. It does not depend on other points. From a known start
    /// [`SurfaceProjector::project_from`](crate::SurfaceProjector::project_from) does the same.
    Local,
}

/// Options of a projection.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct ProjectionOptions {
    /// What is done; default [`Mode::Certified`].
    pub mode: Mode,
    /// Allowed gap between distance and lower bound as a share of the distance; default 1e-7.
    pub relative_gap: f64,
    /// Allowed gap as a share of the size of the model, the largest side of its bounding box; default 1e-10.
    pub size_gap: f64,
    /// Relative difference below which two distances count as equal (ties); default 1e-9.
    pub tie_tolerance: f64,
    /// Work for one query after which a proof is given up, with the weaker bound reported; default 20 000, about a millisecond.
    ///
    /// A part of a bicubic patch that is examined counts about ten, more for higher degrees. Up to a quarter is kept for the search without
    /// a proof that follows where a proof is given up.
    pub max_boxes: u32,
}

impl Default for ProjectionOptions {
    fn default() -> Self {
        Self {
            mode: Mode::Certified,
            relative_gap: 1e-7,
            size_gap: 1e-10,
            tie_tolerance: 1e-9,
            max_boxes: 20_000,
        }
    }
}

impl ProjectionOptions {
    /// The same options with another mode.
    #[must_use]
    pub fn with_mode(self, mode: Mode) -> Self {
        Self { mode, ..self }
    }

    /// The same options with another relative gap.
    #[must_use]
    pub fn with_relative_gap(self, relative_gap: f64) -> Self {
        Self { relative_gap, ..self }
    }

    /// The same options with another gap as a share of the size of the model.
    #[must_use]
    pub fn with_size_gap(self, size_gap: f64) -> Self {
        Self { size_gap, ..self }
    }

    /// Checks that every tolerance is usable.
    ///
    /// # Errors
    /// [`Error::Option`] for a gap that is NaN, negative or not below 1.
    pub fn validate(&self) -> Result<(), Error> {
        let gaps = [
            ("relative_gap", self.relative_gap),
            ("size_gap", self.size_gap),
            ("tie_tolerance", self.tie_tolerance),
        ];
        for (option, value) in gaps {
            if !(0.0..1.0).contains(&value) {
                return Err(Error::Option { option, value, what: "it must be at least 0 and below 1" });
            }
        }
        Ok(())
    }
}

/// Options of an update of known footpoints.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct UpdateOptions {
    /// Largest number of steps of the local iteration for each point, at least 1; default 50.
    ///
    /// A foot that needs more has [`Status::MaxIterations`](crate::Status::MaxIterations); it is not further away than the
    /// one before.
    pub max_steps: u32,
}

impl Default for UpdateOptions {
    fn default() -> Self {
        Self { max_steps: 50 }
    }
}

impl UpdateOptions {
    /// The same options with another limit of the steps.
    #[must_use]
    pub fn with_max_steps(self, max_steps: u32) -> Self {
        Self { max_steps }
    }

    /// Checks that the limit is usable.
    ///
    /// # Errors
    /// [`Error::Option`] for a limit of 0.
    pub fn validate(&self) -> Result<(), Error> {
        if self.max_steps == 0 {
            return Err(Error::Option { option: "max_steps", value: 0.0, what: "it must be at least 1" });
        }
        Ok(())
    }
}
