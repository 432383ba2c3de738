//! Errors of this crate.

/// What can be wrong with the input of a distance field.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The shape cannot be projected onto.
    #[error(transparent)]
    Footpoint(#[from] footpoint::Error),
    /// The curve or surface cannot be used.
    #[error(transparent)]
    Shape(#[from] nurbs_core::Error),
    /// The mesh or cloud cannot be used.
    #[error(transparent)]
    Mesh(#[from] mesh_core::Error),
}
