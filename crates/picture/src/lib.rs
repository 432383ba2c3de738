//! Pictures of meshes and fields: smooth shading, isolines, curves and colour bars, as PNG and SVG.
//!
//! A scene says what is shown, [`MeshScene::draw`] and [`FieldScene::draw`] make pixels of it, and a [`Sheet`] puts these side by side with
//! titles and a colour bar.
//!
//! ```
//! use mesh_core::TriangleMesh;
//! use nalgebra::Point3;
//! use picture::{MeshScene, Paint, Sheet};
//!
//! let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(Point3::from);
//! let mesh = TriangleMesh::new(corners.to_vec(), vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])?;
//! let values = [0.0, 1.0, 1.0, 1.0];
//! let scene = MeshScene::new(&mesh, Paint::Values { values: &values, range: [0.0, 1.0], lines: 10 });
//! let sheet = Sheet::new().with("distance from a corner", scene.draw(400)).with_bar([0.0, 1.0]);
//! assert!(sheet.to_svg().is_ok_and(|text| text.contains("image/png")));
//! assert!(sheet.to_png().is_ok_and(|bytes| bytes.starts_with(b"\x89PNG")));
//! # Ok::<(), mesh_core::Error>(())
//! ```

mod canvas;
mod colour;
mod field;
mod glyphs;
mod mesh;
mod sheet;

pub use canvas::Raster;
pub use colour::of_label;
pub use field::{FieldScene, Line};
pub use mesh::{Curve, MeshScene, Paint, View};
pub use sheet::Sheet;

// The crates whose types occur in the interface of this one.
pub use mesh_core;
pub use nalgebra;

/// The example of the README, compiled as a test.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
