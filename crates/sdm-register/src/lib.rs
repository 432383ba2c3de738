//! Rigid registration of clouds to shapes and to each other by quadratic models of the squared distance.
//!
//! One loop serves all methods (\[P05, sec. 5\]): the footpoints of the cloud give quadratic models of the squared distance,
//! their sum is minimised in the six unknowns of a velocity field `v(x) = c̄ + c × x`, the cloud follows the helical motion
//! of that field, and again. ICP, the algorithm of Chen and Medioni, and squared distance minimisation differ in the models
//! only ([`ErrorTerm`](distance_field::ErrorTerm)).
//!
//! Where no pose is known to begin with, [`start`] finds candidates from any position; [`views`] registers many scans of one
//! object to each other, all at once.

mod anderson;
mod constraint;
mod covariance;
mod datum;
mod eigen;
mod error;
mod free_motion;
mod iterate;
mod linearise;
mod method;
mod motion;
mod options;
pub(crate) mod parallel;
mod plan;
mod register;
mod report;
mod solve;
mod source;
pub mod start;
mod status;
mod view;
pub mod views;
mod weights;

pub use constraint::Locks;
pub use covariance::Covariance;
pub use datum::{DatumReport, DatumTarget, align_datum};
pub use error::Error;
pub use free_motion::FreeMotion;
pub use iterate::Progress;
pub use method::{FootpointPolicy, Method, StepControl};
pub use motion::{Displacement, Pose, Velocity, rotation};
pub use options::RegisterOptions;
pub use register::{no_progress, register, register_with_progress};
pub use report::{RegisterReport, StepRecord};
pub use source::{NonFinite, Source};
pub use status::Status;
pub use weights::{Kernel, Outliers, Rejection};
