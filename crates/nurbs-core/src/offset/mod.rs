//! Offset curves and surfaces, evaluated exactly.
//!
//! The offset of a shape at the signed distance `d` is `c + d n` with its unit normal `n`. Its second
//! derivatives need the third ones of the base, which [`ThirdOrderCurve`] and [`ThirdOrderSurface`] give.
//!
//! Where the base is not regular it has no normal, and so the offset no point: all numbers of the jet are
//! NaN there (`try_jet` gives `None`). Where `d` equals a radius of curvature the offset itself is singular,
//! beyond it its direction is reversed; self-intersections stay in.

mod curve;
mod surface;

pub use curve::{OffsetCurve, ThirdOrderCurve};
pub use surface::{OffsetSurface, SurfaceThird, ThirdOrderSurface};
