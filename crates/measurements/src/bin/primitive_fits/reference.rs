//! An independent minimiser: other unknowns, derivatives by differences, many starts from the truth outwards.

use super::scenes::{Kind, Random, Scene, Shape};
use nalgebra::{DMatrix, DVector, Vector3};

const STEPS: usize = 40;

/// Unknowns: point, axis (its length is free), two sizes.
type Unknowns = [f64; 8];

fn unknowns(shape: &Shape) -> Unknowns {
    let (p, z) = (shape.point, shape.axis);
    [p.x, p.y, p.z, z.x, z.y, z.z, shape.sizes[0], shape.sizes[1]]
}

/// Residuals of one point: of a surface the signed distance, of a curve its two components.
fn residuals(kind: Kind, u: &Unknowns, x: &Vector3<f64>) -> [f64; 2] {
    let z = Vector3::new(u[3], u[4], u[5]).normalize();
    let d = x - Vector3::new(u[0], u[1], u[2]);
    let height = d.dot(&z);
    let off = (d - z * height).norm();
    match kind {
        Kind::Line => {
            // Two components across the axis.
            let mut e = Vector3::zeros();
            e[z.iamin()] = 1.0;
            let e = (e - z * e.dot(&z)).normalize();
            [d.dot(&e), d.dot(&z.cross(&e))]
        }
        Kind::Plane => [height, 0.0],
        Kind::Circle => [d.xy().norm() - u[6], 0.0],
        Kind::CircleInSpace => [off - u[6], height],
        Kind::Sphere => [d.norm() - u[6], 0.0],
        Kind::Cylinder => [off - u[6], 0.0],
        Kind::Cone => [(off - u[6]) * u[7].cos() - height * u[7].sin(), 0.0],
        Kind::Torus => [(off - u[6]).hypot(height) - u[7].abs(), 0.0],
    }
}

fn cost(kind: Kind, u: &Unknowns, points: &[Vector3<f64>]) -> f64 {
    points.iter().map(|x| residuals(kind, u, x)).map(|[a, b]| a * a + b * b).sum()
}

/// Whether the unknowns are a shape that the fit looks for.
fn is_allowed(kind: Kind, u: &Unknowns) -> bool {
    match kind {
        Kind::Torus => u[6] > u[7].abs(),
        Kind::Cone => u[7].abs() < std::f64::consts::FRAC_PI_2,
        Kind::Line | Kind::Plane => true,
        _ => u[6] > 0.0,
    }
}

/// Levenberg and Marquardt with a Jacobian by central differences.
fn minimised(kind: Kind, mut u: Unknowns, points: &[Vector3<f64>], size: f64) -> (Unknowns, f64) {
    let mut least = cost(kind, &u, points);
    let mut damping = 1e-3;
    for _ in 0..STEPS {
        let mut jacobian = DMatrix::zeros(2 * points.len() + 8, 8);
        let mut right = DVector::zeros(2 * points.len() + 8);
        let widths: Unknowns = std::array::from_fn(|k| if (3..6).contains(&k) { 1e-5 } else { 1e-5 * size });
        for (i, x) in points.iter().enumerate() {
            let r = residuals(kind, &u, x);
            (right[2 * i], right[2 * i + 1]) = (-r[0], -r[1]);
            for k in 0..8 {
                let (mut above, mut below) = (u, u);
                above[k] += widths[k];
                below[k] -= widths[k];
                let (a, b) = (residuals(kind, &above, x), residuals(kind, &below, x));
                for c in 0..2 {
                    jacobian[(2 * i + c, k)] = (a[c] - b[c]) / (2.0 * widths[k]);
                }
            }
        }
        let lengths: Vec<f64> = (0..8).map(|k| jacobian.column(k).norm().max(1e-300)).collect();
        let mut lowered = false;
        while damping < 1e12 {
            let mut damped = jacobian.clone();
            for k in 0..8 {
                damped[(2 * points.len() + k, k)] = f64::sqrt(damping) * lengths[k];
            }
            let qr = damped.qr();
            let Some(step) = qr.r().solve_upper_triangular(&qr.q().tr_mul(&right)) else { break };
            let mut next = u;
            for k in 0..8 {
                next[k] += step[k];
            }
            let value = cost(kind, &next, points);
            if value < least && is_allowed(kind, &next) {
                let small = least - value < 1e-13 * least;
                (u, least, lowered) = (next, value, !small);
                damping = (damping * 0.1).max(1e-14);
                break;
            }
            damping *= 10.0;
        }
        if !lowered {
            break;
        }
    }
    (u, least)
}

/// The lowest root mean square that is known: of the shape itself, and of minima around it.
pub(crate) fn lowest(scene: &Scene, starts: usize, seed: u64) -> f64 {
    let Shape { kind, .. } = scene.shape;
    let points = &scene.points[..scene.inliers];
    // About the middle of the points; the point of an axis is the one nearest to them.
    let middle = points.iter().sum::<Vector3<f64>>() / points.len() as f64;
    let moved: Vec<Vector3<f64>> = points.iter().map(|p| p - middle).collect();
    let mut truth = scene.shape;
    truth.point -= middle;
    if matches!(kind, Kind::Line | Kind::Cylinder | Kind::Cone) {
        let height = -truth.point.dot(&truth.axis);
        truth.point += truth.axis * height;
        if kind == Kind::Cone {
            truth.sizes[0] = height * truth.sizes[1].tan();
        }
    }
    let truth = unknowns(&truth);
    let mut random = Random(seed);
    let mut best = cost(kind, &truth, &moved);
    for k in 0..starts {
        let mut start = truth;
        if k > 0 {
            // Further and further away.
            let far = 10f64.powf(-2.0 + 2.5 * k as f64 / starts as f64);
            for (j, s) in start.iter_mut().enumerate() {
                *s += far * random.normal() * if (3..6).contains(&j) { 1.0 } else { scene.size };
            }
        }
        if is_allowed(kind, &start) {
            best = best.min(minimised(kind, start, &moved, scene.size).1);
        }
    }
    (best / moved.len() as f64).sqrt()
}
