//! The iteration of squared distance minimisation, shared by fitting and registration.
//!
//! Fitting moves control points and registration moves a rigid body, but both repeat the same step (\[P05, secs. 4, 5\]): footpoints
//! give quadratic models of the squared distance; their sum is minimised; the step is controlled, so that the cost falls. A problem
//! says how it is linearised, solved and moved ([`Problem`]), and [`minimise`] does the rest: the order of the work, the control of
//! the step ([`Controller`]), and the end ([`Status`]).
//!
//! ```
//! use sdm_core::{Controller, StepDirection, Problem, Status, StepControl, StepLimits, StepTaken, Stop, Trial, minimise};
//!
//! /// The foot of a point on the parabola y = x², by the Gauss-Newton method in x.
//! struct Foot {
//!     point: [f64; 2],
//!     x: f64,
//! }
//!
//! struct At {
//!     x: f64,
//!     cost: f64,
//! }
//!
//! impl Trial for At {
//!     fn cost(&self) -> f64 {
//!         self.cost
//!     }
//! }
//!
//! impl Foot {
//!     fn at(&self, x: f64) -> At {
//!         At { x, cost: (x - self.point[0]).powi(2) + (x * x - self.point[1]).powi(2) }
//!     }
//! }
//!
//! impl Problem for Foot {
//!     /// Squared length and half the gradient of the cost.
//!     type Linear = [f64; 2];
//!     type Step = f64;
//!     type Trial = At;
//!     type Error = std::convert::Infallible;
//!
//!     fn linearise(&mut self) -> Result<[f64; 2], Stop<Self::Error>> {
//!         let x = self.x;
//!         Ok([1.0 + 4.0 * x * x, (x - self.point[0]) + 2.0 * x * (x * x - self.point[1])])
//!     }
//!     fn cost(&self, _: &[f64; 2]) -> f64 {
//!         self.at(self.x).cost
//!     }
//!     fn direction(&mut self, linear: &[f64; 2], damping: f64) -> Result<StepDirection<f64>, Stop<Self::Error>> {
//!         let step = -linear[1] / (linear[0] * (1.0 + damping));
//!         Ok(StepDirection::along(step, 2.0 * linear[1] * step))
//!     }
//!     fn advance(&mut self, _: &[f64; 2], step: &f64, factor: f64) -> Result<Option<At>, Stop<Self::Error>> {
//!         Ok(Some(self.at(self.x + factor * step)))
//!     }
//!     fn accept(&mut self, _: [f64; 2], trial: At, _: StepTaken) -> Result<(), Stop<Self::Error>> {
//!         let moved = (trial.x - self.x).abs();
//!         self.x = trial.x;
//!         if moved < 1e-12 { Err(Stop::Ended(Status::Converged)) } else { Ok(()) }
//!     }
//! }
//!
//! let mut foot = Foot { point: [0.0, 1.0], x: 1.5 };
//! let mut control = Controller::new(StepControl::LevenbergMarquardt, StepLimits::default());
//! assert_eq!(minimise(&mut foot, &mut control, 100), Ok(Status::Converged));
//! assert!((foot.x - 0.5f64.sqrt()).abs() < 1e-9);
//! ```

mod control;
mod minimise;
mod policy;
mod robust;
mod status;

pub use control::{Controller, StepControl, StepLimits, StepTaken};
pub use minimise::{Exhausted, Problem, StepDirection, Stop, Trial, minimise};
pub use policy::FootpointPolicy;
pub use robust::{Robust, trim_limit};
pub use status::Status;

// The crates whose types occur in the interface of this one.
pub use distance_field;

/// Called after each step with its record; [`Break`](std::ops::ControlFlow::Break) cancels.
pub type Progress<'a, T> = &'a (dyn Fn(&T) -> std::ops::ControlFlow<()> + Sync);
