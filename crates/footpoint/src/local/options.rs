//! Options of the local iterations.

use super::Method;

/// When a local iteration stops, and what it repeats.
///
/// ```
/// use footpoint::local::{LocalOptions, Method};
///
/// let options = LocalOptions::default().with_method(Method::Newton).with_max_iterations(20);
/// assert_eq!(options.parameter_tolerance, 1e-12);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct LocalOptions {
    /// The step that is repeated (default [`Method::PrincipalCircle`]).
    pub method: Method,
    /// Most steps taken (default 100). With 0 the initial parameter is only judged.
    pub max_iterations: u32,
    /// Stop when no parameter changes by more than this share of the length of its domain
    /// (default 1e-12).
    pub parameter_tolerance: f64,
    /// Stop when the residual `x − c(t)` is normal to within this angle in radians (default 0: unused).
    ///
    /// In the limit this is the deviation from 90° of the angle `c(t₀) q x` at the foot `q` on the
    /// tangent or circle, but unlike that angle it also tells something for the tangent, on which `q` always
    /// sees `c(t₀)` and `x` under 90°.
    pub angle_tolerance: f64,
    /// The footpoint counts as found if the cosine of the angle between residual and tangent is at most
    /// this (default 1e-8). At a bound only the side inside the domain counts. Tested at exit, it decides
    /// the status.
    pub optimality_tolerance: f64,
}

impl Default for LocalOptions {
    fn default() -> Self {
        Self {
            method: Method::default(),
            max_iterations: 100,
            parameter_tolerance: 1e-12,
            angle_tolerance: 0.0,
            optimality_tolerance: 1e-8,
        }
    }
}

impl LocalOptions {
    /// Sets the method.
    #[must_use]
    pub fn with_method(self, method: Method) -> Self {
        Self { method, ..self }
    }

    /// Sets the most steps taken.
    #[must_use]
    pub fn with_max_iterations(self, max_iterations: u32) -> Self {
        Self { max_iterations, ..self }
    }

    /// Sets the tolerance on parameter increments, relative to the domain.
    #[must_use]
    pub fn with_parameter_tolerance(self, parameter_tolerance: f64) -> Self {
        Self { parameter_tolerance, ..self }
    }

    /// Sets the tolerance on the angle, in radians.
    #[must_use]
    pub fn with_angle_tolerance(self, angle_tolerance: f64) -> Self {
        Self { angle_tolerance, ..self }
    }

    /// Sets the tolerance of the optimality test.
    #[must_use]
    pub fn with_optimality_tolerance(self, optimality_tolerance: f64) -> Self {
        Self { optimality_tolerance, ..self }
    }

    /// Whether a tangential residual passes the optimality test for a residual of the given length.
    pub(crate) fn accepts(&self, tangential: f64, residual: f64, noise: f64) -> bool {
        tangential <= self.optimality_tolerance * residual + noise
    }

    /// Whether the angle rule stops here.
    pub(crate) fn angle_stops(&self, tangential: f64, residual: f64) -> bool {
        tangential < residual * self.angle_tolerance.sin()
    }
}

/// Rounding error to be expected in a residual at coordinates of the given magnitude.
pub(crate) fn residual_noise(magnitude: f64) -> f64 {
    16.0 * f64::EPSILON * magnitude
}
