//! Choosing points: on surfaces, out of clouds, and the ones that do not belong.

mod eliminate;
mod farthest;
mod outliers;
mod surface;
mod voxel;

pub use eliminate::eliminate_samples;
pub use farthest::farthest_points;
pub use outliers::{Outliers, radius_outliers, statistical_outliers};
pub use surface::{SurfaceSample, sample_poisson_disk, sample_uniform, sample_wide_triangles};
pub use voxel::{VoxelPoint, VoxelSample, voxel_downsample};
