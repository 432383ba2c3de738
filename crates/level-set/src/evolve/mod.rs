//! Level sets that move (\[P05, sec. 2\]; Osher & Sethian 1988): upwind differences of fifth order in space, Runge-Kutta in time, in a
//! narrow band around the zero set.
//!
//! [`Evolution`] moves a level set by given speeds: along its normals, by its curvature, and with a flow. [`chan_vese`] and
//! [`geodesic_contour`] are the two segmentations built on it. Level sets may part, join and vanish, unless their topology is held.
//!
//! ```
//! use distance_field::Grid;
//! use level_set::evolve::{Evolution, EvolutionOptions, Motion};
//! use nalgebra::Vector2;
//!
//! // A circle that grows at speed 1, from radius 0.5 for a time of 0.25.
//! let circle = Grid::sample(Vector2::repeat(-1.0), Vector2::repeat(0.04), [51, 51], |p| p.norm() - 0.5)?;
//! let mut evolution = Evolution::new(&circle, &EvolutionOptions::default())?;
//! let speed = vec![1.0; 51 * 51];
//! evolution.run(&Motion::default().with_propagation(&speed), 0.25)?;
//! let value = evolution.grid().values()[25 * 51 + 25 + 19];
//! assert!((value - (19.0 * 0.04 - 0.75)).abs() < 1e-3, "{value}");
//! # Ok::<(), level_set::Error>(())
//! ```

mod band;
mod chan_vese;
mod differences;
mod edges;
mod settle;

pub use band::{Evolution, EvolutionOptions, Motion};
pub use chan_vese::{ChanVeseOptions, chan_vese};
pub use edges::{GeodesicOptions, edge_indicator, geodesic_contour, inset_box};
pub use settle::Evolved;
