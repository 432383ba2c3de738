//! Principal curvatures and directions of meshes and clouds.

mod cloud;
mod cloud_frames;
mod mesh;
mod quadric;
mod tensor;

pub use cloud::{CloudCurvature, CurvatureOptions, estimate_curvature};
pub use cloud_frames::{FrameOptions, estimate_frames};
pub use mesh::MeshCurvature;
pub use tensor::CurvatureFrame;
