//! An edge of a patch that is collapsed into a point.

/// An edge of a patch whose control points are all the same.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pole {
    /// Whether the second direction leads away from it, not the first one.
    pub(crate) along_v: bool,
    /// Whether it is at the upper end of that direction.
    pub(crate) at_end: bool,
    /// Largest speed at which parameter lines leave it.
    pub(crate) speed: f64,
}
