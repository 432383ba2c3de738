//! What fitting and registration ask of a shape.

use crate::{ErrorTerm, Hint, PrincipalFrame, QuadraticModel, Search};
use nalgebra::SVector;
use nurbs_core::Aabb;

/// The distance function of a shape: footpoints, and the local geometry that tells how the squared distance changes.
///
/// Implementations answer queries that are not finite with an unusable frame
/// ([`Status::InvalidPoint`](footpoint::Status::InvalidPoint)) and never panic. The same query gives the same bits on
/// any number of threads.
pub trait DistanceField<const D: usize>: Sync {
    /// The frame at the nearest point (or at the foot near `hint`, see [`Search`]).
    fn frame(&self, x: &SVector<f64, D>, search: Search, hint: &Hint) -> PrincipalFrame<D>;

    /// The frames of many points, in their order; `hints` has one entry per point, or none at all.
    ///
    /// Runs in parallel.
    fn frames(&self, points: &[SVector<f64, D>], search: Search, hints: &[Hint]) -> Vec<PrincipalFrame<D>> {
        crate::parallel::map(points.len(), |index| {
            self.frame(&points[index], search, hints.get(index).unwrap_or(&Hint::default()))
        })
    }

    /// The quadratic model of `d²` at the nearest point for an error term.
    fn quadratic(&self, x: &SVector<f64, D>, term: ErrorTerm) -> QuadraticModel<D> {
        term.model(&self.frame(x, Search::Global, &Hint::default()))
    }

    /// The distance of the nearest point, never negative; NaN for a query that is not finite.
    fn distance(&self, x: &SVector<f64, D>) -> f64 {
        self.frame(x, Search::Global, &Hint::default()).distance.abs()
    }

    /// A box around the shape, for scales and coarse starts.
    fn bounding_box(&self) -> Aabb<D>;

    /// Whether the normals are estimated from points, and as noisy as these let them be: then they seem to resist motions that slide the
    /// true shape along itself.
    fn has_estimated_normals(&self) -> bool {
        false
    }
}

macro_rules! forward {
    ($($pointer:ty),*) => {$(
        impl<const D: usize, F: DistanceField<D> + ?Sized> DistanceField<D> for $pointer {
            fn frame(&self, x: &SVector<f64, D>, search: Search, hint: &Hint) -> PrincipalFrame<D> {
                (**self).frame(x, search, hint)
            }
            fn frames(&self, points: &[SVector<f64, D>], search: Search, hints: &[Hint]) -> Vec<PrincipalFrame<D>> {
                (**self).frames(points, search, hints)
            }
            fn quadratic(&self, x: &SVector<f64, D>, term: ErrorTerm) -> QuadraticModel<D> {
                (**self).quadratic(x, term)
            }
            fn distance(&self, x: &SVector<f64, D>) -> f64 {
                (**self).distance(x)
            }
            fn bounding_box(&self) -> Aabb<D> {
                (**self).bounding_box()
            }
            fn has_estimated_normals(&self) -> bool {
                (**self).has_estimated_normals()
            }
        }
    )*};
}
forward!(&F, Box<F>);
