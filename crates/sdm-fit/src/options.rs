//! Options of a fit.

use crate::Error;
use distance_field::ErrorTerm;
use sdm_core::{FootpointPolicy, Robust, StepControl};

/// How the factor `λ` of the smoothing energy is chosen (\[P05, eq. (7)\], with the mean in place of the sum).
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(rename_all = "snake_case"))]
pub enum Smoothing {
    /// Always the same.
    Fixed {
        /// `λ`, at least 0.
        lambda: f64,
    },
    /// From `start`, multiplied by `factor` in each iteration, down to `floor`.
    Continuation {
        /// First `λ`.
        start: f64,
        /// Factor of each iteration, below 1.
        factor: f64,
        /// Least `λ`.
        floor: f64,
    },
    /// As a continuation, but not below the value that the data ask for: the largest one whose generalised cross validation
    /// score is as good as the best. Where the distances of
    /// neighbours agree there is no noise to be seen, and it falls on; data without noise lead to 0.
    Automatic {
        /// First `λ`.
        start: f64,
        /// Factor of each iteration, below 1.
        factor: f64,
    },
}

impl Smoothing {
    /// No energy.
    pub const NONE: Self = Self::Fixed { lambda: 0.0 };
    /// The continuation from 0.01 to 0 by halves.
    pub const CONTINUATION: Self = Self::Continuation { start: 1e-2, factor: 0.5, floor: 0.0 };
}

impl Default for Smoothing {
    fn default() -> Self {
        Self::Automatic { start: 1e-2, factor: 0.5 }
    }
}

/// What a fit does.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct FitOptions {
    /// Which model stands for the squared distance; default [`ErrorTerm::SquaredDistance`].
    pub term: ErrorTerm,
    /// How steps are controlled; default [`StepControl::Armijo`].
    pub control: StepControl,
    /// Least damping of displacements in every step, as a share of the mean of the diagonal of the normal equations; default 0. What
    /// hardly changes the distances, as motions in the tangent planes, stays near where it is with a little of it.
    pub damping: f64,
    /// How much the energy counts; default [`Smoothing::Automatic`].
    pub smoothing: Smoothing,
    /// Factors of the squared first, second and third derivatives in the energy; default 0.1, 1, 0.
    pub energy: [f64; 3],
    /// Factor of the part of the energy that lies in the tangent planes, besides `λ`: it keeps parameter lines even, where
    /// tangent and squared distance terms leave them to the noise, and hardly changes the shape; default 0. Only for shapes
    /// with normals (surfaces).
    pub fairing: f64,
    /// The largest share of the mean squared distance that the fairing may be; where it would be more, its factor is smaller in that
    /// step, so that it vanishes with the distances. Default none.
    pub fairing_cap: Option<f64>,
    /// What is assumed about outliers; default [`Robust::None`].
    pub robust: Robust,
    /// How footpoints are found; default [`FootpointPolicy::Adaptive`].
    pub footpoints: FootpointPolicy,
    /// Most iterations; default 100.
    pub max_iterations: usize,
    /// Stop when no coefficient moves by more than this share of the size of the shape; default 1e-10.
    pub tolerance: f64,
    /// Stop when the cost changes by no more than this share in three iterations one after the other; default 1e-6. So it does when the
    /// cost falls slowly, by less than the square of 1e-7 of the size: that is rounding, on data without noise.
    pub cost_tolerance: f64,
    /// Stop when the root mean square distance is not above this; default none.
    pub abs_goal: Option<f64>,
    /// Whether the coefficients of every iteration are kept, to draw the evolution of the shape; default not.
    pub evolution: bool,
}

impl Default for FitOptions {
    fn default() -> Self {
        Self {
            term: ErrorTerm::SquaredDistance,
            control: StepControl::Armijo,
            damping: 0.0,
            smoothing: Smoothing::default(),
            energy: [0.1, 1.0, 0.0],
            fairing: 0.0,
            fairing_cap: None,
            robust: Robust::None,
            footpoints: FootpointPolicy::Adaptive,
            max_iterations: 100,
            tolerance: 1e-10,
            cost_tolerance: 1e-6,
            abs_goal: None,
            evolution: false,
        }
    }
}

macro_rules! setters {
    ($($(#[$doc:meta])* $name:ident($field:ident: $type:ty);)*) => {$(
        $(#[$doc])*
        #[must_use]
        pub fn $name(self, $field: $type) -> Self {
            Self { $field, ..self }
        }
    )*};
}

impl FitOptions {
    setters! {
        /// The same options with another error term.
        with_term(term: ErrorTerm);
        /// The same options with another step control.
        with_control(control: StepControl);
        /// The same options with another least damping.
        with_damping(damping: f64);
        /// The same options with another smoothing.
        with_smoothing(smoothing: Smoothing);
        /// The same options with another energy.
        with_energy(energy: [f64; 3]);
        /// The same options with another fairing of the parameterisation.
        with_fairing(fairing: f64);
        /// The same options with or without a largest share of the fairing.
        with_fairing_cap(fairing_cap: Option<f64>);
        /// The same options with another assumption about outliers.
        with_robust(robust: Robust);
        /// The same options with another way to find footpoints.
        with_footpoints(footpoints: FootpointPolicy);
        /// The same options with another limit on the iterations.
        with_max_iterations(max_iterations: usize);
        /// The same options with another tolerance on the displacement.
        with_tolerance(tolerance: f64);
        /// The same options with another tolerance on the cost.
        with_cost_tolerance(cost_tolerance: f64);
        /// The same options with or without a distance that is good enough.
        with_abs_goal(abs_goal: Option<f64>);
        /// The same options, keeping the evolution or not.
        with_evolution(evolution: bool);
    }

    /// Checks every number.
    ///
    /// # Errors
    /// [`Error::Option`].
    pub fn check(&self) -> Result<(), Error> {
        let at_least_0 = |name, value: f64| {
            if value >= 0.0 && value.is_finite() {
                Ok(())
            } else {
                Err(Error::Option { name, value, allowed: "a number of at least 0" })
            }
        };
        let factor_below_1 = |value: f64| {
            if value > 0.0 && value < 1.0 {
                Ok(())
            } else {
                Err(Error::Option { name: "factor", value, allowed: "in (0, 1)" })
            }
        };
        at_least_0("tolerance", self.tolerance)?;
        at_least_0("cost_tolerance", self.cost_tolerance)?;
        at_least_0("fairing", self.fairing)?;
        at_least_0("fairing_cap", self.fairing_cap.unwrap_or(0.0))?;
        at_least_0("damping", self.damping)?;
        self.energy.into_iter().try_for_each(|value| at_least_0("energy", value))?;
        at_least_0("abs_goal", self.abs_goal.unwrap_or(0.0))?;
        match self.smoothing {
            Smoothing::Fixed { lambda } => at_least_0("lambda", lambda)?,
            Smoothing::Continuation { start, factor, floor } => {
                at_least_0("start", start)?;
                at_least_0("floor", floor)?;
                factor_below_1(factor)?;
            }
            Smoothing::Automatic { start, factor } => {
                at_least_0("start", start)?;
                factor_below_1(factor)?;
            }
        }
        match self.robust {
            Robust::Kernel { abs_scale: Some(value), .. } if !(value > 0.0 && value.is_finite()) => {
                Err(Error::Option { name: "abs_scale", value, allowed: "a positive length" })
            }
            Robust::Trimmed { outliers } if !(0.0..1.0).contains(&outliers) => {
                Err(Error::Option { name: "outliers", value: outliers, allowed: "in [0, 1)" })
            }
            _ => Ok(()),
        }
    }
}
