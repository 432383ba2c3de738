//! Options of a registration.

use crate::weights::{Outliers, Rejection};
use crate::{Error, FootpointPolicy, Locks, Method, NonFinite, StepControl};

/// What a registration does. The defaults are meant for a scan near its place on a model, with or without outliers.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct RegisterOptions<const D: usize> {
    /// Which step is taken; default [`Method::Adaptive`].
    pub method: Method,
    /// How steps are controlled; default [`StepControl::LevenbergMarquardt`].
    pub control: StepControl,
    /// How footpoints are found; default [`FootpointPolicy::Adaptive`].
    pub footpoints: FootpointPolicy,
    /// What is assumed about outliers; default [`Outliers::Automatic`].
    pub outliers: Outliers,
    /// Points that never count; default none.
    pub rejection: Rejection,
    /// Degrees of freedom that are held fast; default none.
    pub locks: Locks<D>,
    /// Whether the scale is estimated, too; default not.
    pub scale: bool,
    /// What is done with points that are not finite; default [`NonFinite::Drop`].
    pub non_finite: NonFinite,
    /// Most steps of one stage; default 100.
    pub max_iterations: usize,
    /// What may be left of the motion at the end, as a share of the size of the cloud; default 1e-13. Rounding sets a
    /// limit of its own where coordinates are large.
    pub tolerance: f64,
    /// Number of points in the stages that only have to come near, at least; default 3000. The last stage has all.
    pub coarse_points: usize,
    /// Distances that count one after the other while outliers are told apart, as shares of the size of the cloud;
    /// default 0.3, 0.1, 0.03.
    pub limits: [f64; 3],
    /// Share of the largest eigenvalue up to which a motion counts as not fixed by the shape; default 1e-8: points
    /// that move by 1 leave the shape by less than 1e-4.
    pub null_tolerance: f64,
}

impl<const D: usize> Default for RegisterOptions<D> {
    fn default() -> Self {
        Self {
            method: Method::default(),
            control: StepControl::LevenbergMarquardt,
            footpoints: FootpointPolicy::default(),
            outliers: Outliers::default(),
            rejection: Rejection::default(),
            locks: Locks::default(),
            scale: false,
            non_finite: NonFinite::default(),
            max_iterations: 100,
            tolerance: 1e-13,
            coarse_points: 3000,
            limits: [0.3, 0.1, 0.03],
            null_tolerance: 1e-8,
        }
    }
}

impl<const D: usize> RegisterOptions<D> {
    /// The same options with another method.
    #[must_use]
    pub fn with_method(self, method: Method) -> Self {
        Self { method, ..self }
    }

    /// The same options with another step control.
    #[must_use]
    pub fn with_control(self, control: StepControl) -> Self {
        Self { control, ..self }
    }

    /// The same options with another way to find footpoints.
    #[must_use]
    pub fn with_footpoints(self, footpoints: FootpointPolicy) -> Self {
        Self { footpoints, ..self }
    }

    /// The same options with another assumption about outliers.
    #[must_use]
    pub fn with_outliers(self, outliers: Outliers) -> Self {
        Self { outliers, ..self }
    }

    /// The same options with other rules for points that never count.
    #[must_use]
    pub fn with_rejection(self, rejection: Rejection) -> Self {
        Self { rejection, ..self }
    }

    /// The same options with locked degrees of freedom.
    #[must_use]
    pub fn with_locks(self, locks: Locks<D>) -> Self {
        Self { locks, ..self }
    }

    /// The same options with or without an unknown scale.
    #[must_use]
    pub fn with_scale(self, scale: bool) -> Self {
        Self { scale, ..self }
    }

    /// The same options with another treatment of points that are not finite.
    #[must_use]
    pub fn with_non_finite(self, non_finite: NonFinite) -> Self {
        Self { non_finite, ..self }
    }

    /// The same options with another limit on the steps of a stage.
    #[must_use]
    pub fn with_max_iterations(self, max_iterations: usize) -> Self {
        Self { max_iterations, ..self }
    }

    /// The same options with another tolerance.
    #[must_use]
    pub fn with_tolerance(self, tolerance: f64) -> Self {
        Self { tolerance, ..self }
    }

    /// The same options with another number of points in the coarse stages.
    #[must_use]
    pub fn with_coarse_points(self, coarse_points: usize) -> Self {
        Self { coarse_points, ..self }
    }

    /// Checks every number.
    pub(crate) fn check(&self) -> Result<(), Error> {
        let at_least = |name, value: f64, low: f64, allowed| {
            if value >= low && value.is_finite() {
                Ok(())
            } else {
                Err(Error::Option { name, value, allowed })
            }
        };
        let positive = |name, value: f64| {
            if value > 0.0 && value.is_finite() {
                Ok(())
            } else {
                Err(Error::Option { name, value, allowed: "a positive number" })
            }
        };
        at_least("tolerance", self.tolerance, 0.0, "a number of at least 0")?;
        at_least("null_tolerance", self.null_tolerance, 0.0, "a number of at least 0")?;
        for limit in self.limits {
            positive("limits", limit)?;
        }
        if let Some(distance) = self.rejection.abs_distance {
            at_least("abs_distance", distance, 0.0, "a length of at least 0")?;
        }
        if let Some(angle) = self.rejection.normal_angle {
            at_least("normal_angle", angle, 0.0, "an angle of at least 0")?;
        }
        match self.outliers {
            Outliers::Trimmed { outliers } if !(0.0..1.0).contains(&outliers) => {
                Err(Error::Option { name: "outliers", value: outliers, allowed: "in [0, 1)" })
            }
            Outliers::Kernel { abs_scale: Some(scale), .. } => positive("abs_scale", scale),
            _ => Ok(()),
        }?;
        let numbers = self.locks.origin.iter().chain(self.locks.axes.iter());
        if !numbers.copied().all(f64::is_finite) {
            return Err(Error::Option { name: "locks", value: f64::NAN, allowed: "finite" });
        }
        let gram = self.locks.axes.tr_mul(&self.locks.axes);
        let deviation = (gram - nalgebra::SMatrix::<f64, D, D>::identity()).norm();
        if deviation > 1e-9 {
            return Err(Error::Option { name: "locks.axes", value: deviation, allowed: "orthonormal" });
        }
        Ok(())
    }
}
