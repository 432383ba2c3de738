//! Boundary representation: trimmed faces, edges, shells and parts, and their certified closest points.
//!
//! [`description`] holds what CAD files say, as plain data: readers produce it, writers consume it. [`Model`] is built
//! from it and finds, for any point, the closest point of all trimmed faces and edges, with a lower bound that proves it.
//! The curve of an edge in space is its shape; its image in the parameters of a face is computed, and how far the edge
//! misses the surface is kept as its tolerance.
//!
//! ```
//! use brep_core::description::{
//!     Carrier, FaceDescription, InstanceDescription, ModelDescription, PartDescription, Placement, ShellDescription,
//! };
//! use brep_core::{Model, Side};
//! use nalgebra::Vector3;
//! use nurbs_core::Frame;
//!
//! // A ball: one face without loops.
//! let face = FaceDescription {
//!     name: "ball".to_owned(),
//!     source: 1,
//!     carrier: Carrier::Sphere { frame: Frame::WORLD, radius: 2.0 },
//!     same_sense: true,
//!     loops: Vec::new(),
//! };
//! let shell = ShellDescription { faces: vec![0], closed: true, ..ShellDescription::default() };
//! let part = PartDescription { faces: vec![face], shells: vec![shell], ..PartDescription::default() };
//! let instance = InstanceDescription { part: 0, name: String::new(), placement: Placement::IDENTITY };
//! let description =
//!     ModelDescription { parts: vec![part], instances: vec![instance], ..ModelDescription::default() };
//!
//! let model = Model::new(&description)?;
//! let foot = model.nearest(&Vector3::new(0.0, 0.6, 0.8)).ok_or("not finite")?;
//! assert!((foot.distance - 1.0).abs() < 1e-12 && foot.gap() < 1e-12);
//! assert_eq!(foot.side, Side::Negative);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod area;
mod boundary;
mod carrier;
mod crossings;
pub mod description;
mod edge;
mod edge_curve;
mod error;
mod face;
mod facing;
mod far;
mod foot;
mod jets;
mod model;
mod nearest;
mod parallel;
mod part;
mod samples;
mod sign;
mod tessellate;
mod trace;
mod tree;

pub use crossings::{Crossing, LineSearch};
pub use edge::Edge;
pub use error::Error;
pub use face::Face;
pub use foot::{Foot, On, Side};
pub use model::{Instance, Model};
pub use part::{Part, Shell};
pub use samples::{Picture, Sample};
pub use tessellate::Tessellation;

// The crates whose types occur in the interface of this one.
pub use footpoint;
pub use nalgebra;
pub use nurbs_core;

/// The example of the README, compiled as a test.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
