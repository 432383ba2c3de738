//! Lines, planes, circles, spheres, cylinders, cones and tori fitted by least squares of orthogonal distances.
//!
//! Each function finds its own initial values from the points alone, and then the minimum to the last digits that the
//! numbers hold: the points are moved to their middle and scaled (exactly), steps of Levenberg and Marquardt come near, and
//! Newton's method finishes with the whole Hessian, so that large residuals and short arcs converge as well.
//!
//! ```
//! use nalgebra::Vector3;
//! use sdm_fit::primitive::{PrimitiveOptions, fit_cylinder};
//!
//! // A quarter of a cylinder of radius 2 around the axis x = 1, y = 0.
//! let at = |i: usize| (0.1 * (i % 16) as f64, 0.3 * (i / 16) as f64);
//! let points: Vec<_> = (0..160).map(at).map(|(a, h)| Vector3::new(1.0 + 2.0 * a.cos(), 2.0 * a.sin(), h)).collect();
//! let fit = fit_cylinder(&points, &PrimitiveOptions::default())?;
//! assert!(fit.is_converged() && fit.rms < 1e-14);
//! assert!((fit.shape.radius() - 2.0).abs() < 1e-12);
//! # Ok::<(), sdm_fit::Error>(())
//! ```

mod apart;
mod descend;
mod elements;
mod fit;
mod flat;
mod minimise;
mod model;
mod options;
mod random;
mod robust;
mod round;
mod search;
mod shapes;
pub(crate) mod start;
mod sums;
mod torus;
mod turned;

pub use elements::{Elements, PrimitiveFit};
pub use options::{PrimitiveOptions, PrimitiveOutliers, PrimitiveStatus};
pub use shapes::{
    fit_circle, fit_circle_in_space, fit_cone, fit_cylinder, fit_line, fit_plane, fit_sphere, fit_torus,
};
