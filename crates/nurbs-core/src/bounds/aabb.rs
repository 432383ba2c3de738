//! The axis-aligned bounding box.

use nalgebra::SVector;

/// An axis-aligned box `min ≤ x ≤ max` in `R^D`; it may be flat, even a point.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Aabb<const D: usize> {
    /// Corner with the smallest coordinates.
    pub min: SVector<f64, D>,
    /// Corner with the largest coordinates.
    pub max: SVector<f64, D>,
}

impl<const D: usize> Aabb<D> {
    /// The box of one point.
    #[must_use]
    pub fn of_point(point: SVector<f64, D>) -> Self {
        Self { min: point, max: point }
    }

    /// The smallest box of all points; `None` when there are none.
    ///
    /// NaN coordinates are passed over (a coordinate that is NaN in all points stays NaN).
    ///
    /// ```
    /// # use nurbs_core::Aabb;
    /// # use nalgebra::Vector2;
    /// let b = Aabb::of_points(&[Vector2::new(0.0, 2.0), Vector2::new(3.0, -2.0)]).unwrap();
    /// assert_eq!(b.diagonal(), 5.0);
    /// assert_eq!(b.distance(&Vector2::new(6.0, 6.0)), 5.0);
    /// ```
    pub fn of_points<'a>(points: impl IntoIterator<Item = &'a SVector<f64, D>>) -> Option<Self> {
        points.into_iter().fold(None, |found: Option<Self>, point| match found {
            None => Some(Self::of_point(*point)),
            Some(found) => Some(found.with_point(point)),
        })
    }

    /// The smallest box of this one and a point.
    #[must_use]
    pub fn with_point(&self, point: &SVector<f64, D>) -> Self {
        Self { min: self.min.zip_map(point, f64::min), max: self.max.zip_map(point, f64::max) }
    }

    /// The smallest box of both.
    #[must_use]
    pub fn merged(&self, other: &Self) -> Self {
        Self { min: self.min.zip_map(&other.min, f64::min), max: self.max.zip_map(&other.max, f64::max) }
    }

    /// The box grown by `margin` (a length) on every side.
    #[must_use]
    pub fn inflated(&self, margin: f64) -> Self {
        Self { min: self.min.add_scalar(-margin), max: self.max.add_scalar(margin) }
    }

    /// Whether the closed box holds the point.
    #[must_use]
    pub fn contains(&self, point: &SVector<f64, D>) -> bool {
        (0..D).all(|i| self.min[i] <= point[i] && point[i] <= self.max[i])
    }

    /// Whether the closed boxes have a point in common.
    #[must_use]
    pub fn intersects(&self, other: &Self) -> bool {
        (0..D).all(|i| self.min[i] <= other.max[i] && other.min[i] <= self.max[i])
    }

    /// The middle.
    #[must_use]
    pub fn centre(&self) -> SVector<f64, D> {
        (self.min + self.max) * 0.5
    }

    /// Lengths of the sides.
    #[must_use]
    pub fn sides(&self) -> SVector<f64, D> {
        self.max - self.min
    }

    /// Length of the diagonal.
    #[must_use]
    pub fn diagonal(&self) -> f64 {
        self.sides().norm()
    }

    /// The point of the box nearest to `point`.
    #[must_use]
    pub fn nearest_point(&self, point: &SVector<f64, D>) -> SVector<f64, D> {
        SVector::from_fn(|i, _| point[i].max(self.min[i]).min(self.max[i]))
    }

    /// Distance of a point from the box, 0 inside.
    #[must_use]
    pub fn distance(&self, point: &SVector<f64, D>) -> f64 {
        (point - self.nearest_point(point)).norm()
    }

    /// Largest distance of a point from any point of the box.
    #[must_use]
    pub fn farthest_distance(&self, point: &SVector<f64, D>) -> f64 {
        SVector::<f64, D>::from_fn(|i, _| (point[i] - self.min[i]).abs().max((self.max[i] - point[i]).abs()))
            .norm()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector2;

    #[test]
    fn operations() {
        let a = Aabb { min: Vector2::new(0.0, 0.0), max: Vector2::new(2.0, 1.0) };
        let b = Aabb::of_point(Vector2::new(5.0, -1.0));
        let both = a.merged(&b);
        assert_eq!((both.min, both.max), (Vector2::new(0.0, -1.0), Vector2::new(5.0, 1.0)));
        assert!(both.contains(&a.centre()) && !a.intersects(&b) && a.inflated(3.0).intersects(&b));
        assert_eq!(a.distance(&Vector2::new(1.0, 0.5)), 0.0);
        assert_eq!(a.farthest_distance(&Vector2::new(-1.0, -3.0)), 5.0);
        assert!(Aabb::<2>::of_points(&[]).is_none());
    }
}
