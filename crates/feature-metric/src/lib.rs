//! The feature sensitive metric: distances on a surface to which the turning of its normal counts.
//!
//! The surface is measured on its image `(x, w n) ∈ R⁶`, points together with unit normals times a length `w`
//! (\[P05, sec. 6\]). Curves along a feature, a fillet or an edge, are as long as in space; curves across it are long, so that
//! distances, geodesics, balls and regions respect features. With `w = 0` all is Euclidean.
//!
//! - [`MetricMesh`]: a mesh with one of the two metrics; geodesic [distances](MetricMesh::distances) by a [`Method`],
//!   [paths](MetricMesh::path), and [morphology](MetricMesh::morphology) by geodesic balls;
//! - [`surface_geodesic`]: geodesic curves on parametric surfaces between two points;
//! - [`parameterize_patch`]: parameters of a patch over a square or a disc, with more room for features.
//!
//! ```
//! use feature_metric::{Method, Metric, MetricMesh};
//! use mesh_core::TriangleMesh;
//! use nalgebra::Point3;
//!
//! // Two squares of side 1 that meet at a right angle.
//! let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0], [1.0, 0.0, 1.0], [1.0, 1.0, 1.0]];
//! let mesh = TriangleMesh::new(
//!     corners.into_iter().map(Point3::from).collect(),
//!     vec![[0, 1, 2], [0, 2, 3], [1, 4, 5], [1, 5, 2]],
//! )?;
//! let plain = MetricMesh::new(&mesh, Metric::Euclidean)?.distances(&[0], Method::Exact)?;
//! assert!((plain.values[4] - 2.0).abs() < 1e-12);
//! // The edge between them costs π/2 · w, but for the chords of the turning normal.
//! let metric = Metric::Feature { width: 1.0 };
//! let feature = MetricMesh::new(&mesh, metric)?.distances(&[0], Method::Exact)?;
//! assert!((feature.values[4] - 2.0 - std::f64::consts::FRAC_PI_2).abs() < 0.01);
//! # Ok::<(), feature_metric::Error>(())
//! ```

mod error;
mod geodesic;
mod mesh;
mod metric;
mod morphology;
mod parameters;
mod surface_geodesic;

pub use error::Error;
pub use geodesic::{Distances, GeodesicPath, Method};
pub use mesh::{InsertedPoint, MetricMesh, insert_point};
pub use metric::Metric;
pub use morphology::Operation;
pub use parameters::{
    ParameterDomain, ParameterOptions, ParameterPlace, PatchParameters, parameterize_patch,
};
pub use surface_geodesic::{GeodesicOptions, SurfaceGeodesic, surface_geodesic};

// The crates whose types occur in the interface of this one.
pub use mesh_core;
pub use nalgebra;
pub use nurbs_core;

/// The example of the README, compiled as a test.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
