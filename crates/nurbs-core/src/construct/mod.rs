//! Surfaces made from curves.
//!
//! | from | surface | exact |
//! |---|---|---|
//! | four corners | [`bilinear`] | yes |
//! | four boundary curves | [`coons`] | yes |
//! | a surface and neighbours that it continues | [`joined`](joined()) | yes |
//! | two curves | [`ruled`] | yes |
//! | a curve and a vector | [`extrude`] | yes |
//! | a curve and an axis | [`revolve`] | yes |
//! | two curves, one moved along the other | [`translate_along`] | yes |
//! | a curve carried along a path by a moving frame | [`sweep`] | within a tolerance |
//! | any number of sections (lofting) | [`skin`] | interpolates the sections |
//!
//! Sweeping and skinning need the feature `fit`. Curves may be rational; those that have to fit together are given a common degree and common knots.

mod boundary;
mod compatible;
mod coons;
mod frames;
mod joined;
mod revolve;
mod simple;
#[cfg(feature = "fit")]
mod skin;
#[cfg(feature = "fit")]
mod sweep;

pub use boundary::BoundaryCurves;
pub use coons::coons;
pub use frames::{PathFrame, rotation_minimizing_frames};
pub use joined::{Continuity, Joined, Side, joined};
pub use revolve::revolve;
pub use simple::{bilinear, extrude, ruled, translate_along};
#[cfg(feature = "fit")]
pub use skin::{skin, skin_at};
#[cfg(feature = "fit")]
pub use sweep::{Sweep, SweepOptions, sweep};
