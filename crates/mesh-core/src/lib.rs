//! Discrete shapes: point clouds and triangle meshes, and the closest points on them.
//!
//! A [`PointCloud`] holds positions and, per point, optional normals, colours and named scalars ([`Attributes`]);
//! a [`TriangleMesh`] holds vertices with the same attributes and triangles that index them.
//! [`MeshProjector`] answers closest point queries on a mesh, with a sign where the mesh encloses a solid.
//!
//! ```
//! use mesh_core::{MeshProjector, TriangleMesh, nalgebra::Point3};
//!
//! let mesh = TriangleMesh::new(
//!     vec![Point3::origin(), Point3::new(1.0, 0.0, 0.0), Point3::new(0.0, 1.0, 0.0)],
//!     vec![[0, 1, 2]],
//! )?;
//! let foot = MeshProjector::new(&mesh)?.project(&Point3::new(0.25, 0.25, 2.0))?;
//! assert_eq!(foot.point, Point3::new(0.25, 0.25, 0.0));
//! assert_eq!(foot.distance, 2.0);
//! # Ok::<(), mesh_core::Error>(())
//! ```

mod attributes;
mod bounds;
mod bvh;
pub mod closest;
mod cloud;
mod error;
mod line_hit;
mod mesh;
mod pseudo_normal;
mod topology;
mod triangle;
mod weld;

pub use attributes::{Attributes, Colours, ScalarField};
pub use bounds::BoundingBox;
pub use closest::{MeshFootpoint, MeshProjector};
pub use cloud::PointCloud;
pub use error::Error;
pub use line_hit::LineHit;
pub use mesh::TriangleMesh;
pub use nalgebra;
pub use topology::MeshTopology;
pub use triangle::Feature;
pub use weld::VertexWelder;
