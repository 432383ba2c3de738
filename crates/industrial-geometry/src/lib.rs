//! From scans to CAD: one door to the crates of Industrial Geometry.
//!
//! This crate holds no code of its own. Each module below is one crate under a short name; depend on a single crate where one is
//! enough.
//!
//! ```
//! use industrial_geometry::nurbs::nalgebra::Vector2;
//! use industrial_geometry::nurbs::{BsplineCurve, ParametricCurve};
//!
//! let curve = BsplineCurve::bezier(vec![Vector2::new(0.0, 0.0), Vector2::new(1.0, 2.0), Vector2::new(2.0, 0.0)], None)?;
//! assert_eq!(curve.point(0.5), Vector2::new(1.0, 1.0));
//! # Ok::<(), industrial_geometry::nurbs::Error>(())
//! ```

pub use brep_core as brep;
pub use cad_io as cad;
pub use cloud_param;
pub use distance_field;
pub use feature_metric;
pub use footpoint;
pub use inspection;
pub use level_set;
pub use mesh_core as mesh;
pub use nurbs_core as nurbs;
pub use pc_io as io;
pub use picture;
pub use sdm_fit as fit;
pub use sdm_register as register;
pub use segmentation;

/// The example in README.md, compiled and run as a test.
#[cfg(doctest)]
#[doc = include_str!("../../../README.md")]
struct Readme;
