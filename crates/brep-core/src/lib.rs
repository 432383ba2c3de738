//! Boundary representation: trimmed faces, edges, shells and parts, and their certified closest points.
//!
//! [`description`] holds what CAD files say, as plain data: readers produce it, writers consume it. [`Model`] is built
//! from it and finds, for any point, the closest point of all trimmed faces and edges, with a lower bound that proves it.

mod area;
mod boundary;
mod carrier;
pub mod description;
mod edge;
mod edge_curve;
mod error;
mod face;
mod foot;
mod jets;
mod model;
mod nearest;
mod part;
mod sign;
mod trace;
mod tree;

pub use edge::Edge;
pub use error::Error;
pub use face::Face;
pub use foot::{Foot, On, Side};
pub use model::{Instance, Model};
pub use part::{Part, Shell};
