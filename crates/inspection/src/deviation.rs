//! The deviation of one point.

use crate::{Class, Tolerance};
use nalgebra::{Point3, Vector3};

/// Why a point has a deviation that counts, or none.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "snake_case"))]
#[non_exhaustive]
pub enum Outcome {
    /// The deviation was measured and counts.
    Measured,
    /// It is larger than the largest distance asked for.
    BeyondMaxDistance,
    /// The footpoint lies on the boundary of the shape, and such points were not asked for.
    BeyondBoundary,
    /// The line through the point does not meet the shape (within the largest distance).
    NoHit,
    /// The normal of the point is asked for, but it has none: it is zero or not finite.
    NoNormal,
    /// The search ended without a footpoint. Such a point counts as out of tolerance.
    NotConverged,
    /// A coordinate is NaN or infinite.
    InvalidPoint,
    /// The run was cancelled before this point was treated.
    Cancelled,
    /// No foot or crossing has a normal within the largest angle of the point's normal. Such a point counts as out of
    /// tolerance.
    NoMatchingFoot,
    /// The deviation lies somewhere in an interval that crosses a limit of the tolerance, and no more is proven. Such a point
    /// does not count as within the tolerance.
    Undecided,
}

impl Outcome {
    /// All outcomes, in the order of their numbers in files.
    pub const ALL: [Self; 10] = [
        Self::Measured,
        Self::BeyondMaxDistance,
        Self::BeyondBoundary,
        Self::NoHit,
        Self::NoNormal,
        Self::NotConverged,
        Self::InvalidPoint,
        Self::Cancelled,
        Self::NoMatchingFoot,
        Self::Undecided,
    ];

    /// Whether such a point is judged: measured, or counted as not within the tolerance.
    #[must_use]
    pub fn is_judged(self) -> bool {
        matches!(self, Self::Measured | Self::NotConverged | Self::NoMatchingFoot | Self::Undecided)
    }

    /// The name used in files: `measured`, `beyond_max_distance`, …
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Measured => "measured",
            Self::BeyondMaxDistance => "beyond_max_distance",
            Self::BeyondBoundary => "beyond_boundary",
            Self::NoHit => "no_hit",
            Self::NoNormal => "no_normal",
            Self::NotConverged => "not_converged",
            Self::InvalidPoint => "invalid_point",
            Self::Cancelled => "cancelled",
            Self::NoMatchingFoot => "no_matching_foot",
            Self::Undecided => "undecided",
        }
    }
}

/// Where on the nominal shape a footpoint lies.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(rename_all = "snake_case"))]
pub enum Place {
    /// Nowhere: there is no footpoint.
    None,
    /// Inside the domain of a surface.
    Interior,
    /// On a boundary curve of a surface.
    Edge,
    /// At a corner of a surface.
    Corner,
    /// Where a closed surface meets itself.
    Seam,
    /// At a point into which an edge of the domain is collapsed.
    Pole,
    /// Inside a triangle.
    Face,
    /// On an edge of the mesh.
    TriangleEdge,
    /// At a vertex of the mesh.
    Vertex,
}

impl Place {
    /// Whether it is one of a mesh.
    #[must_use]
    pub fn is_on_mesh(self) -> bool {
        matches!(self, Self::Face | Self::TriangleEdge | Self::Vertex)
    }

    /// The name used in files: `interior`, `edge`, …
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::Interior => "interior",
            Self::Edge => "edge",
            Self::Corner => "corner",
            Self::Seam => "seam",
            Self::Pole => "pole",
            Self::Face => "face",
            Self::TriangleEdge => "triangle_edge",
            Self::Vertex => "vertex",
        }
    }
}

/// How far a point is from the nominal shape, and where. Numbers are NaN where there is nothing to say.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Deviation {
    /// Whether the deviation counts.
    pub outcome: Outcome,
    /// The footpoint: the closest point of the shape that counts, or the one in which the line of projection meets it.
    pub foot: Point3<f64>,
    /// Unit normal of the shape at the footpoint; zero where it has none.
    pub normal: Vector3<f64>,
    /// Length of the line of projection, positive on the side to which the normal points. Never negative where the
    /// shape has no sides (a mesh whose triangles disagree).
    pub distance: f64,
    /// How much nearer another point of the shape that counts could be at most.
    pub gap: f64,
    /// Parameters `(u, v)`; NaN on a mesh.
    pub parameter: [f64; 2],
    /// Index of the surface in the model, 0 on a mesh; `u32::MAX` where there is none.
    pub shape: u32,
    /// Index of the triangle of a mesh; `u32::MAX` on surfaces.
    pub triangle: u32,
    /// Where the footpoint lies.
    pub place: Place,
    /// Number of the edge or corner of the triangle on which it lies; 0 elsewhere.
    pub corner: u8,
    /// Whether that is the boundary of an open shape.
    pub on_boundary: bool,
    /// Whether a point of the shape that is nearer does not count, because its normal does not agree.
    pub is_restricted: bool,
}

impl Deviation {
    /// A point without a footpoint.
    #[must_use]
    pub fn none(outcome: Outcome) -> Self {
        Self {
            outcome,
            foot: Point3::new(f64::NAN, f64::NAN, f64::NAN),
            normal: Vector3::repeat(f64::NAN),
            distance: f64::NAN,
            gap: f64::NAN,
            parameter: [f64::NAN; 2],
            shape: u32::MAX,
            triangle: u32::MAX,
            place: Place::None,
            corner: 0,
            on_boundary: false,
            is_restricted: false,
        }
    }

    /// Where a deviation that counts lies with respect to a tolerance; `None` where none counts.
    #[must_use]
    pub fn class(&self, tolerance: &Tolerance) -> Option<Class> {
        (self.outcome == Outcome::Measured).then(|| tolerance.class(self.distance))
    }
}
