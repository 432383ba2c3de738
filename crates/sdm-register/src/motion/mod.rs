//! Rigid motions: where a moving system stands, how fast it moves, and the helical motion in between.

mod displacement;
mod pose;
pub mod rotation;
mod velocity;

pub use displacement::Displacement;
pub use pose::Pose;
pub use velocity::Velocity;

/// Number of unknowns of a step at most: translations and rotations in space, and the scale.
pub(crate) const MAX_UNKNOWNS: usize = 7;

/// Number of rotations in `R^D`.
pub(crate) const fn rotations(dimension: usize) -> usize {
    dimension * (dimension - 1) / 2
}

/// Number of unknowns of a rigid motion in `R^D`, 3 in the plane and 6 in space; also the index of the scale.
pub(crate) const fn rigid_unknowns(dimension: usize) -> usize {
    dimension + rotations(dimension)
}
