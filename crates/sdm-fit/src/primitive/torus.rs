//! Tori in unknowns about one of their points.

use super::elements::{Elements, upright};
use super::model::{Model, Pose, Row, Step, normal_to, orthonormal, turning};
use super::random::Random;
use super::start;
use nalgebra::{Rotation3, Vector3};

/// Curvatures, in units of the size of the cloud, beyond which a step is refused.
const SHARPEST: f64 = 1e6;

/// Curvature of the ring below which it is as straight as rounding lets one tell: a cylinder.
const STRAIGHT: f64 = 1e-9;

/// A circle turned about an axis, given at one of its points: its normal, the curvature of the profile, and the normal and the
/// tangential curvature of the ring through the point.
///
/// All seven unknowns keep their meaning where a torus becomes a cone (`tube = 0`), a cylinder (`ring = 0`), a plane (both), a
/// sphere or a spindle, so that the search passes through them; [`Model::is_proper`] tells what is a torus.
#[derive(Clone, Debug)]
pub(super) struct TorusModel {
    /// A point of the surface near the data.
    point: Vector3<f64>,
    /// Normal, and the tangents along the profile and along the ring.
    normal: Vector3<f64>,
    profile: Vector3<f64>,
    around: Vector3<f64>,
    /// Curvature of the profile, positive if its centre is on the side that the normal does not point to.
    tube: f64,
    /// `(cos φ, sin φ) / ρ`: distance `ρ` from the axis, angle `φ` of the normal with the plane of the ring.
    ring: [f64; 2],
}

/// What the distance of a point is made of.
struct Place {
    /// Coordinates in the frame of the model: normal, along the profile, along the ring.
    a: f64,
    c: f64,
    y: f64,
    /// Distance from the axis over `ρ`.
    s: f64,
    /// How far the point is moved outwards when it is turned into the plane of the profile, over the curvature of the ring.
    e: f64,
    /// Coordinates after that.
    turned: [f64; 2],
    /// Distance from the centre of the profile over its radius.
    t: f64,
}

impl TorusModel {
    /// The torus given by centre, axis and radii.
    pub(super) fn new(centre: Vector3<f64>, direction: Vector3<f64>, major: f64, minor: f64) -> Option<Self> {
        let z = direction.normalize();
        let pose = Pose { point: centre, z, e: normal_to(&z) };
        let valid = minor > 0.0 && major > 0.0 && major.is_finite() && minor.is_finite() && pose.is_finite();
        if !valid {
            return None;
        }
        let (out, distance, height) = pose.cylindrical(&Vector3::zeros());
        let across = distance - major;
        let q = across.hypot(height);
        // The foot of the origin, unless the data are all around: then the outermost circle, where the ring is least curved.
        let near =
            q > 0.0 && (q - minor).abs() < 0.3 * minor.min(1.0) && major + minor * (across / q) > 0.1 * major;
        let (cos, sin) = if near { (across / q, height / q) } else { (1.0, 0.0) };
        let rho = major + minor * cos;
        if rho <= 0.0 {
            return None;
        }
        Self::at(
            centre + out * rho + z * (minor * sin),
            out * cos + z * sin,
            z * cos - out * sin,
            1.0 / minor,
            [cos / rho, sin / rho],
        )
    }

    fn at(
        point: Vector3<f64>,
        normal: Vector3<f64>,
        profile: Vector3<f64>,
        tube: f64,
        ring: [f64; 2],
    ) -> Option<Self> {
        let around = normal.cross(&profile);
        let finite = [point, normal, profile].iter().all(|v| v.iter().all(|c| c.is_finite()));
        let bounded = tube.abs() < SHARPEST && ring[0].hypot(ring[1]) < SHARPEST;
        (finite && bounded).then_some(Self { point, normal, profile, around, tube, ring })
    }

    fn place(&self, x: &Vector3<f64>) -> Place {
        let d = x - self.point;
        let (a, c, y) = (d.dot(&self.normal), d.dot(&self.profile), d.dot(&self.around));
        let [kn, kt] = self.ring;
        let k_sq = kn * kn + kt * kt;
        let v = 1.0 + kn * a - kt * c;
        let s = (v * v + k_sq * y * y).sqrt();
        // (s − v) / k², without cancellation on the side of the axis where the point is.
        let e = if v > 0.0 { y * y / (s + v) } else { (s - v) / k_sq };
        let turned = [a + kn * e, c - kt * e];
        let v = 1.0 + self.tube * turned[0];
        Place { a, c, y, s, e, turned, t: v.hypot(self.tube * turned[1]) }
    }

    fn distance(&self, place: &Place) -> f64 {
        let [a, c] = place.turned;
        (2.0 * a + self.tube * (a * a + c * c)) / (1.0 + place.t)
    }

    /// Centre, axis, signed distance of the centre of the profile from the axis, radius.
    fn sizes(&self) -> (Vector3<f64>, Vector3<f64>, f64, f64) {
        let [kn, kt] = self.ring;
        let k = kn.hypot(kt);
        let (cos, sin) = if k > 0.0 { (kn / k, kt / k) } else { (1.0, 0.0) };
        let out = self.normal * cos - self.profile * sin;
        let z = self.normal * sin + self.profile * cos;
        let centre = self.point - out / k - z * (sin / self.tube);
        (centre, z, 1.0 / k - cos / self.tube, 1.0 / self.tube.abs())
    }

    /// A shape at a point with everything else at random.
    fn anywhere(point: &Vector3<f64>, random: &mut Random) -> Option<Self> {
        let normal = random.direction();
        let profile = orthonormal(&normal, &random.direction());
        // Curvatures of all sizes: tangents of even angles.
        let tube = (std::f64::consts::PI * random.centred()).tan();
        let ring = (std::f64::consts::PI * random.centred()).tan();
        let (sin, cos) = (std::f64::consts::TAU * random.centred()).sin_cos();
        Self::at(*point, normal, profile, tube, [ring * cos, ring * sin])
    }
}

impl Model<3> for TorusModel {
    const UNKNOWNS: usize = 7;
    const ROWS: usize = 1;
    const SEVERAL: bool = true;

    fn starts(points: &[Vector3<f64>]) -> Vec<Self> {
        start::torus(points)
    }

    fn from_few(points: &[Vector3<f64>], random: &mut Random, count: usize) -> Vec<Self> {
        let Some(first) = points.first() else { return Vec::new() };
        let mut models = start::torus_from_few(points, random, count.min(2));
        models.extend((0..count).filter_map(|_| Self::anywhere(first, random)));
        models
    }

    fn residuals(&self, x: &Vector3<f64>) -> [f64; 2] {
        [self.distance(&self.place(x)), 0.0]
    }

    fn rows(&self, x: &Vector3<f64>) -> [Row; 2] {
        let place = self.place(x);
        let Place { a, c, y, s, e, turned, t } = place;
        let mut row = Row { residual: self.distance(&place), ..Row::default() };
        // Unit normal in the plane of the profile.
        let (mn, mt) =
            if t > 0.0 { ((1.0 + self.tube * turned[0]) / t, self.tube * turned[1] / t) } else { (1.0, 0.0) };
        let [kn, kt] = self.ring;
        let (es, ys) = if s > 0.0 { (e / s, y / s) } else { (0.0, 0.0) };
        // How the turned coordinates change with those of the point.
        let along = mn * kn - mt * kt;
        let n = self.normal * (mn - along * kn * es)
            + self.profile * (mt + along * kt * es)
            + self.around * (along * ys);
        row.slopes[0] = -n.dot(&self.normal);
        for (k, axis) in [self.normal, self.profile, self.around].iter().enumerate() {
            row.slopes[1 + k] = turning(&n, x, &self.point, axis);
        }
        row.slopes[4] = mn * e - along * es * (a + e * kn);
        row.slopes[5] = -mt * e + along * es * (c - e * kt);
        let v = 1.0 + self.tube * turned[0];
        row.slopes[6] = if t <= 0.0 {
            0.0
        } else if v > 0.0 {
            turned[1] * turned[1] / (t * (t + v))
        } else {
            (t - v) / (t * self.tube * self.tube)
        };
        [row, Row::default()]
    }

    fn moved(&self, step: &Step) -> Option<Self> {
        let rotation = self.normal * step[1] + self.profile * step[2] + self.around * step[3];
        let turn = Rotation3::from_scaled_axis(rotation);
        let normal = (turn * self.normal).normalize();
        let profile = orthonormal(&normal, &(turn * self.profile));
        let ring = [self.ring[0] + step[4], self.ring[1] + step[5]];
        Self::at(self.point + self.normal * step[0], normal, profile, self.tube + step[6], ring)
    }

    fn elements(&self, _: &Vector3<f64>) -> Elements<3> {
        let (centre, z, major, minor) = self.sizes();
        Elements {
            location: centre,
            direction: Some(upright(z)),
            radius: Some(major),
            minor_radius: Some(minor),
            half_angle: None,
        }
    }

    fn is_proper(&self) -> bool {
        let (.., major, minor) = self.sizes();
        major > minor && self.ring[0].hypot(self.ring[1]) > STRAIGHT && self.tube.abs() > STRAIGHT
    }

    fn made_proper(self) -> Option<Self> {
        if self.is_proper() {
            return Some(self);
        }
        let (centre, z, major, minor) = self.sizes();
        let minor = minor.min(1e3);
        let near = Self::new(centre, z, major.clamp(minor * (1.0 + 1e-6), 1e6), minor)?;
        near.is_proper().then_some(near)
    }

    fn outside(&self) -> f64 {
        self.tube.signum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn models() -> Vec<TorusModel> {
        let mut random = Random::new(3);
        let anywhere = (0..40).filter_map(|_| TorusModel::anywhere(&(random.direction() * 0.7), &mut random));
        let mut models: Vec<_> =
            anywhere.filter(|m| m.tube.abs() < 20.0 && m.ring[0].hypot(m.ring[1]) < 20.0).collect();
        models.extend(TorusModel::new(Vector3::new(0.1, -0.2, 0.3), Vector3::new(1.0, 2.0, 2.0), 0.8, 0.3));
        models
    }

    #[test]
    fn distances_are_those_of_the_torus() {
        // A full ring about a skew axis, and a piece: the pivot is on the outermost circle, or near the origin.
        let z = Vector3::new(1.0, 2.0, 2.0) / 3.0;
        for centre in [Vector3::zeros(), Vector3::new(0.7, -0.4, 0.3)] {
            let model = TorusModel::new(centre, z, 0.8, 0.3).unwrap();
            let mut random = Random::new(1);
            for _ in 0..100 {
                let x = random.direction() * (2.0 * random.centred());
                let d = x - centre;
                let height = d.dot(&z);
                let expected = ((d - z * height).norm() - 0.8).hypot(height) - 0.3;
                assert!((model.residuals(&x)[0] - expected).abs() < 1e-14, "{x:?}");
            }
            let elements = model.elements(&centre);
            assert!((elements.location - centre).norm() < 1e-14);
            assert!((elements.radius.unwrap() - 0.8).abs() < 1e-14);
            assert!((elements.minor_radius.unwrap() - 0.3).abs() < 1e-14);
            assert!((elements.direction.unwrap() - z).norm() < 1e-14);
        }
    }

    #[test]
    fn slopes_are_differences() {
        let mut random = Random::new(2);
        let mut compared = 0;
        for model in models() {
            for _ in 0..10 {
                let x = random.direction() * (1.5 * random.centred());
                let place = model.place(&x);
                // Near the axis and the middle of the tube the distance is not smooth.
                if place.s < 0.2 || place.t < 0.2 {
                    continue;
                }
                let row = model.rows(&x)[0];
                for k in 0..7 {
                    let at = |h: f64| {
                        let mut step = [0.0; 7];
                        step[k] = h;
                        model.moved(&step).unwrap().residuals(&x)[0]
                    };
                    let expected = (at(1e-5) - at(-1e-5)) / 2e-5;
                    let off = (row.slopes[k] - expected).abs();
                    assert!(off < 1e-6 * (1.0 + expected.abs()), "{k}: {} for {expected}", row.slopes[k]);
                    compared += 1;
                }
            }
        }
        assert!(compared > 500, "{compared}");
    }

    #[test]
    fn only_rings_are_proper() {
        let torus =
            |major, minor| TorusModel::new(Vector3::new(0.2, 0.0, 0.0), Vector3::z(), major, minor).unwrap();
        assert!(torus(1.0, 0.99).is_proper());
        let spindle = torus(0.8, 1.0);
        assert!(!spindle.is_proper());
        let ring = spindle.made_proper().unwrap();
        let (.., major, minor) = ring.sizes();
        assert!(major > minor && (minor - 1.0).abs() < 1e-12 && major < 1.001);
        let mut cylinder = torus(1.0, 0.5);
        cylinder.ring = [0.0, 0.0];
        assert!(!cylinder.is_proper());
    }
}
