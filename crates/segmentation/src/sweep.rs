//! Surfaces swept by a motion: extrusions, surfaces of revolution, helical surfaces, by the distances from their profile.

use mesh_core::CloudIndex;
use nalgebra::{DMatrix, DVector, Matrix3, Point2, Point3, Vector2, Vector3};

use crate::carrier::{across, cylindrical};
use crate::decide::limit;
use crate::jets::PointNormal;
use crate::least_squares::mean;
use crate::trend::trend_exceeds;
use crate::velocity::{Fields, Helical};

/// The motion that sweeps a region.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Sweep {
    Extrusion {
        axis: Vector3<f64>,
    },
    Revolution {
        point: Point3<f64>,
        axis: Vector3<f64>,
    },
    /// `pitch` is the advance per radian.
    Helix {
        point: Point3<f64>,
        axis: Vector3<f64>,
        pitch: f64,
    },
}

impl Sweep {
    pub(crate) fn unknowns(&self) -> usize {
        match self {
            Self::Extrusion { .. } => 2,
            Self::Revolution { .. } => 4,
            Self::Helix { .. } => 5,
        }
    }

    /// After a step: tilts of the axis, shifts across it, change of the pitch.
    fn moved(&self, step: &[f64]) -> Self {
        let tilt = |axis: &Vector3<f64>| {
            let (e, f) = across(axis);
            (axis + e * step[0] + f * step[1]).normalize()
        };
        let shift = |point: &Point3<f64>, axis: &Vector3<f64>| {
            let (e, f) = across(axis);
            point + e * step[2] + f * step[3]
        };
        match self {
            Self::Extrusion { axis } => Self::Extrusion { axis: tilt(axis) },
            Self::Revolution { point, axis } => {
                Self::Revolution { point: shift(point, axis), axis: tilt(axis) }
            }
            Self::Helix { point, axis, pitch } => {
                Self::Helix { point: shift(point, axis), axis: tilt(axis), pitch: pitch + step[4] }
            }
        }
    }

    /// The points in the section, and for a helix how much longer gradients are in space than in the section, per point.
    fn section(&self, points: &[Point3<f64>]) -> Vec<(Point2<f64>, f64)> {
        match self {
            Self::Extrusion { axis } => {
                let (e, f) = across(axis);
                points.iter().map(|p| (Point2::new(p.coords.dot(&e), p.coords.dot(&f)), 0.0)).collect()
            }
            Self::Revolution { point, axis } => points
                .iter()
                .map(|p| {
                    let (h, r, _) = cylindrical(p, point, axis);
                    (Point2::new(r, h), 0.0)
                })
                .collect(),
            Self::Helix { point, axis, pitch } => {
                let (e, f) = across(axis);
                let turn = 2.0 * std::f64::consts::PI * pitch;
                let raw: Vec<(f64, f64)> = points
                    .iter()
                    .map(|p| {
                        let (h, r, u) = cylindrical(p, point, axis);
                        (r, h - pitch * u.dot(&f).atan2(u.dot(&e)))
                    })
                    .collect();
                // The profile repeats with every turn: heights are counted from the middle of the first one.
                let (s, c) = raw.iter().fold((0.0, 0.0), |(s, c), (_, z)| {
                    let (a, b) = (z / pitch).sin_cos();
                    (s + a, c + b)
                });
                let middle = pitch * s.atan2(c);
                raw.into_iter()
                    .map(|(r, z)| {
                        let z = z - middle;
                        let z = z - turn * (z / turn).round();
                        (Point2::new(r, z), (pitch / r.max(f64::MIN_POSITIVE)).powi(2))
                    })
                    .collect()
            }
        }
    }

    /// Standard deviation of the distances of points from the profile that the others make; `None` where the section is no curve.
    pub(crate) fn deviation(&self, points: &[Point3<f64>], most: usize) -> Option<f64> {
        self.distances(points, most).map(|distances| rms(&distances))
    }

    /// Distances of the points from the profile that the others make, a parabola over the nearest in the section; scaled so that noise
    /// keeps its standard deviation. `None` where the section is no curve.
    fn distances(&self, points: &[Point3<f64>], most: usize) -> Option<Vec<f64>> {
        self.feet(points, most).map(|feet| feet.into_iter().map(|foot| foot.0).collect())
    }

    /// The same with the normal of the profile in the section, along which a distance is positive.
    fn feet(&self, points: &[Point3<f64>], most: usize) -> Option<Vec<(f64, Vector2<f64>)>> {
        let section = self.section(points);
        let flat: Vec<Point2<f64>> = section.iter().map(|s| s.0).collect();
        if flat.iter().any(|p| !p.x.is_finite() || !p.y.is_finite()) {
            return None;
        }
        let count = (points.len() / 8).clamp(12, most);
        let index = CloudIndex::new(&flat).ok()?;
        let distances = index.map_nearest_n(&flat, count, |i, near| {
            let n = near.len() as f64;
            let (mx, my) =
                near.iter().fold((0.0, 0.0), |(a, b), q| (a + flat[q.index].x / n, b + flat[q.index].y / n));
            let (mut xx, mut xy, mut yy) = (0.0, 0.0, 0.0);
            for q in near {
                let (x, y) = (flat[q.index].x - mx, flat[q.index].y - my);
                xx += x * x;
                xy += x * y;
                yy += y * y;
            }
            let angle = 0.5 * (2.0 * xy).atan2(xx - yy);
            let (s, c) = angle.sin_cos();
            let scale = ((xx + yy) / n).sqrt().max(f64::MIN_POSITIVE);
            let local = |k: usize| {
                let (x, y) = (flat[k].x - mx, flat[k].y - my);
                ((x * c + y * s) / scale, y * c - x * s)
            };
            let (mut matrix, mut right) = (Matrix3::identity() * 1e-9, Vector3::zeros());
            for q in near {
                let (u, v) = local(q.index);
                let row = Vector3::new(1.0, u, u * u);
                matrix += row * row.transpose();
                right += row * v;
            }
            let Some(inverse) = matrix.try_inverse() else { return (0.0, Vector2::x()) };
            let k = inverse * right;
            let (u, v) = local(i);
            let row = Vector3::new(1.0, u, u * u);
            let leverage = row.dot(&(inverse * row)).min(0.9);
            let slope = (k[1] + 2.0 * k[2] * u) / scale;
            // Gradient of v − k(u) in the section, then in space.
            let (gx, gy) = (-slope * c - s, c - slope * s);
            let norm = (gx * gx + gy * gy * (1.0 + section[i].1)).sqrt();
            ((v - row.dot(&k)) / norm / (1.0 - leverage).sqrt(), Vector2::new(gx, gy).normalize())
        });
        Some(distances)
    }
}

/// Whether the distances of points from a surface of revolution have a trend over it, as those of another surface have.
///
/// A profile gives a surface of revolution the freedom that a torus has at a point, and more.
pub(crate) fn is_no_revolution(sweep: &Sweep, points: &[Point3<f64>], sigma: f64, allowed: f64) -> bool {
    let Sweep::Revolution { point, axis } = sweep else { return false };
    let Some(feet) = sweep.feet(points, SAMPLES[1].1) else { return false };
    // On one side of the profile, as far as its normals turn by less than a right angle from the middle one.
    let first = feet.first().map_or_else(Vector2::x, |foot| foot.1);
    let middle: Vector2<f64> = feet.iter().map(|(_, n)| if n.dot(&first) < 0.0 { -n } else { *n }).sum();
    let feet: Vec<(f64, Point3<f64>)> = points
        .iter()
        .zip(&feet)
        .map(|(x, (distance, normal))| {
            let (_, _, away) = cylindrical(x, point, axis);
            let side = if normal.dot(&middle) < 0.0 { -1.0 } else { 1.0 };
            (side * distance / sigma, x - (away * normal.x + axis * normal.y) * *distance)
        })
        .collect();
    trend_exceeds(&feet, allowed)
}

fn rms(distances: &[f64]) -> f64 {
    (distances.iter().map(|d| d * d).sum::<f64>() / distances.len().max(1) as f64).sqrt()
}

/// Most points that take part, and most points of a piece of the profile: few points in wide pieces, then, where the profile bends too
/// much for them, many in narrow ones.
pub(crate) const SAMPLES: [(usize, usize); 2] = [(600, 40), (4000, 16)];

/// Covariance of the unknowns of a motion for a noise: tilts of the axis, shifts across it, advance per radian, as far as it has them. `None`
/// where the points do not determine it.
pub(crate) fn covariance(sweep: &Sweep, points: &[Point3<f64>], sigma: f64) -> Option<DMatrix<f64>> {
    let (count, most) = SAMPLES[0];
    let stride = points.len().div_ceil(count).max(1);
    let some: Vec<Point3<f64>> = points.iter().copied().step_by(stride).collect();
    let centre = mean(&some);
    let extent = some.iter().map(|p| (p - centre).norm()).fold(f64::MIN_POSITIVE, f64::max);
    let n = sweep.unknowns();
    let mut jacobian = DMatrix::<f64>::zeros(some.len(), n);
    for k in 0..n {
        let width = if k < 2 { sigma / extent } else { sigma };
        let mut step = [0.0; 5];
        step[k] = width;
        let above = sweep.moved(&step).distances(&some, most)?;
        step[k] = -width;
        let below = sweep.moved(&step).distances(&some, most)?;
        for i in 0..some.len() {
            jacobian[(i, k)] = (above[i] - below[i]) / (2.0 * width);
        }
    }
    let inverse = jacobian.tr_mul(&jacobian).cholesky()?.inverse();
    // All points determine it better than those that were looked at.
    Some(inverse * (sigma * sigma * some.len() as f64 / points.len() as f64))
}

/// The simplest motion whose profile agrees with the noise, and the standard deviation of the distances.
pub(crate) fn decide_sweep(
    points: &[Point3<f64>],
    normals: &[PointNormal],
    sigma: f64,
) -> Option<(Sweep, f64)> {
    let fields = Fields::new(points, normals)?;
    SAMPLES.iter().enumerate().find_map(|(k, &(count, most))| {
        // A second look at the same points would show the same.
        let is_new = k == 0 || points.len() > SAMPLES[0].0;
        is_new.then(|| decide_on(points, &fields, sigma, count, most)).flatten()
    })
}

fn decide_on(
    points: &[Point3<f64>],
    fields: &Fields,
    sigma: f64,
    count: usize,
    most: usize,
) -> Option<(Sweep, f64)> {
    let stride = points.len().div_ceil(count).max(1);
    let some: Vec<Point3<f64>> = points.iter().copied().step_by(stride).collect();
    if some.len() < 40 {
        return None;
    }
    let centre = mean(points);
    let near = |m: &Helical| m.point + m.axis * (centre - m.point).dot(&m.axis);
    let extent = some.iter().map(|p| (p - centre).norm()).fold(0.0, f64::max);
    let mut starts = vec![Sweep::Extrusion { axis: fields.translations[0].1 }];
    for k in 0..2 {
        if let Some(m) = fields.motion(k).filter(|m| (near(m) - centre).norm() < 50.0 * extent) {
            starts.push(Sweep::Revolution { point: near(&m), axis: m.axis });
        }
    }
    starts.extend(helix_near(fields, &centre, extent));
    let limit = 1.05 * limit(sigma, some.len());
    starts
        .iter()
        .find_map(|start| refine(start, &some, sigma, extent, most).filter(|(_, value)| *value < limit))
}

/// The most tangential motion, if it is a helical one whose axis passes a place and whose pitch is none of a rotation or translation.
pub(crate) fn helix_near(fields: &Fields, centre: &Point3<f64>, extent: f64) -> Option<Sweep> {
    let m = fields.motion(0)?;
    let point = m.point + m.axis * (centre - m.point).dot(&m.axis);
    let pitch = m.pitch.abs();
    let is_helical =
        pitch > 0.02 * extent && pitch < 50.0 * extent && (point - centre).norm() < 50.0 * extent;
    is_helical.then_some(Sweep::Helix { point, axis: m.axis, pitch: m.pitch })
}

/// Steps of Gauss and Newton with differences, the profile found again for each motion.
pub(crate) fn refine(
    start: &Sweep,
    points: &[Point3<f64>],
    sigma: f64,
    extent: f64,
    most: usize,
) -> Option<(Sweep, f64)> {
    let n = start.unknowns();
    let mut sweep = *start;
    let mut distances = sweep.distances(points, most)?;
    let mut best = rms(&distances);
    // Hopeless starts are not worth the steps.
    if best > 60.0 * sigma && best > 0.05 * extent {
        return None;
    }
    let mut damping = 1e-3;
    for _ in 0..8 {
        let mut jacobian = DMatrix::<f64>::zeros(points.len(), n);
        for k in 0..n {
            let width = if k < 2 { 0.3 * best.max(sigma) / extent } else { 0.3 * best.max(sigma) };
            let mut step = [0.0; 5];
            step[k] = width;
            let above = sweep.moved(&step).distances(points, most)?;
            for i in 0..points.len() {
                jacobian[(i, k)] = (above[i] - distances[i]) / width;
            }
        }
        let right = jacobian.tr_mul(&DVector::from_column_slice(&distances));
        let matrix = jacobian.tr_mul(&jacobian);
        let before = best;
        for _ in 0..4 {
            let mut damped = matrix.clone();
            for k in 0..n {
                damped[(k, k)] += damping * matrix[(k, k)] + 1e-12;
            }
            let Some(c) = damped.cholesky() else { break };
            let step = -c.solve(&right);
            let mut full = [0.0; 5];
            full[..n].copy_from_slice(step.as_slice());
            if full.iter().any(|x| !x.is_finite()) {
                break;
            }
            let trial = sweep.moved(&full);
            let Some(next) = trial.distances(points, most) else { break };
            let value = rms(&next);
            if value < best {
                (sweep, distances, best) = (trial, next, value);
                damping *= 0.1;
                break;
            }
            damping *= 10.0;
        }
        if best > 0.995 * before {
            break;
        }
    }
    Some((sweep, best))
}
