//! Which side of the shape a point was seen from.

use footpoint::Facing;
use nalgebra::Vector3;

/// The feet that count for a point.
#[derive(Clone, Copy, Debug)]
pub(super) enum Side {
    /// All of them.
    Any,
    /// Those where the normal agrees.
    Facing(Facing),
    /// The point has no normal that could say so.
    Unknown,
}

/// The sides of all points.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sides<'a> {
    /// The normals of the points with the largest angle, where there is one.
    limit: Option<(&'a [Vector3<f64>], f64)>,
}

impl<'a> Sides<'a> {
    pub(super) fn new(limit: Option<(&'a [Vector3<f64>], f64)>) -> Self {
        Self { limit }
    }

    pub(super) fn of(&self, index: usize) -> Side {
        match self.limit {
            None => Side::Any,
            Some((normals, angle)) => Self::facing(&normals[index], angle),
        }
    }

    fn facing(normal: &Vector3<f64>, angle: f64) -> Side {
        Facing::new(normal, angle).map_or(Side::Unknown, Side::Facing)
    }
}

impl Side {
    /// The direction that normals have to face, if there is one.
    pub(super) fn facing(&self) -> Option<&Facing> {
        match self {
            Self::Facing(facing) => Some(facing),
            Self::Any | Self::Unknown => None,
        }
    }
}
