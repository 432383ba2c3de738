//! Squared distance functions of curves, surfaces, meshes and clouds, and their local quadratic models.
//!
//! Fitting and registration see the world through one trait, [`DistanceField`]: for a query it returns a
//! [`PrincipalFrame`], the footpoint with the principal directions and curvatures there. An [`ErrorTerm`] turns the frame
//! into a [`QuadraticModel`] of the squared distance, and the sum of such models is what one step minimises
//! (\[P05, sec. 3.2\]).
//!
//! | shape | field | feet | tangent directions |
//! |---|---|---|---|
//! | NURBS surfaces | [`SurfaceField`] | exact, certified | 2 inside, 1 on edges and kinks, 0 at corners |
//! | NURBS curves | [`CurveField`] | exact, certified | 1, 0 at ends and kinks |
//! | plane, sphere, cylinder, cone, torus | [`AnalyticField`] | closed form | as for surfaces |
//! | line, circle | [`AnalyticCurveField`] | closed form | as for curves |
//! | triangle meshes | [`MeshField`] | exact | 2 ([`MeshGeometry::Smooth`]), 1 and 0 on boundaries |
//! | Loop subdivision surfaces | [`LoopField`] | exact, not certified | 2 inside, 1 on the boundary |
//! | dense clouds | [`CloudField`] | on quadrics at the points | 2 |
//! | noisy clouds | [`MlsField`] | on a moving least squares surface | 2 |
//! | adaptively sampled distances | [`adaptive::AdaptiveField`] | within their tolerance | 2 in space, 1 in the plane |
//! | level sets on grids | [`LevelSetField`] | exact for the spline through the values | 2 in space, 1 in the plane |
//! | offsets of these | [`OffsetField`] | on the normals of the shape | all |
//! | any of these | [`D2Tree`] | none: precomputed models | as in the field it is made of |
//!
//! All of them at once, as a registration does:
//!
//! ```
//! use distance_field::{AnalyticField, CloudField, DistanceField, ErrorTerm, MeshField, Search, SurfaceField};
//! use mesh_core::TriangleMesh;
//! use nalgebra::{Point3, Vector3};
//! use nurbs_core::{Frame, Sphere, TessellationOptions};
//!
//! let sphere = Sphere::new(Frame::WORLD, 1.0)?;
//! let surface = sphere.to_nurbs()?;
//! let tessellation = surface.tessellate(&TessellationOptions::new(1e-3).with_weld(true))?;
//! let points: Vec<_> = tessellation.vertices.iter().copied().map(Point3::from).collect();
//! let mesh = TriangleMesh::new(points.clone(), tessellation.triangles)?;
//!
//! let fields: [Box<dyn DistanceField<3>>; 4] = [
//!     Box::new(SurfaceField::new(&surface)?),
//!     Box::new(AnalyticField::new(sphere)?),
//!     Box::new(MeshField::new(&mesh)?),
//!     Box::new(CloudField::new(&points, None)?),
//! ];
//! let scan = [Vector3::new(0.9, 0.5, 0.2), Vector3::new(-0.2, 0.4, 0.8)];
//! for field in fields {
//!     for (x, frame) in scan.iter().zip(field.frames(&scan, Search::Global, &[])) {
//!         let model = ErrorTerm::SquaredDistance.model(&frame);
//!         assert!((model.value(x) - (x.norm() - 1.0).powi(2)).abs() < 1e-2);
//!     }
//! }
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub mod adaptive;
mod analytic;
mod borders;
mod brep;
mod cloud;
mod cloud_site;
mod curve;
mod curve_ends;
mod d2_tree;
mod error;
mod field;
mod frame;
pub mod grid;
mod implicit;
mod kernel;
mod level_set;
mod local_geometry;
mod loop_surface;
mod mesh;
mod mls;
mod offset;
mod osculating;
mod parallel;
mod planar_cloud;
mod pole;
mod quadratic;
mod search;
mod spread;
mod surface;
mod term;

pub use analytic::{AnalyticCurve, AnalyticCurveField, AnalyticField};
pub use brep::BrepField;
pub use cloud::{CloudField, CloudOptions};
pub use curve::CurveField;
pub use d2_tree::{D2Tree, D2TreeOptions, D2TreeReport};
pub use error::Error;
pub use field::DistanceField;
pub use frame::PrincipalFrame;
pub use kernel::Kernel;
pub use level_set::{Grid, LevelSetField, Saddles};
pub use loop_surface::LoopField;
pub use mesh::{MeshField, MeshGeometry, MeshOptions};
pub use mls::{MlsField, MlsOptions};
pub use offset::OffsetField;
pub use planar_cloud::PlanarCloudField;
pub use quadratic::QuadraticModel;
pub use search::{Hint, Search};
pub use spread::{Spread, quantile_in_place};
pub use surface::SurfaceField;
pub use term::ErrorTerm;

// The crates whose types occur in the interface of this one.
pub use brep_core;
pub use footpoint;
pub use mesh_core;
pub use nalgebra;
pub use nurbs_core;

/// The example of the README, compiled as a test.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
