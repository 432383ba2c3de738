//! Rigid registration of clouds to shapes and to each other by quadratic models of the squared distance.
//!
//! One loop serves all methods (\[P05, sec. 5\]): the footpoints of the cloud give quadratic models of the squared distance,
//! their sum is minimised in the six unknowns of a velocity field `v(x) = c̄ + c × x`, the cloud follows the helical motion
//! of that field, and again. ICP, the algorithm of Chen and Medioni, and squared distance minimisation differ in the models
//! only ([`ErrorTerm`](distance_field::ErrorTerm)).
//!
//! ```
//! use distance_field::SurfaceField;
//! use nalgebra::{Rotation3, Vector3};
//! use nurbs_core::{BsplineSurface, KnotVector, ParametricSurface};
//! use sdm_register::{Pose, RegisterOptions, Source, register};
//!
//! // A bumpy surface, and points on it that were turned and moved.
//! let knots = KnotVector::uniform_clamped(3, 6)?;
//! let at = |i: usize, j: usize| Vector3::new(i as f64, j as f64, [0.0, 0.9, -0.6, 0.4, 1.1][(2 * i + 3 * j) % 5]);
//! let net = (0..36).map(|k| at(k / 6, k % 6)).collect();
//! let model = BsplineSurface::new(knots.clone(), knots, net, None)?;
//! let motion = Rotation3::from_scaled_axis(Vector3::new(0.1, -0.05, 0.15));
//! let displaced = |k: usize| motion * model.point((k / 20) as f64 / 19.0, (k % 20) as f64 / 19.0) + Vector3::x() * 0.2;
//! let points: Vec<_> = (0..400).map(displaced).collect();
//!
//! let field = SurfaceField::new(&model)?;
//! let report = register(&field, &Source::new(&points), &Pose::identity(), &RegisterOptions::default())?;
//! assert!(report.is_converged() && report.rms < 1e-12);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! Where no pose is known to begin with, [`start`] finds candidates from any position; [`views`] registers many scans of one
//! object to each other, all at once.

mod anderson;
mod comparison;
mod constraint;
mod correlation;
mod covariance;
mod coverage;
mod datum;
mod eigen;
mod ending;
mod error;
mod evidence;
mod fixed;
mod flat;
mod free_motion;
mod free_space;
mod iterate;
mod left_out;
mod lifted;
mod linearise;
mod method;
mod motion;
mod neighbourhood;
mod noise_fixed;
mod one_sided;
mod options;
mod parallel;
mod plan;
mod register;
mod report;
mod resolution;
mod rivals;
mod scale_start;
mod slide_back;
mod solve;
mod source;
pub mod start;
mod superpose;
mod support;
mod symmetry;
mod view;
pub mod views;
mod weights;

pub use comparison::Comparison;
pub use constraint::Locks;
pub use covariance::Covariance;
pub use coverage::Coverage;
pub use datum::{DatumReport, DatumTarget, align_datum, align_datum_from_anywhere};
pub use error::Error;
pub use flat::is_flat;
pub use free_motion::FreeMotion;
pub use free_space::{FreeSpace, Rays, Viewpoint};
pub use iterate::Progress;
pub use left_out::surface_left_out;
pub use lifted::{FeatureApproach, FeatureMatching};
pub use method::Method;
pub use motion::{Displacement, Pose, Velocity, rotation};
pub use options::RegisterOptions;
pub use register::{no_progress, register, register_rest, register_some, register_with_progress};
pub use report::{RegisterReport, RegisterStep};
pub use resolution::shows_a_surface;
pub use rivals::rival_poses;
pub use sdm_core::{FootpointPolicy, Status, StepControl};
pub use source::{NonFinite, Source};
pub use superpose::superpose;
pub use support::{Doubt, Support};
pub use symmetry::{is_symmetry, symmetries, symmetries_and_near};
pub use weights::{Kernel, Outliers, Rejection};

// The crates whose types occur in the interface of this one.
pub use distance_field;
pub use footpoint;
pub use mesh_core;
pub use nalgebra;
pub use nurbs_core;
pub use sdm_core;

/// The example of the README, compiled as a test.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
