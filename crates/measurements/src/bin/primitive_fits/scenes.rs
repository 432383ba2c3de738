//! Points on pieces of shapes that are known.

use nalgebra::{Rotation3, Vector3};

/// Numbers that are the same everywhere (splitmix64).
pub(crate) struct Random(pub(crate) u64);

impl Random {
    /// In [0, 1).
    pub(crate) fn even(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }

    pub(crate) fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.even()
    }

    /// Normally distributed.
    pub(crate) fn normal(&mut self) -> f64 {
        (-2.0 * (1.0 - self.even()).ln()).sqrt() * (std::f64::consts::TAU * self.even()).cos()
    }

    pub(crate) fn vector(&mut self) -> Vector3<f64> {
        Vector3::new(self.normal(), self.normal(), self.normal())
    }
}

/// The kinds of shape, circles in the plane as circles with all points at height 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    Line,
    Plane,
    Circle,
    CircleInSpace,
    Sphere,
    Cylinder,
    Cone,
    Torus,
}

pub(crate) const KINDS: [Kind; 8] = [
    Kind::Line,
    Kind::Plane,
    Kind::Circle,
    Kind::CircleInSpace,
    Kind::Sphere,
    Kind::Cylinder,
    Kind::Cone,
    Kind::Torus,
];

/// A shape by a point, an axis and up to two sizes, as the reference sees it: see `reference::distances`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Shape {
    pub(crate) kind: Kind,
    pub(crate) point: Vector3<f64>,
    pub(crate) axis: Vector3<f64>,
    pub(crate) sizes: [f64; 2],
}

/// Points on a piece, and what they are made of.
pub(crate) struct Scene {
    pub(crate) shape: Shape,
    pub(crate) points: Vec<Vector3<f64>>,
    /// Number of points on the shape; the others, at the end, are outliers.
    pub(crate) inliers: usize,
    /// Half the longest side of the box of the points on the shape.
    pub(crate) size: f64,
}

/// What a piece is like: angles in degrees around the axis and across, noise as a share of the larger radius (1).
#[derive(Clone, Copy, Debug)]
pub(crate) struct Piece {
    pub(crate) turn: f64,
    pub(crate) across: f64,
    pub(crate) noise: f64,
    pub(crate) outliers: f64,
    pub(crate) count: usize,
}

/// A piece of a shape with random sizes in a random place.
pub(crate) fn scene(kind: Kind, piece: Piece, seed: u64) -> Scene {
    let mut random = Random(seed.wrapping_mul(0x1234_5678_9abc_def1) ^ (kind as u64) << 56);
    let turn = Rotation3::from_scaled_axis(random.vector());
    let place = random.vector() * 10.0;
    let (first, second) = (random.between(0.0, 360.0), random.between(0.0, 360.0));
    let minor = random.between(0.2, 0.95);
    let (slope, length) = (random.between(0.1, 1.4), piece.across.to_radians());
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a share of the count")]
    let outside = (piece.outliers * piece.count as f64).round() as usize;
    let inliers = piece.count - outside;
    let local = |random: &mut Random| {
        let a = (first + piece.turn * random.even()).to_radians();
        let b = (second + piece.across * random.even()).to_radians();
        let h = random.even();
        let out = Vector3::new(a.cos(), a.sin(), 0.0);
        let z = Vector3::z();
        let (x, normal) = match kind {
            Kind::Line => (z * (piece.turn.to_radians() * h), out),
            Kind::Plane => (Vector3::new(piece.turn.to_radians() * h, length * random.even(), 0.0), z),
            Kind::Circle | Kind::CircleInSpace => (out, out),
            Kind::Sphere => {
                // A cap of half the angle.
                let c = 1.0 - (1.0 - (0.5 * piece.turn).to_radians().cos()) * h;
                let n = Vector3::new((1.0 - c * c).sqrt() * b.cos(), (1.0 - c * c).sqrt() * b.sin(), c);
                (n, n)
            }
            Kind::Cylinder => (out + z * (length * h), out),
            Kind::Cone => {
                let (sin, cos) = (slope.sin(), slope.cos());
                let along = 0.3 + length * h;
                (out * (along * sin) + z * (along * cos), out * cos - z * sin)
            }
            Kind::Torus => {
                let n = out * b.cos() + z * b.sin();
                (out + n * minor, n)
            }
        };
        let flat = kind == Kind::Circle;
        let noise = match kind {
            Kind::Line | Kind::CircleInSpace => random.vector() * piece.noise,
            _ => normal * (random.normal() * piece.noise),
        };
        if flat { x + noise } else { turn * (x + noise) + place }
    };
    let mut points: Vec<Vector3<f64>> = (0..inliers).map(|_| local(&mut random)).collect();
    let (low, high) = points.iter().fold((points[0], points[0]), |(l, h), p| (l.inf(p), h.sup(p)));
    let size = 0.5 * (high - low).amax();
    for _ in 0..outside {
        let off =
            Vector3::new(random.between(-1.0, 1.0), random.between(-1.0, 1.0), random.between(-1.0, 1.0));
        let off = if kind == Kind::Circle { off.xy().push(0.0) } else { off };
        points.push(0.5 * (low + high) + off * (1.2 * size));
    }
    let sizes = match kind {
        Kind::Line | Kind::Plane => [0.0, 0.0],
        Kind::Torus => [1.0, minor],
        // At the apex.
        Kind::Cone => [0.0, slope],
        _ => [1.0, 0.0],
    };
    let (point, axis) =
        if kind == Kind::Circle { (Vector3::zeros(), Vector3::z()) } else { (place, turn * Vector3::z()) };
    Scene { shape: Shape { kind, point, axis, sizes }, points, inliers, size }
}
