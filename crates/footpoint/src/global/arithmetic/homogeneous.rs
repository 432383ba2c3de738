//! Control points in homogeneous coordinates.

/// A point of the homogeneous control net: `w (p − centre)` and `w`.
pub(crate) type Homogeneous = [f64; 4];
