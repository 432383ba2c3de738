//! Axis-aligned bounding boxes.

use nalgebra::{Point3, Vector3};

/// An axis-aligned box that is never empty.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BoundingBox {
    /// Corner with the smallest coordinates.
    pub min: Point3<f64>,
    /// Corner with the largest coordinates.
    pub max: Point3<f64>,
}

impl BoundingBox {
    /// The smallest box around the points with finite coordinates; `None` if there is none.
    #[must_use]
    pub fn of(points: &[Point3<f64>]) -> Option<Self> {
        let mut finite = points.iter().filter(|point| is_finite(point));
        let first = *finite.next()?;
        Some(finite.fold(Self { min: first, max: first }, |bounds, point| Self {
            min: bounds.min.inf(point),
            max: bounds.max.sup(point),
        }))
    }

    /// The midpoint of the box, free of overflow.
    #[must_use]
    pub fn centre(&self) -> Point3<f64> {
        Point3::from(self.min.coords * 0.5 + self.max.coords * 0.5)
    }

    /// Edge lengths of the box.
    #[must_use]
    pub fn extent(&self) -> Vector3<f64> {
        self.max - self.min
    }

    /// Length of the diagonal.
    #[must_use]
    pub fn diagonal(&self) -> f64 {
        self.extent().norm()
    }
}

/// Whether no coordinate is NaN or infinite.
pub(crate) fn is_finite(point: &Point3<f64>) -> bool {
    point.iter().all(|value| value.is_finite())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ignores_points_that_are_not_finite() {
        let points = [
            Point3::new(f64::NAN, 0.0, 0.0),
            Point3::new(1.0, 2.0, 3.0),
            Point3::new(-1.0, 5.0, f64::INFINITY),
        ];
        let bounds = BoundingBox::of(&points).unwrap();
        assert_eq!((bounds.min, bounds.max), (points[1], points[1]));
        assert_eq!(BoundingBox::of(&points[..1]), None);
    }

    #[test]
    fn measures() {
        let bounds = BoundingBox::of(&[Point3::new(1.0, 2.0, 3.0), Point3::new(4.0, 6.0, 3.0)]).unwrap();
        assert_eq!(bounds.centre(), Point3::new(2.5, 4.0, 3.0));
        assert_eq!(bounds.diagonal(), 5.0);
    }
}
