//! Circles and spheres.

use super::elements::{Elements, upright};
use super::model::{Model, Pose, Row, Step, orthonormal, turning};
use super::random::Random;
use super::start;
use nalgebra::{SVector, Vector3};

/// A circle in the plane or a sphere in space.
#[derive(Clone, Debug)]
pub(super) struct BallModel<const D: usize> {
    pub(super) centre: SVector<f64, D>,
    pub(super) curvature: f64,
    /// Unit vector from the centre towards the data: there is the point that changes of the curvature keep.
    out: SVector<f64, D>,
    /// Orthonormal vectors normal to `out`; the second one is 0 in the plane.
    tangents: [SVector<f64, D>; 2],
}

impl<const D: usize> BallModel<D> {
    pub(super) fn new(centre: SVector<f64, D>, radius: f64) -> Self {
        let off = centre.norm();
        let mut out = SVector::zeros();
        out[0] = 1.0;
        if off > 0.1 * radius && off > 0.0 {
            out = -centre / off;
        }
        let mut order: Vec<usize> = (0..D).collect();
        order.sort_by(|&a, &b| out[a].abs().total_cmp(&out[b].abs()));
        let mut tangents = [SVector::zeros(); 2];
        for k in 0..D - 1 {
            tangents[k][order[k]] = 1.0;
        }
        Self { centre, curvature: 1.0 / radius, out, tangents: straightened(&out, tangents) }
    }
}

/// Two vectors made normal to a third one and to each other.
fn straightened<const D: usize>(
    out: &SVector<f64, D>,
    tangents: [SVector<f64, D>; 2],
) -> [SVector<f64, D>; 2] {
    let first = orthonormal(out, &tangents[0]);
    if D < 3 {
        return [first, SVector::zeros()];
    }
    let second = tangents[1] - first * tangents[1].dot(&first);
    [first, orthonormal(out, &second)]
}

impl<const D: usize> Model<D> for BallModel<D> {
    const UNKNOWNS: usize = D + 1;
    const ROWS: usize = 1;
    const SEVERAL: bool = false;
    const RANDOM_STARTS: usize = 8;

    fn starts(points: &[SVector<f64, D>]) -> Vec<Self> {
        start::ball(points)
    }

    fn from_few(points: &[SVector<f64, D>], _: &mut Random, _: usize) -> Vec<Self> {
        start::ball(points)
    }

    fn residuals(&self, x: &SVector<f64, D>) -> [f64; 2] {
        [(x - self.centre).norm() - 1.0 / self.curvature, 0.0]
    }

    fn rows(&self, x: &SVector<f64, D>) -> [Row; 2] {
        let d = x - self.centre;
        let distance = d.norm();
        let n = if distance > 0.0 { d / distance } else { self.out };
        let radius = 1.0 / self.curvature;
        let mut row = Row { residual: distance - radius, ..Row::default() };
        row.slopes[0] = -n.dot(&self.out);
        row.slopes[1] = (n - self.out).norm_squared() / 2.0 * radius * radius;
        for k in 0..D - 1 {
            row.slopes[2 + k] = n.dot(&self.tangents[k]) * radius;
        }
        [row, Row::default()]
    }

    fn moved(&self, step: &Step) -> Option<Self> {
        let kept = self.centre + self.out / self.curvature + self.out * step[0];
        let curvature = self.curvature + step[1];
        let mut out = self.out;
        for k in 0..D - 1 {
            out += self.tangents[k] * step[2 + k];
        }
        let out = out.normalize();
        let centre = kept - out / curvature;
        let valid = curvature > 0.0 && curvature.is_finite() && centre.iter().all(|c| c.is_finite());
        valid.then(|| Self { centre, curvature, out, tangents: straightened(&out, self.tangents) })
    }

    fn elements(&self, _: &SVector<f64, D>) -> Elements<D> {
        Elements {
            location: self.centre,
            direction: None,
            radius: Some(1.0 / self.curvature),
            minor_radius: None,
            half_angle: None,
        }
    }
}

/// A circle in space.
#[derive(Clone, Debug)]
pub(super) struct CircleModel {
    pub(super) pose: Pose,
    pub(super) curvature: f64,
}

impl CircleModel {
    pub(super) fn new(centre: Vector3<f64>, normal: Vector3<f64>, radius: f64) -> Self {
        let z = normal.normalize();
        let in_plane = -(centre - z * centre.dot(&z));
        let e = if in_plane.norm() > 0.1 * radius { in_plane } else { super::model::normal_to(&z) };
        Self { pose: Pose { point: centre, z, e: orthonormal(&z, &e) }, curvature: 1.0 / radius }
    }
}

impl Model<3> for CircleModel {
    const UNKNOWNS: usize = 6;
    const ROWS: usize = 2;
    const SEVERAL: bool = false;
    const RANDOM_STARTS: usize = 8;

    fn starts(points: &[Vector3<f64>]) -> Vec<Self> {
        start::circle(points)
    }

    fn from_few(points: &[Vector3<f64>], _: &mut Random, _: usize) -> Vec<Self> {
        start::circle(points)
    }

    fn residuals(&self, x: &Vector3<f64>) -> [f64; 2] {
        let (_, distance, height) = self.pose.cylindrical(x);
        [distance - 1.0 / self.curvature, height]
    }

    fn rows(&self, x: &Vector3<f64>) -> [Row; 2] {
        let (n, distance, height) = self.pose.cylindrical(x);
        let (e, z, t, radius) = (self.pose.e, self.pose.z, self.pose.t(), 1.0 / self.curvature);
        let pivot = self.pose.point + e * radius;
        let mut rows = [
            Row { residual: distance - radius, ..Row::default() },
            Row { residual: height, ..Row::default() },
        ];
        for (row, n) in rows.iter_mut().zip([n, z]) {
            let turns = [z, e, t].map(|axis| turning(&n, x, &pivot, &axis));
            row.slopes[..6].copy_from_slice(&[-n.dot(&e), turns[0], turns[1], turns[2], -n.dot(&z), 0.0]);
        }
        rows[0].slopes[5] = (n - e).norm_squared() / 2.0 * radius * radius;
        rows
    }

    fn moved(&self, step: &Step) -> Option<Self> {
        let (e, z, t, radius) = (self.pose.e, self.pose.z, self.pose.t(), 1.0 / self.curvature);
        let pivot = self.pose.point + e * radius;
        let mut pose =
            self.pose.moved(z * step[1] + e * step[2] + t * step[3], &pivot, e * step[0] + z * step[4]);
        let curvature = self.curvature + step[5];
        pose.point += pose.e * (radius - 1.0 / curvature);
        (curvature > 0.0 && curvature.is_finite() && pose.is_finite()).then_some(Self { pose, curvature })
    }

    fn elements(&self, _: &Vector3<f64>) -> Elements<3> {
        Elements {
            location: self.pose.point,
            direction: Some(upright(self.pose.z)),
            radius: Some(1.0 / self.curvature),
            minor_radius: None,
            half_angle: None,
        }
    }
}
