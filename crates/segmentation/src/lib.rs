//! Clouds and meshes segmented into regions that one surface carries each: planes, cylinders, cones, spheres, tori, extrusions, surfaces
//! of revolution, helical surfaces and free-form regions.
//!
//! [`segment`] finds the regions, the type and parameters of each with their covariance, and what else the type might have been. All
//! thresholds are multiples of the noise, which is found from the points, and of their spacing: there is no length to be chosen.
//!
//! ```
//! use nalgebra::Point3;
//! use segmentation::{SegmentationOptions, Shape, segment};
//!
//! // A cylinder of radius 2 and its cover.
//! let around = |i: usize| std::f64::consts::TAU * (i % 60) as f64 / 60.0;
//! let side = (0..1200).map(|i| Point3::new(2.0 * around(i).cos(), 2.0 * around(i).sin(), 0.2 * (i / 60) as f64 + 0.1));
//! let cover = (0..400).map(|i| Point3::new(0.2 * (i % 20) as f64 - 1.9, 0.2 * (i / 20) as f64 - 1.9, 0.0));
//! let points: Vec<_> = side.chain(cover.filter(|p| p.coords.norm() < 2.0)).collect();
//! let found = segment(&points, None, &SegmentationOptions::default())?;
//! assert!(found.regions.iter().any(|r| matches!(r.shape, Shape::Cylinder { radius, .. } if (radius - 2.0).abs() < 1e-6)));
//! # Ok::<(), segmentation::Error>(())
//! ```

mod assign;
mod border;
mod carrier;
mod common;
mod decide;
mod describe;
mod error;
mod extrude;
mod graph;
mod grow;
mod jets;
mod least_squares;
mod leftover;
mod merge;
mod options;
mod parallel;
mod regular;
mod report;
mod segment;
mod smooth;
mod sweep;
mod trend;
mod uncertainty;
mod velocity;

pub use error::Error;
pub use nalgebra;
pub use options::SegmentationOptions;
pub use report::{RegionReport, RunnerUp, Segmentation, Shape};
pub use segment::segment;

// The crates whose types occur in the interface of this one.
pub use mesh_core;

/// The example of the README, compiled as a test.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
