//! Point clouds.

use nalgebra::{Point2, Point3, Vector3};

use crate::attributes::{retain, select};
use crate::bounds::is_finite;
use crate::{Attributes, BoundingBox, Colours, Error};

/// Points in space, or in the plane, with their attributes.
///
/// Every attribute has one value per point; the constructors and setters see to it. A cloud in the plane keeps
/// its points with z = 0 and says so by [`PointCloud::dimension`]. Coordinates may be NaN or infinite, as they are
/// in many scans: see [`PointCloud::count_non_finite`] and [`PointCloud::retain_finite`].
#[derive(Debug, Clone, PartialEq)]
pub struct PointCloud {
    positions: Vec<Point3<f64>>,
    planar: bool,
    attributes: Attributes,
}

impl PointCloud {
    /// A cloud in space.
    #[must_use]
    pub fn new(positions: Vec<Point3<f64>>) -> Self {
        Self { positions, planar: false, attributes: Attributes::default() }
    }

    /// A cloud in the plane.
    #[must_use]
    pub fn planar(positions: &[Point2<f64>]) -> Self {
        let positions = positions.iter().map(|point| Point3::new(point.x, point.y, 0.0)).collect();
        Self { positions, planar: true, attributes: Attributes::default() }
    }

    /// Marks the cloud as one in the plane z = 0.
    ///
    /// # Errors
    /// [`Error::NotPlanar`] with the first point whose z is not 0.
    pub fn into_planar(mut self) -> Result<Self, Error> {
        match self.positions.iter().position(|point| point.z != 0.0) {
            Some(index) => Err(Error::NotPlanar { index, z: self.positions[index].z }),
            None => {
                self.planar = true;
                Ok(self)
            }
        }
    }

    /// Replaces all attributes.
    ///
    /// # Errors
    /// [`Error::AttributeLength`] if an attribute has not one value per point.
    pub fn with_attributes(mut self, attributes: Attributes) -> Result<Self, Error> {
        attributes.check(self.positions.len())?;
        self.attributes = attributes;
        Ok(self)
    }

    /// Sets the normals.
    ///
    /// # Errors
    /// [`Error::AttributeLength`] if there is not one normal per point.
    pub fn with_normals(self, normals: Vec<Vector3<f64>>) -> Result<Self, Error> {
        self.edit(|attributes| {
            attributes.set_normals(Some(normals));
            Ok(())
        })
    }

    /// Sets the colours.
    ///
    /// # Errors
    /// [`Error::AttributeLength`] if there is not one colour per point.
    pub fn with_colours(self, colours: Colours) -> Result<Self, Error> {
        self.edit(|attributes| {
            attributes.set_colours(Some(colours));
            Ok(())
        })
    }

    /// Adds a scalar.
    ///
    /// # Errors
    /// [`Error::AttributeLength`] if there is not one value per point, [`Error::DuplicateScalar`] if the name is taken.
    pub fn with_scalar(self, name: impl Into<String>, values: Vec<f64>) -> Result<Self, Error> {
        self.edit(|attributes| attributes.push_scalar(name, values))
    }

    fn edit(mut self, change: impl FnOnce(&mut Attributes) -> Result<(), Error>) -> Result<Self, Error> {
        change(&mut self.attributes)?;
        self.attributes.check(self.positions.len())?;
        Ok(self)
    }

    /// The positions; z = 0 in a cloud in the plane.
    #[must_use]
    pub fn positions(&self) -> &[Point3<f64>] {
        &self.positions
    }

    /// The attributes.
    #[must_use]
    pub const fn attributes(&self) -> &Attributes {
        &self.attributes
    }

    /// Positions and attributes, taken apart.
    #[must_use]
    pub fn into_parts(self) -> (Vec<Point3<f64>>, Attributes) {
        (self.positions, self.attributes)
    }

    /// Number of points.
    #[must_use]
    pub fn len(&self) -> usize {
        self.positions.len()
    }

    /// Whether there is no point.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.positions.is_empty()
    }

    /// 2 for a cloud in the plane, 3 for a cloud in space.
    #[must_use]
    pub const fn dimension(&self) -> usize {
        if self.planar { 2 } else { 3 }
    }

    /// The smallest box around the points with finite coordinates; `None` if there is none.
    #[must_use]
    pub fn bounding_box(&self) -> Option<BoundingBox> {
        BoundingBox::of(&self.positions)
    }

    /// Number of points with a coordinate that is NaN or infinite.
    #[must_use]
    pub fn count_non_finite(&self) -> usize {
        self.positions.iter().filter(|point| !is_finite(point)).count()
    }

    /// The points at the given indices, in that order, with their attributes. Indices may repeat.
    ///
    /// # Errors
    /// [`Error::PointIndex`] if a point does not exist.
    pub fn select(&self, indices: &[u32]) -> Result<Self, Error> {
        if let Some(&index) = indices.iter().find(|&&index| index as usize >= self.len()) {
            return Err(Error::PointIndex { index, points: self.len() });
        }
        Ok(Self {
            positions: select(&self.positions, indices),
            planar: self.planar,
            attributes: self.attributes.select(indices),
        })
    }

    /// Other positions with the attributes at the given indices, which must exist and be as many.
    pub(crate) fn selected_at(&self, indices: &[u32], positions: Vec<Point3<f64>>) -> Self {
        Self { positions, planar: self.planar, attributes: self.attributes.select(indices) }
    }

    /// Drops the points whose flag is false, with their attributes; returns how many.
    ///
    /// # Errors
    /// [`Error::AttributeLength`] if there is not one flag per point.
    pub fn retain(&mut self, keep: &[bool]) -> Result<usize, Error> {
        if keep.len() != self.len() {
            let name = "flags".to_owned();
            return Err(Error::AttributeLength { name, found: keep.len(), expected: self.len() });
        }
        retain(&mut self.positions, keep);
        self.attributes.retain(keep);
        Ok(keep.len() - self.len())
    }

    /// Drops the points with a coordinate that is NaN or infinite, with their attributes; returns how many.
    pub fn retain_finite(&mut self) -> usize {
        let keep: Vec<bool> = self.positions.iter().map(is_finite).collect();
        let dropped = keep.iter().filter(|&&keep| !keep).count();
        if dropped > 0 {
            retain(&mut self.positions, &keep);
            self.attributes.retain(&keep);
        }
        dropped
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn three() -> PointCloud {
        PointCloud::new(vec![
            Point3::new(1.0, 0.0, 0.0),
            Point3::new(f64::NAN, 0.0, 0.0),
            Point3::new(0.0, 0.0, f64::NEG_INFINITY),
        ])
    }

    #[test]
    fn drops_points_together_with_their_attributes() {
        let mut cloud = three()
            .with_normals(vec![Vector3::x(), Vector3::y(), Vector3::z()])
            .and_then(|cloud| cloud.with_colours(Colours::Rgb(vec![[1; 3], [2; 3], [3; 3]])))
            .and_then(|cloud| cloud.with_scalar("intensity", vec![7.0, 8.0, 9.0]))
            .unwrap();
        assert_eq!(cloud.count_non_finite(), 2);
        assert_eq!(cloud.retain_finite(), 2);
        assert_eq!(cloud.len(), 1);
        assert_eq!(cloud.attributes().normals(), Some([Vector3::x()].as_slice()));
        assert_eq!(cloud.attributes().colours(), Some(&Colours::Rgb(vec![[1; 3]])));
        assert_eq!(cloud.attributes().scalar("intensity"), Some([7.0].as_slice()));
        assert_eq!(cloud.retain_finite(), 0);
    }

    #[test]
    fn refuses_attributes_of_another_length() {
        let error = three().with_scalar("t", vec![0.0]).unwrap_err();
        assert_eq!(error, Error::AttributeLength { name: "t".into(), found: 1, expected: 3 });
        let cloud = three().with_scalar("t", vec![0.0; 3]).unwrap();
        assert_eq!(cloud.with_scalar("t", vec![0.0; 3]), Err(Error::DuplicateScalar { name: "t".into() }));
    }

    #[test]
    fn knows_its_dimension() {
        assert_eq!(PointCloud::planar(&[Point2::new(1.0, 2.0)]).dimension(), 2);
        let cloud = PointCloud::new(vec![Point3::origin(), Point3::new(0.0, 0.0, 3.0)]);
        assert_eq!(cloud.dimension(), 3);
        assert_eq!(cloud.into_planar(), Err(Error::NotPlanar { index: 1, z: 3.0 }));
    }
}
