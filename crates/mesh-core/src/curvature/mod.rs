//! Principal curvatures and directions of meshes and clouds.

mod cloud;
mod mesh;
mod quadric;
mod tensor;

pub use cloud::{CloudCurvature, CurvatureOptions, estimate_curvature};
pub use mesh::MeshCurvature;
pub use tensor::CurvatureFrame;
