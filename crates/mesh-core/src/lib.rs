//! Discrete shapes: point clouds, polylines and triangle meshes, and what is asked of them.
//!
//! A [`PointCloud`] holds positions and, per point, optional normals, colours and named scalars ([`Attributes`]);
//! a [`TriangleMesh`] holds vertices with the same attributes and triangles that index them.
//!
//! - Closest points: [`MeshProjector`] on a mesh, or on those of its triangles that face a direction, with a sign where the
//!   mesh encloses a solid, [`Polyline`], and [`CloudIndex`] for nearest neighbours in a cloud.
//! - Normals and curvatures: [`estimate_normals`] and [`estimate_curvature`] of clouds, [`TriangleMesh::vertex_normals`]
//!   and [`MeshCurvature`] of meshes.
//! - Connectivity: [`HalfEdgeMesh`] with what is wrong with it, [`LoopScheme`] for subdivision surfaces, [`LoopSurface`] for
//!   their exact limits.
//! - Sampling: [`sample_uniform`], [`sample_poisson_disk`], [`sample_wide_triangles`], [`voxel_downsample`], [`farthest_points`], and outliers by
//!   [`statistical_outliers`] and [`radius_outliers`].
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
mod cloud_index;
mod curvature;
mod error;
mod facing;
mod half_edge;
mod kd_tree;
mod line_hit;
mod loop_subdivision;
mod mesh;
mod nearest_triangle;
mod normal_cone;
mod normals;
mod parallel;
mod polyline;
mod pseudo_normal;
mod random;
mod sampling;
mod seams;
mod sides;
mod spatial_order;
mod texts;
mod topology;
mod triangle;
mod weld;

pub use attributes::{Attributes, Colours, ScalarField};
pub use bounds::BoundingBox;
pub use closest::{MeshFootpoint, MeshProjector};
pub use cloud::PointCloud;
pub use cloud_index::{CloudIndex, Neighbour};
pub use curvature::{
    CloudCurvature, CurvatureFrame, CurvatureOptions, FrameOptions, MeshCurvature, estimate_curvature,
    estimate_frames,
};
pub use error::Error;
pub use facing::FacingFootpoint;
pub use half_edge::{Defects, HalfEdge, HalfEdgeMesh};
pub use line_hit::LineHit;
pub use loop_subdivision::{LimitJet, LimitPoint, LoopScheme, LoopSurface, Mask};
pub use mesh::{TriangleMesh, Weld};
pub use nalgebra;
pub use normals::{
    CloudNormals, NormalOptions, Normals, Orientation, estimate_normals, orient_consistently, orient_towards,
};
pub use polyline::{Polyline, PolylineFootpoint};
pub use sampling::{
    Outliers, SurfaceSample, VoxelPoint, VoxelSample, eliminate_samples, farthest_points, radius_outliers,
    sample_poisson_disk, sample_uniform, sample_wide_triangles, statistical_outliers, voxel_downsample,
};
pub use spatial_order::spatial_order;
pub use texts::TextField;
pub use topology::MeshTopology;
pub use triangle::Feature;
pub use weld::VertexWelder;

/// The example of the README, compiled as a test.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
