//! Adaptively sampled distance fields (\[P05, sec. 3.1\]; Frisken, Perry, Rockwood & Jones, *Adaptively sampled distance fields*,
//! 2000): a quadtree or an octree whose leaves hold polynomials.
//!
//! A leaf is split until its polynomial agrees with the function at test points. Of degree 3 a field needs far fewer leaves than of
//! degree 1 (the multilinear interpolant of the original) for the same error.
//!
//! ```
//! use distance_field::adaptive::{AdaptiveField, AdaptiveOptions};
//! use distance_field::{DistanceField, Hint, Search};
//! use nalgebra::Vector2;
//!
//! let circle = |p: &Vector2<f64>| p.norm() - 1.0;
//! let options = AdaptiveOptions::default().with_abs_tolerance(1e-5).with_band(Some(0.5));
//! let (field, report) = AdaptiveField::build(Vector2::repeat(-2.0), Vector2::repeat(2.0), &options, circle)?;
//! assert!(report.largest_error <= 1e-5 && report.leaves < 3000);
//! assert!((field.value(&Vector2::new(0.6, 1.0)).unwrap_or(0.0) - circle(&Vector2::new(0.6, 1.0))).abs() < 2e-5);
//! let frame = field.frame(&Vector2::new(1.3, 0.0), Search::Global, &Hint::NONE);
//! assert!((frame.distance - 0.3).abs() < 2e-5 && (frame.curvatures[0] + 1.0).abs() < 0.05);
//! # Ok::<(), distance_field::Error>(())
//! ```

mod bytes;
mod field;
mod polynomial;
mod tree;

pub use tree::{AdaptiveField, AdaptiveOptions, AdaptiveReport};
