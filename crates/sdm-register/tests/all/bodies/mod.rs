//! Shapes and random numbers for tests, examples and benches.

#![allow(dead_code, reason = "every user needs another part")]

use nalgebra::{Matrix3, Rotation3, Vector3};
use sdm_register::Pose;

/// Random numbers that are the same on every run.
pub(crate) struct Random(pub(crate) u64);

impl Random {
    pub(crate) fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        let mixed = (self.0 ^ (self.0 >> 29)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        (mixed >> 11) as f64 / (1u64 << 53) as f64
    }

    pub(crate) fn gauss(&mut self) -> f64 {
        (-2.0 * (1.0 - self.unit()).ln()).sqrt() * (std::f64::consts::TAU * self.unit()).cos()
    }

    pub(crate) fn vector(&mut self) -> Vector3<f64> {
        Vector3::from_fn(|_, _| self.gauss())
    }

    /// A rotation drawn evenly from all.
    pub(crate) fn rotation(&mut self) -> Matrix3<f64> {
        let q = nalgebra::Quaternion::new(self.gauss(), self.gauss(), self.gauss(), self.gauss());
        nalgebra::UnitQuaternion::new_normalize(q).to_rotation_matrix().into_inner()
    }

    /// A rotation by `angle` about a random axis, and a shift of length `shift`.
    pub(crate) fn motion(&mut self, angle: f64, shift: f64) -> Pose<3> {
        let axis = self.vector().normalize();
        let turn = Rotation3::from_scaled_axis(axis * angle).into_inner();
        Pose::new(turn, self.vector().normalize() * shift)
    }
}

/// A star-shaped body with smooth bumps and no symmetry: `|x| = 1 + Σ aₖ sin(⟨bₖ, x/|x|⟩ + cₖ)`, about 2 in diameter.
pub(crate) struct Bumpy {
    waves: Vec<(f64, Vector3<f64>, f64)>,
    stretch: Vector3<f64>,
}

impl Bumpy {
    pub(crate) fn new() -> Self {
        let mut random = Random(11);
        let waves = (0..6).map(|k| {
            let b = random.vector().normalize() * (2.0 + 0.8 * f64::from(k));
            (0.22 / (1.0 + 0.5 * f64::from(k)), b, 6.0 * random.unit())
        });
        Self { waves: waves.collect(), stretch: Vector3::new(1.0, 0.8, 0.65) }
    }

    /// The point in the direction `d` (a unit vector) before stretching, and the outer unit normal.
    pub(crate) fn point(&self, d: &Vector3<f64>) -> (Vector3<f64>, Vector3<f64>) {
        let (mut radius, mut slope) = (1.0, Vector3::zeros());
        for (a, b, c) in &self.waves {
            radius += a * (b.dot(d) + c).sin();
            slope += b * (a * (b.dot(d) + c).cos());
        }
        let across = slope - d * slope.dot(d);
        let normal = d - across / radius;
        // Normals of a stretched body are stretched by the inverse.
        ((d * radius).component_mul(&self.stretch), normal.component_div(&self.stretch).normalize())
    }

    /// `count` random points with their normals, among those that face the direction `towards` within the angle.
    pub(crate) fn view(
        &self,
        towards: Option<(Vector3<f64>, f64)>,
        count: usize,
        random: &mut Random,
    ) -> (Vec<Vector3<f64>>, Vec<Vector3<f64>>) {
        let (mut points, mut normals) = (Vec::new(), Vec::new());
        while points.len() < count {
            let d = random.vector().normalize();
            let (x, n) = self.point(&d);
            // Directions are evenly distributed, points are to be: keep them with a probability that grows with the area.
            let area = x.norm_squared() / n.dot(&x.normalize()).max(0.1) / 6.0;
            let seen = towards.is_none_or(|(w, angle)| n.dot(&w) > angle.cos());
            if seen && random.unit() < area {
                points.push(x);
                normals.push(n);
            }
        }
        (points, normals)
    }
}

/// Six views of the bumpy body from the directions of a cube's faces, each in a frame of its own.
pub(crate) struct SixViews {
    pub(crate) points: Vec<Vec<Vector3<f64>>>,
    pub(crate) normals: Vec<Vec<Vector3<f64>>>,
    /// Map the views to where they belong.
    pub(crate) truth: Vec<Pose<3>>,
    /// The same, disturbed; the first is exact.
    pub(crate) initial: Vec<Pose<3>>,
    pub(crate) diameter: f64,
}

impl SixViews {
    pub(crate) fn new(count: usize, noise: f64, angle: f64, seed: u64) -> Self {
        Self::seeing(1.25, count, noise, angle, seed)
    }

    /// Views that see what faces them up to an angle, in radians: neighbours have a fifth in common for 1.25, twice as much
    /// for 1.5.
    pub(crate) fn seeing(faces: f64, count: usize, noise: f64, angle: f64, seed: u64) -> Self {
        let (body, mut random) = (Bumpy::new(), Random(seed));
        let mut out = Self { points: vec![], normals: vec![], truth: vec![], initial: vec![], diameter: 2.0 };
        for k in 0..6 {
            let towards = Vector3::ith(k / 2, if k % 2 == 0 { 1.0 } else { -1.0 });
            let (points, normals) = body.view(Some((towards, faces)), count, &mut random);
            let truth = Pose::new(random.rotation(), random.vector() * 3.0);
            let back = truth.inverse();
            let noisy = |x: &Vector3<f64>, random: &mut Random| x + random.vector() * (noise * 2.0);
            out.points.push(points.iter().map(|x| back.apply(&noisy(x, &mut random))).collect());
            out.normals.push(normals.iter().map(|n| back.rotate(n)).collect());
            let off = if k == 0 { 0.0 } else { angle };
            out.initial.push(truth.followed_by(&random.motion(off, 0.02 * off.signum() * 2.0)));
            out.truth.push(truth);
        }
        out
    }

    /// Root mean square distance of the points from where they belong, in diameters, when the first view is laid on its truth.
    pub(crate) fn error(&self, poses: &[Pose<3>]) -> f64 {
        let fix = poses[0].inverse().followed_by(&self.truth[0]);
        let (mut sum, mut count) = (0.0, 0);
        for (view, points) in self.points.iter().enumerate() {
            let pose = poses[view].followed_by(&fix);
            for x in points {
                sum += (pose.apply(x) - self.truth[view].apply(x)).norm_squared();
                count += 1;
            }
        }
        (sum / f64::from(count)).sqrt() / self.diameter
    }
}
