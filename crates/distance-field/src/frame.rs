//! The local geometry of a shape as seen from a query: all that a quadratic model of `d²` needs.

use crate::Hint;
use footpoint::Status;
use nalgebra::{SMatrix, SVector};

/// The footpoint of a query with the directions in which it may move and how the shape bends along them.
///
/// The last axis points along the normal on which the query lies, `x = foot + distance · axes[D − 1]`. The first
/// `tangent_dimension` axes are orthonormal tangent directions, the principal directions of a surface; in the remaining
/// ones the foot cannot move. A smooth surface in space has two tangent directions, a curve or the edge of a surface
/// one, a corner none.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PrincipalFrame<const D: usize> {
    /// The footpoint.
    pub foot: SVector<f64, D>,
    /// Orthonormal axes, one per column.
    pub axes: SMatrix<f64, D, D>,
    /// Normal curvatures `κᵢ` along the tangent axes with respect to the last axis (positive where the shape bends
    /// towards it); 0 for the other axes. One over a length.
    pub curvatures: SVector<f64, D>,
    /// Number of tangent directions.
    pub tangent_dimension: usize,
    /// Signed distance `d` along the last axis: negative only where the shape has a side (curves in the plane, surfaces,
    /// closed meshes) and the query lies on the other one.
    pub distance: f64,
    /// Whether the foot lies where an open shape ends (an edge or corner of the domain, the boundary of a mesh, an end
    /// of a curve).
    pub on_boundary: bool,
    /// Where the next query nearby may start.
    pub hint: Hint,
    /// How the footpoint was found; only with [`Status::is_converged`] is `foot` a footpoint, on whose normal the query
    /// lies. After one step ([`Search::OneStep`](crate::Search::OneStep)) it may be only near one: the frame is then that
    /// of the point reached, and usable as long as it [is finite](Self::is_finite).
    pub status: Status,
}

impl<const D: usize> PrincipalFrame<D> {
    /// What is said about a query for which nothing can be computed.
    #[must_use]
    pub fn invalid(status: Status) -> Self {
        Self {
            foot: SVector::repeat(f64::NAN),
            axes: SMatrix::identity(),
            curvatures: SVector::zeros(),
            tangent_dimension: 0,
            distance: f64::NAN,
            on_boundary: false,
            hint: Hint::default(),
            status,
        }
    }

    /// The unit normal at the foot towards the side where distances are positive.
    #[must_use]
    pub fn normal(&self) -> SVector<f64, D> {
        self.axes.column(D - 1).into_owned()
    }

    /// Whether the fields can be used: the foot and the distance are finite numbers.
    #[must_use]
    pub fn is_finite(&self) -> bool {
        self.distance.is_finite() && self.foot.iter().all(|c| c.is_finite())
    }
}
