//! Squared distance functions of curves, surfaces, meshes and clouds, and their local quadratic models.
//!
//! Fitting and registration see the world through one trait, [`DistanceField`]: for a query it returns a
//! [`PrincipalFrame`], the footpoint with the principal directions and curvatures there. An [`ErrorTerm`] turns the frame
//! into a [`QuadraticModel`] of the squared distance, and the sum of such models is what one step minimises
//! (\[P05, sec. 3.2\]).

mod analytic;
mod borders;
mod cloud;
mod curve;
mod curve_ends;
mod d2_tree;
mod error;
mod field;
mod frame;
mod local_geometry;
mod mesh;
mod osculating;
mod parallel;
mod pole;
mod quadratic;
mod search;
mod surface;
mod term;

pub use analytic::{AnalyticCurve, AnalyticCurveField, AnalyticField};
pub use cloud::{CloudField, CloudOptions};
pub use curve::CurveField;
pub use d2_tree::{D2Tree, D2TreeOptions, D2TreeReport};
pub use error::Error;
pub use field::DistanceField;
pub use frame::PrincipalFrame;
pub use mesh::{MeshField, MeshGeometry, MeshOptions};
pub use quadratic::QuadraticModel;
pub use search::{Hint, Search};
pub use surface::SurfaceField;
pub use term::ErrorTerm;
