//! Lines and planes.

use super::elements::{Elements, upright};
use super::model::{Model, Row, Step, normal_to, orthonormal};
use super::random::Random;
use super::start;
use nalgebra::{SVector, Vector3};

/// A line in the plane or in space.
#[derive(Clone, Debug)]
pub(super) struct LineModel<const D: usize> {
    pub(super) point: SVector<f64, D>,
    pub(super) direction: SVector<f64, D>,
    /// Orthonormal vectors normal to the line; the second one is 0 in the plane.
    normals: [SVector<f64, D>; 2],
}

impl<const D: usize> LineModel<D> {
    /// The line through a point; the direction need not be a unit vector.
    pub(super) fn new(point: SVector<f64, D>, direction: SVector<f64, D>) -> Self {
        let direction = direction.normalize();
        let mut normals = [SVector::zeros(); 2];
        let mut order: Vec<usize> = (0..D).collect();
        order.sort_by(|&a, &b| direction[a].abs().total_cmp(&direction[b].abs()));
        for k in 0..D - 1 {
            let mut v = SVector::zeros();
            v[order[k]] = 1.0;
            if k == 1 {
                v = orthonormal(&normals[0], &v);
            }
            normals[k] = orthonormal(&direction, &v);
            if k == 1 {
                normals[1] = orthonormal(&normals[0], &normals[1]);
            }
        }
        Self { point, direction, normals }
    }
}

impl<const D: usize> Model<D> for LineModel<D> {
    const UNKNOWNS: usize = 2 * (D - 1);
    const ROWS: usize = D - 1;
    const SEVERAL: bool = false;

    fn starts(points: &[SVector<f64, D>]) -> Vec<Self> {
        start::line(points)
    }

    fn from_few(points: &[SVector<f64, D>], _: &mut Random, _: usize) -> Vec<Self> {
        start::line(points)
    }

    fn residuals(&self, x: &SVector<f64, D>) -> [f64; 2] {
        let d = x - self.point;
        [d.dot(&self.normals[0]), d.dot(&self.normals[1])]
    }

    fn rows(&self, x: &SVector<f64, D>) -> [Row; 2] {
        let along = (x - self.point).dot(&self.direction);
        let residuals = self.residuals(x);
        let mut rows = [Row::default(); 2];
        for k in 0..Self::ROWS {
            rows[k].residual = residuals[k];
            rows[k].slopes[k] = -1.0;
            rows[k].slopes[Self::ROWS + k] = -along;
        }
        rows
    }

    fn moved(&self, step: &Step) -> Option<Self> {
        let (mut point, mut direction) = (self.point, self.direction);
        for k in 0..Self::ROWS {
            point += self.normals[k] * step[k];
            direction += self.normals[k] * step[Self::ROWS + k];
        }
        let moved = Self::new(point, direction);
        // Normals stay near their old ones, so that steps at neighbouring lines can be compared.
        let mut normals = self.normals;
        for k in 0..Self::ROWS {
            normals[k] = orthonormal(&moved.direction, &normals[k]);
        }
        if Self::ROWS == 2 {
            normals[1] = orthonormal(&normals[0], &normals[1]);
        }
        let finite = point.iter().chain(direction.iter()).all(|c| c.is_finite());
        finite.then_some(Self { normals, ..moved })
    }

    fn elements(&self, centre: &SVector<f64, D>) -> Elements<D> {
        Elements {
            location: self.point + self.direction * (centre - self.point).dot(&self.direction),
            direction: Some(upright(self.direction)),
            radius: None,
            minor_radius: None,
            half_angle: None,
        }
    }

    fn outside(&self) -> f64 {
        // On the left of the direction that is reported.
        let direction = upright(self.direction);
        let left =
            if D == 2 { direction[0] * self.normals[0][1] - direction[1] * self.normals[0][0] } else { 1.0 };
        left.signum()
    }
}

/// A plane in space.
#[derive(Clone, Debug)]
pub(super) struct PlaneModel {
    pub(super) point: Vector3<f64>,
    pub(super) normal: Vector3<f64>,
    pub(super) e: Vector3<f64>,
}

impl PlaneModel {
    pub(super) fn new(point: Vector3<f64>, normal: Vector3<f64>) -> Self {
        let normal = normal.normalize();
        Self { point, normal, e: normal_to(&normal) }
    }
}

impl Model<3> for PlaneModel {
    const UNKNOWNS: usize = 3;
    const ROWS: usize = 1;
    const SEVERAL: bool = false;

    fn starts(points: &[Vector3<f64>]) -> Vec<Self> {
        start::plane(points)
    }

    fn from_few(points: &[Vector3<f64>], _: &mut Random, _: usize) -> Vec<Self> {
        start::plane(points)
    }

    fn residuals(&self, x: &Vector3<f64>) -> [f64; 2] {
        [(x - self.point).dot(&self.normal), 0.0]
    }

    fn rows(&self, x: &Vector3<f64>) -> [Row; 2] {
        let d = x - self.point;
        let t = self.normal.cross(&self.e);
        let mut row = Row { residual: d.dot(&self.normal), ..Row::default() };
        row.slopes[..3].copy_from_slice(&[-1.0, d.dot(&self.e), d.dot(&t)]);
        [row, Row::default()]
    }

    fn moved(&self, step: &Step) -> Option<Self> {
        let t = self.normal.cross(&self.e);
        let normal = (self.normal + self.e * step[1] + t * step[2]).normalize();
        let point = self.point + self.normal * step[0];
        let e = orthonormal(&normal, &self.e);
        point.iter().chain(normal.iter()).all(|c| c.is_finite()).then_some(Self { point, normal, e })
    }

    fn elements(&self, centre: &Vector3<f64>) -> Elements<3> {
        Elements {
            location: centre - self.normal * (centre - self.point).dot(&self.normal),
            direction: Some(upright(self.normal)),
            radius: None,
            minor_radius: None,
            half_angle: None,
        }
    }

    fn outside(&self) -> f64 {
        self.normal.dot(&upright(self.normal)).signum()
    }
}
