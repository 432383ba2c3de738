//! Shapes and laws that several tests share.
#![allow(dead_code, reason = "each test uses a part")]
#![allow(clippy::unwrap_used, reason = "the shapes are known to be valid")]

use distance_field::{DistanceField, ErrorTerm, Hint, PrincipalFrame, Search};
use mesh_core::{TriangleMesh, VertexWelder};
use nalgebra::{Point3, SVector, Vector3};
use nurbs_core::{BsplineSurface, KnotVector};

/// A small deterministic generator of numbers in [−1, 1].
pub(crate) struct Numbers(u64);

impl Numbers {
    pub(crate) fn new(seed: u64) -> Self {
        Self(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1)
    }

    pub(crate) fn next(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }

    pub(crate) fn vector<const D: usize>(&mut self) -> SVector<f64, D> {
        SVector::from_fn(|_, _| self.next())
    }

    pub(crate) fn direction<const D: usize>(&mut self) -> SVector<f64, D> {
        loop {
            let v = self.vector::<D>();
            if (0.1..1.0).contains(&v.norm()) {
                return v.normalize();
            }
        }
    }
}

/// An open wavy bicubic surface over about [−1, 1]².
pub(crate) fn wavy() -> BsplineSurface {
    let knots = KnotVector::uniform_clamped(3, 7).unwrap();
    let mut points = Vec::new();
    for i in 0..7 {
        for j in 0..7 {
            let (x, y) = (f64::from(i) / 3.0 - 1.0, f64::from(j) / 3.0 - 1.0);
            let z = 0.25 * (2.0 * x + 0.5).sin() * (1.7 * y).cos() + 0.1 * x * y;
            points.push(Vector3::new(x + 0.05 * (3.0 * y).sin(), y - 0.04 * x * x, z));
        }
    }
    BsplineSurface::new(knots.clone(), knots, points, None).unwrap()
}

/// Slope of the largest error of the Taylor model over steps `h`, in double logarithmic scale: 3 or more where the
/// model is that of the second order. `None` when the error is rounding error throughout.
pub(crate) fn taylor_order<const D: usize, F: DistanceField<D>>(
    field: &F,
    x: &SVector<f64, D>,
    reach: f64,
    seed: u64,
) -> Option<f64> {
    let model = field.quadratic(x, ErrorTerm::Taylor);
    let mut numbers = Numbers::new(seed);
    let directions: Vec<SVector<f64, D>> = (0..12).map(|_| numbers.direction()).collect();
    let mut rows = Vec::new();
    for k in 0..4 {
        let h = reach * 0.5f64.powi(k);
        let error = directions
            .iter()
            .map(|e| {
                let y = x + e * h;
                (field.distance(&y).powi(2) - model.value(&y)).abs()
            })
            .fold(0.0, f64::max);
        rows.push((h.ln(), error.max(1e-300).ln()));
    }
    let noise = 1e-13 * (1.0 + x.norm()).powi(2);
    if rows[0].1.exp() < 100.0 * noise {
        return None;
    }
    let rows: Vec<_> = rows.into_iter().filter(|r| r.1.exp() > 10.0 * noise).collect();
    let n = rows.len() as f64;
    if rows.len() < 2 {
        return None;
    }
    let (mx, my) = (rows.iter().map(|r| r.0).sum::<f64>() / n, rows.iter().map(|r| r.1).sum::<f64>() / n);
    let up: f64 = rows.iter().map(|r| (r.0 - mx) * (r.1 - my)).sum();
    let down: f64 = rows.iter().map(|r| (r.0 - mx).powi(2)).sum();
    Some(up / down)
}

/// The invariants that every usable frame of a footpoint has.
pub(crate) fn check_frame<const D: usize>(frame: &PrincipalFrame<D>, x: &SVector<f64, D>, tolerance: f64) {
    assert!(frame.is_finite(), "{frame:?}");
    let gram = frame.axes.tr_mul(&frame.axes);
    for i in 0..D {
        for j in 0..D {
            let expected = if i == j { 1.0 } else { 0.0 };
            assert!((gram[(i, j)] - expected).abs() < 1e-9, "axes {gram}");
        }
        assert!(i < frame.tangent_dimension || frame.curvatures[i] == 0.0);
    }
    let gap = (frame.foot + frame.normal() * frame.distance - x).norm();
    assert!(gap <= tolerance, "x is {gap} from the normal; {frame:?}");
}

/// The frame at the nearest point.
pub(crate) fn global_frame<const D: usize, F: DistanceField<D>>(
    field: &F,
    x: &SVector<f64, D>,
) -> PrincipalFrame<D> {
    field.frame(x, Search::Global, &Hint::NONE)
}

/// A closed mesh whose vertices lie on a sphere around the origin: a cube with `n × n` squares on each side, blown up.
pub(crate) fn sphere_mesh(n: u16, radius: f64) -> TriangleMesh {
    let (mut vertices, mut triangles) = (Vec::new(), Vec::new());
    // The same numbers on all sides, up to the sign, and exactly 1 at the edges of the cube.
    let at = |i: u16| {
        let share = (2.0 * f64::from(i) - f64::from(n)) / f64::from(n);
        if share.abs() == 1.0 { share } else { (std::f64::consts::FRAC_PI_4 * share).tan() }
    };
    let mut welder = VertexWelder::with_capacity(0);
    for side in 0..6usize {
        let sign = if side < 3 { 1.0 } else { -1.0 };
        let corner = |i: u16, j: u16| {
            let mut p = Vector3::zeros();
            p[side % 3] = 1.0;
            p[(side + 1) % 3] = at(i);
            p[(side + 2) % 3] = at(j);
            Point3::from(p * sign)
        };
        for i in 0..n {
            for j in 0..n {
                let quad =
                    [corner(i, j), corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1)].map(|p| {
                        let index = welder.insert(p).unwrap();
                        if index as usize == vertices.len() {
                            vertices.push(Point3::from(p.coords.normalize() * radius));
                        }
                        index
                    });
                let [a, b, c, d] = quad;
                if sign > 0.0 {
                    triangles.extend([[a, b, c], [a, c, d]]);
                } else {
                    triangles.extend([[a, c, b], [a, d, c]]);
                }
            }
        }
    }
    TriangleMesh::new(vertices, triangles).unwrap()
}
