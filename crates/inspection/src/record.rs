//! Deviations in little memory.

use crate::{Class, Deviation, Outcome, Place, Tolerance};
use nalgebra::Point3;

/// A [`Deviation`] without what can be computed again: 56 bytes, for clouds of many millions of points.
///
/// The normal comes back by [`Nominal::normal`](crate::Nominal::normal); what is proven about the distance has gone into the
/// outcome.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DeviationRecord {
    /// The footpoint; NaN if there is none.
    pub foot: Point3<f64>,
    /// The deviation; NaN if there is none.
    pub distance: f64,
    /// Parameters `(u, v)`, or `t` and NaN on a curve; NaN on a mesh.
    pub parameter: [f64; 2],
    /// The triangle of a mesh, the surface or curve of another model; `u32::MAX` where there is none.
    element: u32,
    /// Whether the deviation counts.
    pub outcome: Outcome,
    /// Where the footpoint lies.
    pub place: Place,
    pub(crate) corner: u8,
    flags: u8,
}

const ON_BOUNDARY: u8 = 1;
const IS_RESTRICTED: u8 = 2;

impl DeviationRecord {
    /// A point that was not measured.
    #[must_use]
    pub fn none(outcome: Outcome) -> Self {
        Self::from(&Deviation::none(outcome))
    }

    /// Index of the surface or curve in the model, 0 on a mesh; `u32::MAX` where there is none.
    #[must_use]
    pub fn shape(&self) -> u32 {
        if self.place.is_on_mesh() { 0 } else { self.element }
    }

    /// Index of the triangle of a mesh; `u32::MAX` elsewhere.
    #[must_use]
    pub fn triangle(&self) -> u32 {
        if self.place.is_on_mesh() { self.element } else { u32::MAX }
    }

    /// Whether the footpoint lies on the boundary of an open shape.
    #[must_use]
    pub fn on_boundary(&self) -> bool {
        self.flags & ON_BOUNDARY != 0
    }

    /// Whether a point of the shape that is nearer does not count, because its normal does not agree.
    #[must_use]
    pub fn is_restricted(&self) -> bool {
        self.flags & IS_RESTRICTED != 0
    }

    /// Where a deviation that counts lies with respect to a tolerance; `None` where none counts.
    #[must_use]
    pub fn class(&self, tolerance: &Tolerance) -> Option<Class> {
        (self.outcome == Outcome::Measured).then(|| tolerance.class(self.distance))
    }
}

impl From<&Deviation> for DeviationRecord {
    fn from(deviation: &Deviation) -> Self {
        let flag = |set: bool, flag: u8| if set { flag } else { 0 };
        Self {
            foot: deviation.foot,
            distance: deviation.distance,
            parameter: deviation.parameter,
            element: if deviation.place.is_on_mesh() { deviation.triangle } else { deviation.shape },
            outcome: deviation.outcome,
            place: deviation.place,
            corner: deviation.corner,
            flags: flag(deviation.on_boundary, ON_BOUNDARY) | flag(deviation.is_restricted, IS_RESTRICTED),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn records_are_small_and_keep_what_they_are_told() {
        assert_eq!(size_of::<DeviationRecord>(), 56);
        let mut deviation = Deviation { triangle: 7, shape: 0, ..Deviation::none(Outcome::Measured) };
        (deviation.place, deviation.on_boundary, deviation.is_restricted) = (Place::TriangleEdge, true, true);
        let record = DeviationRecord::from(&deviation);
        assert_eq!((record.shape(), record.triangle()), (0, 7));
        assert!(record.on_boundary() && record.is_restricted());
        (deviation.place, deviation.shape, deviation.triangle) = (Place::Seam, 3, u32::MAX);
        let record = DeviationRecord::from(&Deviation { on_boundary: false, ..deviation });
        assert_eq!((record.shape(), record.triangle()), (3, u32::MAX));
        assert!(!record.on_boundary() && record.is_restricted());
        let none = DeviationRecord::none(Outcome::NoHit);
        assert_eq!((none.shape(), none.triangle(), none.place), (u32::MAX, u32::MAX, Place::None));
    }
}
