//! Cylinders, cones and tori: surfaces of revolution.

use super::elements::{Elements, upright};
use super::model::{Model, Pose, Row, Step, turning};
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

/// A cylinder.
pub(super) type CylinderModel = ConeModel<false>;

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

/// A torus whose tube does not meet the axis.
#[derive(Clone, Debug)]
pub(super) struct TorusModel {
    pub(super) pose: Pose,
    pub(super) major: f64,
    pub(super) minor: f64,
}

impl TorusModel {
    pub(super) fn new(centre: Vector3<f64>, direction: Vector3<f64>, major: f64, minor: f64) -> Option<Self> {
        let z = direction.normalize();
        let pose = Pose { point: centre, z, e: super::model::normal_to(&z) };
        (major > minor && minor > 0.0 && major.is_finite() && pose.is_finite()).then_some(Self {
            pose,
            major,
            minor,
        })
    }
}

impl Model<3> for TorusModel {
    const UNKNOWNS: usize = 7;
    const ROWS: usize = 1;

    fn residuals(&self, x: &Vector3<f64>) -> [f64; 2] {
        let (_, distance, height) = self.pose.cylindrical(x);
        [(distance - self.major).hypot(height) - self.minor, 0.0]
    }

    fn rows(&self, x: &Vector3<f64>) -> [Row; 2] {
        let (out, distance, height) = self.pose.cylindrical(x);
        let (e, z, t) = (self.pose.e, self.pose.z, self.pose.t());
        let across = distance - self.major;
        let q = across.hypot(height);
        let (sin, cos) = if q > 0.0 { (height / q, across / q) } else { (0.0, 1.0) };
        let n = out * cos + z * sin;
        let mut row = Row { residual: q - self.minor, ..Row::default() };
        // Motions about the origin, where the data are.
        let pivot = Vector3::zeros();
        for (k, axis) in [e, t, z].iter().enumerate() {
            row.slopes[k] = -n.dot(axis);
        }
        row.slopes[3] = turning(&n, x, &pivot, &e);
        row.slopes[4] = turning(&n, x, &pivot, &t);
        row.slopes[5] = -cos;
        row.slopes[6] = -1.0;
        [row, Row::default()]
    }

    fn moved(&self, step: &Step) -> Option<Self> {
        let (e, z, t) = (self.pose.e, self.pose.z, self.pose.t());
        let shift = e * step[0] + t * step[1] + z * step[2];
        let pose = self.pose.moved(e * step[3] + t * step[4], &Vector3::zeros(), shift);
        let (major, minor) = (self.major + step[5], self.minor + step[6]);
        let valid = minor > 0.0 && major > minor && major.is_finite() && pose.is_finite();
        valid.then_some(Self { pose, major, minor })
    }

    fn elements(&self, _: &Vector3<f64>) -> Elements<3> {
        Elements {
            location: self.pose.point,
            direction: Some(upright(self.pose.z)),
            radius: Some(self.major),
            minor_radius: Some(self.minor),
            half_angle: None,
        }
    }
}
