//! Level sets in space as triangles (Ju, Losasso, Schaefer & Warren, *Dual contouring of Hermite data*, 2002).
//!
//! A cell through which the level set passes gets a vertex where the tangent planes at its crossings with the edges of the cell meet
//! best, so that sharp edges and corners are kept. A cell through which several sheets pass gets a vertex for each of them
//! (Schaefer, Ju & Warren, *Manifold dual contouring*, 2007); nodes inside touch along edges of the grid only, as in
//! [`region`](crate::region).
//!
//! ```
//! use distance_field::{Grid, LevelSetField};
//! use level_set::surface::{dual_contour, of_field};
//! use nalgebra::Vector3;
//!
//! let sphere = Grid::sample(Vector3::repeat(-1.5), Vector3::repeat(0.1), [31; 3], |p| p.norm() - 1.0)?;
//! let field = LevelSetField::<3>::new(&sphere)?;
//! let mesh = dual_contour(&sphere, of_field(&field))?;
//! assert!(mesh.topology().is_closed() && (mesh.signed_volume() - 4.19).abs() < 0.03);
//! # Ok::<(), level_set::Error>(())
//! ```

mod dual;
mod lattice;
mod mesh_of_cloud;
mod remesh;
mod vertex;

pub use dual::{Crossing, SurfaceGap, dual_contour, of_field, surface_gap};
pub use mesh_of_cloud::mesh_of_cloud;
pub use remesh::{Remeshed, remesh};
