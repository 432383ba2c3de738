//! Base shapes: parameters of a cloud by projection.

use super::approximate::{approximate, knots};
use super::base_shape::{BaseShape, NetSize};
use crate::Error;
use crate::cloud_kind::tight_axes;
use crate::primitive::{PrimitiveOptions, fit_torus, start};
use nalgebra::{DMatrix, DVector, Vector2, Vector3};
use nurbs_core::ParametricSurface;
use std::f64::consts::{PI, TAU};

/// Sectors around an axis, slices along it.
const SECTORS: usize = 48;
const SLICES: usize = 16;
/// Largest gap around the axis of a closed cloud.
const GAP: f64 = TAU / 6.0;
/// How much worse a plane may describe a cloud and still be taken, since it is the simplest.
const SIMPLER: f64 = 1.3;
/// Points that choose a base.
const CHOOSERS: usize = 8000;
/// Root mean square distance from a coarse surface, as a share of the size, that is poor.
const POOR: f64 = 0.02;
/// Harmonics of the ends of a cylinder.
const HARMONICS: usize = 3;

/// A base with the parameters of the points, in the unit square.
#[derive(Clone, Debug)]
pub(crate) struct Base {
    pub(crate) shape: BaseShape,
    pub(crate) parameters: Vec<[f64; 2]>,
}

/// The base that was asked for, or the one over which a coarse surface is nearest to the points.
pub(crate) fn choose(points: &[Vector3<f64>], asked: BaseShape) -> Result<Base, Error> {
    let none = Error::Degenerate { shape: "a closed surface", what: "on one side of every axis" };
    match asked {
        BaseShape::Plane => return Ok(plane(points)),
        BaseShape::Cylinder => return best_cylinder(points).ok_or(none),
        BaseShape::Sphere => return Ok(sphere(points, false).unwrap_or_else(|| plane(points))),
        BaseShape::Torus => return torus(points).ok_or(none),
        BaseShape::Auto => {}
    }
    let candidates = [Some(plane(points)), best_cylinder(points), sphere(points, true)];
    let rated = candidates.into_iter().flatten().filter_map(|base| {
        let rms = misfit(points, &base)?;
        Some((if base.shape == BaseShape::Plane { rms / SIMPLER } else { rms }, base))
    });
    let (rms, best) = rated.min_by(|a, b| a.0.total_cmp(&b.0)).ok_or(none)?;
    // Rings are rare, and take longer to find: only where nothing else describes the cloud.
    let size = points.iter().map(|p| p.norm()).fold(0.0, f64::max);
    let ring = if rms > POOR * size { torus(points) } else { None };
    Ok(ring.filter(|base| misfit(points, base).is_some_and(|other| other < rms)).unwrap_or(best))
}

/// Root mean square distance of points from a coarse surface at their parameters.
fn misfit(points: &[Vector3<f64>], base: &Base) -> Option<f64> {
    let step = points.len().div_ceil(CHOOSERS).max(1);
    let thin: Vec<Vector3<f64>> = points.iter().copied().step_by(step).collect();
    let parameters: Vec<[f64; 2]> = base.parameters.iter().copied().step_by(step).collect();
    let side = if thin.len() < 400 { 5 } else { 10 };
    let coarse = Base { parameters, ..base.clone() };
    let size = NetSize { controls: [side, side], ..NetSize::default() };
    let surface = approximate(&thin, coarse.shape, &coarse.parameters, knots(base.shape, size).ok()?).ok()?;
    let square = |(x, p): (&Vector3<f64>, &[f64; 2])| (x - surface.point(p[0], p[1])).norm_squared();
    let sum: f64 = thin.iter().zip(&coarse.parameters).map(square).sum();
    Some((sum / thin.len() as f64).sqrt())
}

/// The principal plane.
fn plane(points: &[Vector3<f64>]) -> Base {
    // The principal axes of a square, or of a disk, can be any.
    let (_, axes) = start::principal(points);
    let [u, v] = tight_axes(points, &axes[2], &axes[0])
        .map(|axis| unit_range(points.iter().map(|p| p.dot(&axis)).collect()));
    let parameters = u.into_iter().zip(v).map(|(u, v)| [u, v]).collect();
    Base { shape: BaseShape::Plane, parameters }
}

/// Values moved and scaled to the interval from 0 to 1.
fn unit_range(values: Vec<f64>) -> Vec<f64> {
    let low = values.iter().copied().fold(f64::INFINITY, f64::min);
    let high = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let length = if high > low { high - low } else { 1.0 };
    values.into_iter().map(|x| ((x - low) / length).clamp(0.0, 1.0)).collect()
}

/// The cylinder, of those about principal axes, coordinate axes and axes of normals, over which the radius is told best.
fn best_cylinder(points: &[Vector3<f64>]) -> Option<Base> {
    let (_, mut axes) = start::principal(points);
    axes.extend([Vector3::x(), Vector3::y(), Vector3::z()]);
    axes.extend(start::axes_of_normals(points).into_iter().map(|(_, axis)| axis));
    let thin = start::thinned(points, CHOOSERS);
    let rated = axes.into_iter().filter_map(|axis| Some((Turned::new(&thin, &axis)?.spread(&thin), axis)));
    let (_, axis) = rated.min_by(|a, b| a.0.total_cmp(&b.0))?;
    Some(Turned::new(points, &axis)?.base(points))
}

/// Cylinder coordinates about a bent axis.
struct Turned {
    x: Vector3<f64>,
    y: Vector3<f64>,
    z: Vector3<f64>,
    /// Heights of the ends.
    range: [f64; 2],
    /// Coefficients of the axis as cubic polynomials of the relative height.
    centre: [DVector<f64>; 2],
}

impl Turned {
    /// `None` where the points do not go around.
    fn new(points: &[Vector3<f64>], axis: &Vector3<f64>) -> Option<Self> {
        let z = axis.normalize();
        let x = start::normal_to(&z);
        let y = z.cross(&x);
        let heights: Vec<f64> = points.iter().map(|p| p.dot(&z)).collect();
        let low = heights.iter().copied().fold(f64::INFINITY, f64::min);
        let high = heights.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        if high <= low {
            return None;
        }
        let mut slices: Vec<Vec<Vector2<f64>>> = vec![Vec::new(); SLICES];
        for (p, h) in points.iter().zip(&heights) {
            slices[bin((h - low) / (high - low), SLICES)].push(Vector2::new(p.dot(&x), p.dot(&y)));
        }
        // The middle of each slice, by its circle, weighted by its points.
        let mut rows = Vec::new();
        for (k, slice) in slices.iter().enumerate() {
            let spread = extent(slice);
            if let Some((centre, _)) = start::taubin(&start::thinned(slice, 500))
                && (centre - start::mean(slice)).norm() < spread
                && slice.len() > 8
            {
                rows.push(((k as f64 + 0.5) / SLICES as f64, centre, (slice.len() as f64).sqrt()));
            }
        }
        let degree = rows.len().saturating_sub(1).min(3);
        if rows.is_empty() {
            return None;
        }
        let matrix = DMatrix::from_fn(rows.len(), degree + 1, |i, j| rows[i].2 * power(rows[i].0, j));
        let svd = matrix.svd(true, true);
        let solve = |c: usize| {
            let right = DVector::from_fn(rows.len(), |i, _| rows[i].2 * rows[i].1[c]);
            svd.solve(&right, 1e-12).ok()
        };
        let turned = Self { x, y, z, range: [low, high], centre: [solve(0)?, solve(1)?] };
        let mut angles: Vec<f64> = points.iter().map(|p| turned.coordinates(p)[0]).collect();
        angles.sort_by(f64::total_cmp);
        let around = angles[0] + TAU - angles[angles.len() - 1];
        let widest = angles.windows(2).map(|w| w[1] - w[0]).fold(around, f64::max);
        (widest < GAP).then_some(turned)
    }

    /// Angle, radius and relative height.
    fn coordinates(&self, p: &Vector3<f64>) -> [f64; 3] {
        let h = (p.dot(&self.z) - self.range[0]) / (self.range[1] - self.range[0]);
        let centre = |c: usize| self.centre[c].iter().enumerate().map(|(k, a)| a * power(h, k)).sum::<f64>();
        let (a, b) = (p.dot(&self.x) - centre(0), p.dot(&self.y) - centre(1));
        [b.atan2(a), a.hypot(b), h]
    }

    /// How far radii in one place differ, on average over the points, as a share of the mean radius.
    fn spread(&self, points: &[Vector3<f64>]) -> f64 {
        let mut cells: Vec<Vec<f64>> = vec![Vec::new(); SECTORS * SLICES];
        let mut total = 0.0;
        for p in points {
            let [angle, radius, h] = self.coordinates(p);
            cells[bin((angle + PI) / TAU, SECTORS) * SLICES + bin(h, SLICES)].push(radius);
            total += radius;
        }
        let deviation = |cell: &Vec<f64>| {
            let mean = cell.iter().sum::<f64>() / cell.len().max(1) as f64;
            cell.iter().map(|r| (r - mean).abs()).sum::<f64>()
        };
        cells.iter().map(deviation).sum::<f64>() / total
    }

    /// Parameters: u by the length of the mean section, v from end to end at each angle.
    fn base(&self, points: &[Vector3<f64>]) -> Base {
        let coordinates: Vec<[f64; 3]> = points.iter().map(|p| self.coordinates(p)).collect();
        let lengths = Lengths::new(&coordinates);
        let [low, high] = ends(&coordinates);
        let parameter = |[angle, _, h]: &[f64; 3]| {
            let (a, b) = (harmonic(&low, *angle), harmonic(&high, *angle));
            let v = if b > a { (h - a) / (b - a) } else { *h };
            [lengths.at((angle + PI) / TAU), v.clamp(0.0, 1.0)]
        };
        Base { shape: BaseShape::Cylinder, parameters: coordinates.iter().map(parameter).collect() }
    }
}

/// Share of the length of the mean section as a function of the angle.
struct Lengths {
    cumulated: Vec<f64>,
}

impl Lengths {
    fn new(coordinates: &[[f64; 3]]) -> Self {
        let (mut sums, mut counts) = (vec![0.0; SECTORS], vec![0.0; SECTORS]);
        for [angle, radius, _] in coordinates {
            let k = bin((angle + PI) / TAU, SECTORS);
            sums[k] += radius;
            counts[k] += 1.0;
        }
        let mean = sums.iter().sum::<f64>() / counts.iter().sum::<f64>().max(1.0);
        let radii: Vec<f64> =
            sums.iter().zip(&counts).map(|(s, n)| if *n > 0.0 { s / n } else { mean }).collect();
        let speed = |k: usize| {
            let slope = (radii[(k + 1) % SECTORS] - radii[(k + SECTORS - 1) % SECTORS])
                / (2.0 * TAU / SECTORS as f64);
            radii[k].hypot(slope).max(0.05 * mean)
        };
        let speeds: Vec<f64> = (0..SECTORS).map(speed).collect();
        // Twice averaged: the parameter is to be smooth.
        let smooth = |f: &[f64]| -> Vec<f64> {
            (0..SECTORS)
                .map(|k| 0.25 * f[(k + SECTORS - 1) % SECTORS] + 0.5 * f[k] + 0.25 * f[(k + 1) % SECTORS])
                .collect()
        };
        let speeds = smooth(&smooth(&speeds));
        let total: f64 = speeds.iter().sum();
        let mut cumulated = vec![0.0];
        for speed in speeds {
            cumulated.push(cumulated[cumulated.len() - 1] + speed / total);
        }
        Self { cumulated }
    }

    /// For a share of the turn.
    fn at(&self, turn: f64) -> f64 {
        let place = turn.clamp(0.0, 1.0) * SECTORS as f64;
        let k = bin(turn, SECTORS);
        let value = self.cumulated[k] + (place - k as f64) * (self.cumulated[k + 1] - self.cumulated[k]);
        value.clamp(0.0, 1.0)
    }
}

/// Lowest and highest relative heights as trigonometric polynomials of the angle.
fn ends(coordinates: &[[f64; 3]]) -> [DVector<f64>; 2] {
    let mut sectors = vec![[f64::INFINITY, f64::NEG_INFINITY]; SECTORS];
    for [angle, _, h] in coordinates {
        let sector = &mut sectors[bin((angle + PI) / TAU, SECTORS)];
        *sector = [sector[0].min(*h), sector[1].max(*h)];
    }
    let known: Vec<(f64, [f64; 2])> = (0..SECTORS)
        .map(|k| ((k as f64 + 0.5) / SECTORS as f64 * TAU - PI, sectors[k]))
        .filter(|(_, s)| s[0].is_finite())
        .collect();
    let count = 2 * HARMONICS + 1;
    let svd = DMatrix::from_fn(known.len(), count, |i, j| wave(known[i].0, j)).svd(true, true);
    [0, 1].map(|end| {
        let right = DVector::from_fn(known.len(), |i, _| known[i].1[end]);
        let fallback = || DVector::from_fn(count, |j, _| if j == 0 { end as f64 } else { 0.0 });
        svd.solve(&right, 1e-9).unwrap_or_else(|_| fallback())
    })
}

fn harmonic(coefficients: &DVector<f64>, angle: f64) -> f64 {
    coefficients.iter().enumerate().map(|(j, a)| a * wave(angle, j)).sum()
}

fn wave(angle: f64, j: usize) -> f64 {
    let phase = j.div_ceil(2) as f64 * angle;
    if j.is_multiple_of(2) { phase.cos() } else { phase.sin() }
}

/// Longitude and latitude about the centre of the least squares sphere; `None` where directions are missing.
fn sphere(points: &[Vector3<f64>], checked: bool) -> Option<Base> {
    let (centre, _) = start::taubin(&start::thinned(points, 2000))?;
    let (_, axes) = start::principal(points);
    let (z, x) = (axes[0], axes[1]);
    let y = z.cross(&x);
    let parameter = |p: &Vector3<f64>| {
        let d = p - centre;
        let longitude = (d.dot(&y).atan2(d.dot(&x)) + PI) / TAU;
        let latitude = d.dot(&z).atan2(d.dot(&x).hypot(d.dot(&y))) / PI + 0.5;
        [longitude.clamp(0.0, 1.0), latitude.clamp(0.0, 1.0)]
    };
    let parameters: Vec<[f64; 2]> = points.iter().map(parameter).collect();
    // Every part of the sphere, of equal area, must be met.
    let (rows, columns) = (8, 12);
    let mut met = vec![false; rows * columns];
    for [u, v] in &parameters {
        let height = ((v - 0.5) * PI).sin() * 0.5 + 0.5;
        met[bin(height, rows) * columns + bin(*u, columns)] = true;
    }
    (!checked || met.iter().all(|m| *m)).then_some(Base { shape: BaseShape::Sphere, parameters })
}

/// Angles about the axis and about the middle of the tube of the least squares torus.
fn torus(points: &[Vector3<f64>]) -> Option<Base> {
    let fit = fit_torus(&start::thinned(points, 3000), &PrimitiveOptions::default()).ok()?;
    let frame = fit.shape.frame();
    let parameter = |p: &Vector3<f64>| {
        let local = frame.local(p);
        let out = local.x.hypot(local.y) - fit.shape.major_radius();
        [local.y.atan2(local.x), local.z.atan2(out)].map(|angle| ((angle + PI) / TAU).clamp(0.0, 1.0))
    };
    let parameters: Vec<[f64; 2]> = points.iter().map(parameter).collect();
    let (rows, columns) = (8, 8);
    let mut met = vec![false; rows * columns];
    parameters.iter().for_each(|[u, v]| met[bin(*u, rows) * columns + bin(*v, columns)] = true);
    met.iter().all(|m| *m).then_some(Base { shape: BaseShape::Torus, parameters })
}

/// Which of `count` equal parts of the unit interval a number falls into.
fn bin(share: f64, count: usize) -> usize {
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped")]
    let k = (share.clamp(0.0, 1.0) * count as f64) as usize;
    k.min(count - 1)
}

fn power(x: f64, k: usize) -> f64 {
    (0..k).map(|_| x).product()
}

/// Diagonal of the box around points.
fn extent(points: &[Vector2<f64>]) -> f64 {
    let Some(first) = points.first() else { return 0.0 };
    let (low, high) = points.iter().fold((*first, *first), |(l, h), p| (l.inf(p), h.sup(p)));
    (high - low).norm()
}
