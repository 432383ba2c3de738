//! Points with normals: what a coarse start sees of a shape, whatever the shape is.

use mesh_core::{NormalOptions, Orientation, PointCloud, TriangleMesh, estimate_normals};
use nalgebra::{Point3, Vector3};
use nurbs_core::{Aabb, ParametricSurface};

use crate::Error;

/// Points on a shape with the unit normals there.
///
/// The sign of the normals may be arbitrary, point by point.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct OrientedPoints {
    points: Vec<Vector3<f64>>,
    normals: Vec<Vector3<f64>>,
    dropped: usize,
}

/// Cells per direction of the parameter grid that measures the area of a surface.
const AREA_CELLS: usize = 48;

/// Steps of the additive recurrence in the plane with the lowest discrepancy known (powers of 1/1.3247…).
const RECURRENCE: [f64; 2] = [0.754_877_666_246_692_7, 0.569_840_290_998_053_2];

impl OrientedPoints {
    /// Points with their normals, which need not have the length 1.
    ///
    /// Points and normals that are not finite, and normals of length 0, are left out.
    ///
    /// # Errors
    /// [`Error::Length`] if there is not one normal per point.
    pub fn new(points: &[Vector3<f64>], normals: &[Vector3<f64>]) -> Result<Self, Error> {
        if points.len() != normals.len() {
            return Err(Error::Length { what: "normals", found: normals.len(), points: points.len() });
        }
        let mut out = Self::default();
        for (point, normal) in points.iter().zip(normals) {
            out.push(*point, normal);
        }
        Ok(out)
    }

    /// `count` points spread evenly over the area of surfaces.
    #[must_use]
    pub fn from_surfaces(surfaces: &[&dyn ParametricSurface], count: usize) -> Self {
        let mut cells = Vec::new();
        let mut areas = Vec::new();
        for (index, surface) in surfaces.iter().enumerate() {
            let [u, v] = surface.domain();
            let step = [u.length() / AREA_CELLS as f64, v.length() / AREA_CELLS as f64];
            for i in 0..AREA_CELLS {
                for j in 0..AREA_CELLS {
                    let corner = [u.start() + i as f64 * step[0], v.start() + j as f64 * step[1]];
                    let jet = surface.jet(corner[0] + 0.5 * step[0], corner[1] + 0.5 * step[1]);
                    areas.push(jet.du.cross(&jet.dv).norm() * step[0] * step[1]);
                    cells.push((index, corner, step));
                }
            }
        }
        let mut out = Self::default();
        spread(&areas, count, |cell, [s, t]| {
            let (index, corner, step) = cells[cell];
            let jet = surfaces[index].jet(corner[0] + s * step[0], corner[1] + t * step[1]);
            out.push(jet.point, &jet.du.cross(&jet.dv));
        });
        out
    }

    /// `count` points spread evenly over the area of a mesh, with the normals of its faces.
    #[must_use]
    pub fn from_mesh(mesh: &TriangleMesh, count: usize) -> Self {
        let corners: Vec<_> = (0..mesh.triangles().len()).filter_map(|index| mesh.corners(index)).collect();
        let area = |[a, b, c]: &[_; 3]| -> Vector3<f64> {
            let (a, b, c): (&Point3<f64>, &Point3<f64>, &Point3<f64>) = (a, b, c);
            (b - a).cross(&(c - a)) * 0.5
        };
        let areas: Vec<f64> = corners.iter().map(|triangle| area(triangle).norm()).collect();
        let mut out = Self::default();
        spread(&areas, count, |index, [s, t]| {
            let [a, b, c] = corners[index];
            let (s, t) = if s + t > 1.0 { (1.0 - s, 1.0 - t) } else { (s, t) };
            out.push(a.coords + (b - a) * s + (c - a) * t, &area(&corners[index]));
        });
        out
    }

    /// The points of a cloud; normals that it does not have are estimated.
    ///
    /// # Errors
    /// [`Error::Cloud`] if the cloud has too many points.
    pub fn from_cloud(cloud: &PointCloud) -> Result<Self, Error> {
        let mut out = Self::default();
        match cloud.attributes().normals() {
            Some(normals) => {
                for (point, normal) in cloud.positions().iter().zip(normals) {
                    out.push(point.coords, normal);
                }
            }
            None => out.estimate(cloud.positions())?,
        }
        Ok(out)
    }

    /// Points whose normals are estimated.
    ///
    /// # Errors
    /// [`Error::Cloud`] if there are too many points.
    pub fn without_normals(points: &[Vector3<f64>]) -> Result<Self, Error> {
        let mut out = Self::default();
        out.estimate(&points.iter().copied().map(Point3::from).collect::<Vec<_>>())?;
        Ok(out)
    }

    fn estimate(&mut self, points: &[Point3<f64>]) -> Result<(), Error> {
        let options = NormalOptions::default().with_orientation(Orientation::Any);
        for (point, normal) in points.iter().zip(estimate_normals(points, &options)?.normals) {
            self.push(point.coords, &normal);
        }
        Ok(())
    }

    fn push(&mut self, point: Vector3<f64>, normal: &Vector3<f64>) {
        if let Some(unit) = normal.try_normalize(0.0)
            && unit.iter().chain(point.iter()).all(|c| c.is_finite())
        {
            self.points.push(point);
            self.normals.push(unit);
        } else {
            self.dropped += 1;
        }
    }

    /// The points.
    #[must_use]
    pub fn points(&self) -> &[Vector3<f64>] {
        &self.points
    }

    /// The unit normals, one per point.
    #[must_use]
    pub fn normals(&self) -> &[Vector3<f64>] {
        &self.normals
    }

    /// Number of points that were left out.
    #[must_use]
    pub fn dropped(&self) -> usize {
        self.dropped
    }

    /// Number of points.
    #[must_use]
    pub fn len(&self) -> usize {
        self.points.len()
    }

    /// Whether there is no point.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.points.is_empty()
    }

    /// The box around the points; `None` if there are none.
    #[must_use]
    pub fn bounding_box(&self) -> Option<Aabb<3>> {
        Aabb::of_points(&self.points)
    }

    /// The points `(x − centre) / scale` of the given indices, with their normals.
    pub(crate) fn scaled(&self, indices: &[usize], centre: &Vector3<f64>, scale: f64) -> Self {
        Self {
            points: indices.iter().map(|&i| (self.points[i] - centre) / scale).collect(),
            normals: indices.iter().map(|&i| self.normals[i]).collect(),
            dropped: 0,
        }
    }
}

/// Calls `emit` for `count` places, each element getting its share by area, with parameters in the unit square.
fn spread(areas: &[f64], count: usize, mut emit: impl FnMut(usize, [f64; 2])) {
    let total: f64 = areas.iter().filter(|area| area.is_finite()).sum();
    if !total.is_finite() || total <= 0.0 || count == 0 {
        return;
    }
    let (mut element, mut before) = (0, 0.0);
    for k in 0..count {
        let target = (k as f64 + 0.5) / count as f64 * total;
        while element + 1 < areas.len() && (!areas[element].is_finite() || before + areas[element] < target) {
            before += if areas[element].is_finite() { areas[element] } else { 0.0 };
            element += 1;
        }
        if areas[element].is_finite() {
            emit(element, RECURRENCE.map(|step| ((k as f64 + 0.5) * step).fract()));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mesh_is_sampled_by_area() {
        // Two triangles with areas 3 : 1.
        let corners = [[0.0, 0.0, 0.0], [3.0, 0.0, 0.0], [0.0, 2.0, 0.0], [-1.0, 0.0, 0.0]];
        let mesh = TriangleMesh::new(corners.map(Point3::from).to_vec(), vec![[0, 1, 2], [0, 2, 3]]).unwrap();
        let samples = OrientedPoints::from_mesh(&mesh, 400);
        assert_eq!(samples.len(), 400);
        assert_eq!(samples.points().iter().filter(|p| p.x < 0.0).count(), 100);
        assert!(samples.normals().iter().all(|n| *n == Vector3::z()));
        let mean = samples.points().iter().filter(|p| p.x >= 0.0).sum::<Vector3<f64>>() / 300.0;
        assert!((mean - Vector3::new(1.0, 2.0 / 3.0, 0.0)).norm() < 0.03, "{mean}");
    }

    #[test]
    fn leaves_out_what_is_not_finite() {
        let points = [Vector3::x(), Vector3::repeat(f64::NAN), Vector3::y(), Vector3::z()];
        let normals = [Vector3::z() * 5.0, Vector3::z(), Vector3::zeros(), Vector3::repeat(f64::INFINITY)];
        let samples = OrientedPoints::new(&points, &normals).unwrap();
        assert_eq!(
            (samples.points(), samples.normals()),
            ([Vector3::x()].as_slice(), [Vector3::z()].as_slice())
        );
        assert!(OrientedPoints::new(&points, &normals[..2]).is_err());
        assert!(OrientedPoints::from_surfaces(&[], 10).is_empty());
    }
}
