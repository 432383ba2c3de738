//! Cylinders and cones.

use super::elements::{Elements, upright};
use super::model::{Model, Pose, Row, Step, turning};
use super::random::Random;
use super::start;
use nalgebra::Vector3;
use std::f64::consts::FRAC_PI_2;

/// A cylinder (angle 0 that stays so) or a cone, open at both ends.
///
/// The curvature is that of the section through the pose's point, the angle positive if the cone widens along `z`. The
/// distance is the one from the generator in the same half plane; beyond the apex that generator goes on.
#[derive(Clone, Debug)]
pub(super) struct ConeModel<const CONE: bool> {
    pub(super) pose: Pose,
    pub(super) curvature: f64,
    pub(super) angle: f64,
}

impl<const CONE: bool> ConeModel<CONE> {
    /// The cone around an axis with a radius at `point` and the tangent of the half angle.
    pub(super) fn new(point: Vector3<f64>, direction: Vector3<f64>, radius: f64, slope: f64) -> Option<Self> {
        let z = direction.normalize();
        // The section nearest to the data; the radius there.
        let here = radius - slope * point.dot(&z);
        if !(here > 0.0 && here.is_finite()) {
            return None;
        }
        let pose = Pose::towards_origin(point, z, here);
        pose.is_finite().then_some(Self { pose, curvature: 1.0 / here, angle: slope.atan() })
    }
}

impl<const CONE: bool> Model<3> for ConeModel<CONE> {
    const UNKNOWNS: usize = if CONE { 6 } else { 5 };
    const ROWS: usize = 1;
    const SEVERAL: bool = true;

    fn starts(points: &[Vector3<f64>]) -> Vec<Self> {
        start::cones(points)
    }

    fn from_few(points: &[Vector3<f64>], random: &mut Random, count: usize) -> Vec<Self> {
        start::cone_from_few(points, random, count.min(3))
    }

    fn residuals(&self, x: &Vector3<f64>) -> [f64; 2] {
        let (_, distance, height) = self.pose.cylindrical(x);
        let (sin, cos) = self.angle.sin_cos();
        [(distance - 1.0 / self.curvature) * cos - height * sin, 0.0]
    }

    fn rows(&self, x: &Vector3<f64>) -> [Row; 2] {
        let (out, distance, height) = self.pose.cylindrical(x);
        let (sin, cos) = self.angle.sin_cos();
        let (e, z, t, radius) = (self.pose.e, self.pose.z, self.pose.t(), 1.0 / self.curvature);
        let pivot = self.pose.point + e * radius;
        let n = out * cos - z * sin;
        let mut row = Row { residual: (distance - radius) * cos - height * sin, ..Row::default() };
        row.slopes[0] = -n.dot(&e);
        for (k, axis) in [z, e, t].iter().enumerate() {
            row.slopes[1 + k] = turning(&n, x, &pivot, axis);
        }
        row.slopes[4] = cos * (out - e).norm_squared() / 2.0 * radius * radius;
        if CONE {
            row.slopes[5] = -(distance - radius) * sin - height * cos;
        }
        [row, Row::default()]
    }

    fn moved(&self, step: &Step) -> Option<Self> {
        let (e, z, t, radius) = (self.pose.e, self.pose.z, self.pose.t(), 1.0 / self.curvature);
        let pivot = self.pose.point + e * radius;
        let mut pose = self.pose.moved(z * step[1] + e * step[2] + t * step[3], &pivot, e * step[0]);
        let curvature = self.curvature + step[4];
        pose.point += pose.e * (radius - 1.0 / curvature);
        let angle = if CONE { self.angle + step[5] } else { 0.0 };
        let valid = curvature > 0.0 && curvature.is_finite() && angle.abs() < FRAC_PI_2 && pose.is_finite();
        valid.then_some(Self { pose, curvature, angle })
    }

    fn elements(&self, centre: &Vector3<f64>) -> Elements<3> {
        let location = self.pose.nearest(centre);
        let height = (location - self.pose.point).dot(&self.pose.z);
        let widening = if self.angle < 0.0 { -self.pose.z } else { self.pose.z };
        Elements {
            location,
            direction: Some(if CONE { widening } else { upright(self.pose.z) }),
            radius: Some(1.0 / self.curvature + height * self.angle.tan()),
            minor_radius: None,
            half_angle: CONE.then_some(self.angle.abs()),
        }
    }
}
