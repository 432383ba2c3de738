//! Distance functions at the nodes of regular grids (\[P05, sec. 3.1\]).
//!
//! Near the sources distances are exact ([`seeds`]). From there [`sweep`] and [`march`] solve `|∇u| = 1`, around obstacles and with a
//! speed as well, and [`carry`] carries the nearest elements themselves. [`redistance`] turns any level function into the distance from
//! its zero set, of fourth order. In the plane, [`Scene`] has the exact shortest ways around
//! polygons.
//!
//! ```
//! use distance_field::grid::{Element, Lattice, Medium, carry, seeds, sweep};
//! use nalgebra::Vector2;
//!
//! let lattice = Lattice::new(Vector2::zeros(), Vector2::new(1.0, 1.0), [65, 65])?;
//! let source = [Element::Point(Vector2::new(0.3, 0.4))];
//! let near = seeds(&lattice, &source, lattice.spacing().norm());
//! let (exact, _) = carry(&lattice, &source, &near);
//! let (swept, _) = sweep(&lattice, &near, &Medium::default());
//! let last = lattice.len() - 1;
//! assert_eq!(exact[last], 0.7f64.hypot(0.6));
//! assert!((swept[last] - exact[last]).abs() < 0.02);
//! # Ok::<(), distance_field::Error>(())
//! ```

mod carry;
mod eikonal;
mod element;
mod inside;
mod lattice;
mod march;
mod medium;
mod redistance;
mod scene;
mod sight;
mod sweep;
mod winding;

pub use carry::carry;
pub use element::{Element, Seed, seeds, seeds_on_faces};
pub use inside::{Inside, InsideRule};
pub use lattice::Lattice;
pub use march::march;
pub use medium::Medium;
pub use redistance::{Redistanced, redistance};
pub use scene::{Path, Scene};
pub use sweep::sweep;
pub use winding::{Outline, Winding};
