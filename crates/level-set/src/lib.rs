//! Contours of images and volumes (\[P05, secs. 2, 3.1 and 4.6\]): level sets that are extracted, evolved, and fitted by B-splines.
//!
//! An [`Image`] becomes a level function by a threshold ([`threshold`]), by a region that evolves until its inside and its outside
//! are as even as they can be ([`evolve::chan_vese`]), or by a contour that is drawn to edges ([`evolve::geodesic_contour`]). The zero
//! set of the cubic spline through its values is traced to all digits, and [`fit_contours`] turns it into closed B-splines by
//! squared distance minimisation, each measured against the level set in both directions. Level functions in space become meshes
//! that keep sharp edges ([`surface::dual_contour`]).
//!
//! Coordinates of images are pixels, x to the right and y upwards: the image covers `[0, width] × [0, height]`, and the centre of the
//! lower left pixel is `(½, ½)`. Level functions are negative inside, contours have the inside on their left: outer ones run
//! counter-clockwise, holes clockwise.
//!
//! ```
//! use level_set::{FitOptions, Image, Inside, contours, fit_contours, threshold};
//!
//! // A disc of radius 20 about the middle of 64 x 64 pixels, its edge one pixel wide.
//! let disc = |i: usize, j: usize| {
//!     let (x, y) = (i as f64 + 0.5 - 32.0, j as f64 + 0.5 - 32.0);
//!     255.0 * (20.5 - x.hypot(y)).clamp(0.0, 1.0)
//! };
//! let image = Image::new(64, 64, (0..64 * 64).map(|k| disc(k % 64, k / 64)).collect())?;
//! let level = threshold::otsu(&image)?;
//! let field = contours(&image.level_function(level, Inside::Bright, 1.0)?, Default::default())?;
//! let fitted = fit_contours(&field, field.contours(), &FitOptions::default().with_abs_tolerance(0.02))?;
//! assert!(fitted.len() == 1 && fitted[0].is_within && !fitted[0].is_hole);
//! assert!((fitted[0].area - std::f64::consts::PI * 400.0).abs() < 5.0);
//! # Ok::<(), level_set::Error>(())
//! ```

mod contour;
mod correct;
mod error;
pub mod evolve;
mod fit;
pub mod grid_file;
mod image;
mod measure;
mod parallel;
pub mod region;
pub mod surface;
pub mod threshold;

pub use contour::{contours, signed_area};
pub use error::Error;
pub use fit::{FitOptions, FittedContour, fit_contours};
pub use image::{Image, Inside, write_png};

// The crates whose types occur in the interface of this one.
pub use distance_field;
pub use mesh_core;
pub use nalgebra;
pub use nurbs_core;
pub use sdm_fit;

/// The example of the README, compiled as a test.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
