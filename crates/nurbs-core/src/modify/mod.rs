//! Operations that change the description of a shape: knots, degree, extent, orientation, position.
//!
//! All of them work along one parameter on [`rows::ControlRows`], the form that curves and both
//! directions of a surface share.

mod affine;
mod degree;
#[cfg(feature = "fit")]
mod degree_reduction;
mod derivative;
mod iso;
mod join;
mod knot_map;
pub(crate) mod periodic;
mod refine;
mod removal;
mod removal_step;
pub(crate) mod rows;
mod split;

pub use removal::Removal;
