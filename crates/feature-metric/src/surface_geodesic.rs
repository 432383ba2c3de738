//! Geodesic curves on parametric surfaces between two points (\[P05, sec. 6\]).

use crate::{Error, Metric};
use nalgebra::{Matrix2, SVector, Vector2, Vector3};
use nurbs_core::{Interval, ParametricSurface};

/// How a geodesic is found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GeodesicOptions {
    /// Pieces of the polyline that the last result is computed on, a multiple of 4; default 1024.
    pub pieces: usize,
    /// Most Newton steps on each polyline; default 60.
    pub max_iterations: usize,
}

impl Default for GeodesicOptions {
    fn default() -> Self {
        Self { pieces: 1024, max_iterations: 60 }
    }
}

/// A geodesic between two points of a surface.
#[derive(Clone, Debug, PartialEq)]
pub struct SurfaceGeodesic {
    /// Parameters along it, at equal lengths; on closed surfaces they may leave the domain by a period.
    pub parameters: Vec<[f64; 2]>,
    /// The points there.
    pub points: Vec<Vector3<f64>>,
    /// Length in the metric, extrapolated from polylines of three sizes.
    pub length: f64,
    /// Difference of the last two extrapolations.
    pub error: f64,
    /// Whether the energy is stationary, and no point was held at the boundary of the surface.
    pub is_geodesic: bool,
}

/// Share of the energy's scale below which its gradient counts as zero.
const STATIONARY: f64 = 1e-11;
/// Pieces of the first polyline.
const COARSE: usize = 32;
/// How far starts bend to the sides of the straight line of the parameters, as shares of its length.
const BOWS: [f64; 3] = [0.0, 0.3, -0.3];
/// Share of the domain by which the derivatives of the image are differentiated; only the speed of Newton's method depends on it.
const DIFFERENCE: f64 = 1e-5;
/// Share of the size of a surface up to which its opposite sides are one.
const CLOSED: f64 = 1e-9;

/// The shortest of the geodesics that some starts lead to: the straight line of the parameters, to both sides of closed surfaces,
/// and lines that bow to its sides.
///
/// The polyline `Y_k = (x, w n)(u_k, v_k)` of least energy `Σ |Y_{k+1} − Y_k|²` is found by Newton's method, on finer and finer
/// polylines; the error of its length is of second order and is extrapolated. Locally shortest, not certainly the shortest of all.
///
/// # Errors
/// [`Error::Parameters`] unless both points lie in the domain; [`Error::Option`] for a width that is negative or not finite, and
/// for too few pieces.
pub fn surface_geodesic(
    surface: &dyn ParametricSurface,
    from: [f64; 2],
    to: [f64; 2],
    metric: Metric,
    options: &GeodesicOptions,
) -> Result<SurfaceGeodesic, Error> {
    metric.validate()?;
    let pieces = options.pieces;
    if pieces < 2 * COARSE || !pieces.is_multiple_of(4) {
        return Err(Error::Option {
            name: "pieces",
            value: pieces as f64,
            allowed: "a multiple of 4, and at least 64",
        });
    }
    let image = Image::new(surface, metric.width());
    for [u, v] in [from, to] {
        let [a, b] = image.domain;
        if !(a.contains(u) && b.contains(v)) {
            let domain = [a.start(), a.end(), b.start(), b.end()];
            return Err(Error::Parameters { u, v, domain });
        }
    }
    let mut best: Option<(f64, Polyline)> = None;
    for start in image.starts(from, to) {
        let found = image.minimise(start, options.max_iterations);
        let length = image.length(&found.nodes);
        if best.as_ref().is_none_or(|(known, _)| length < known * (1.0 - 1e-9)) {
            best = Some((length, found));
        }
    }
    let start = best.map(|(_, found)| found.nodes).unwrap_or_else(|| vec![from.into(), to.into()]);
    let mut lengths = Vec::new();
    let mut last = Polyline { nodes: start, is_stationary: true };
    for pieces in [pieces / 4, pieces / 2, pieces] {
        last = image.minimise(resampled(&last.nodes, pieces), options.max_iterations);
        lengths.push(image.length(&last.nodes));
    }
    let extrapolated = |k: usize| (4.0 * lengths[k + 1] - lengths[k]) / 3.0;
    let points = last.nodes.iter().map(|p| image.jet(p).point).collect();
    Ok(SurfaceGeodesic {
        parameters: last.nodes.iter().map(|p| [p.x, p.y]).collect(),
        points,
        length: extrapolated(1),
        error: (extrapolated(1) - extrapolated(0)).abs(),
        is_geodesic: last.is_stationary,
    })
}

struct Polyline {
    nodes: Vec<Vector2<f64>>,
    is_stationary: bool,
}

/// The image `(x, w n)` of a surface.
struct Image<'a> {
    surface: &'a dyn ParametricSurface,
    width: f64,
    domain: [Interval; 2],
    closed: [bool; 2],
}

/// The image at a point, and its derivatives.
#[derive(Clone, Copy)]
struct ImageJet {
    point: Vector3<f64>,
    value: SVector<f64, 6>,
    first: [SVector<f64, 6>; 2],
}

impl<'a> Image<'a> {
    fn new(surface: &'a dyn ParametricSurface, width: f64) -> Self {
        let domain = surface.domain();
        let periods = surface.period();
        let [u, v] = domain;
        let closed = [0, 1].map(|axis| {
            let along = |s: f64, end: f64| {
                let (p, q) = if axis == 0 { (u.lerp(end), v.lerp(s)) } else { (u.lerp(s), v.lerp(end)) };
                surface.jet(p, q)
            };
            let meets = |s: f64| {
                let (one, other, middle) = (along(s, 0.0), along(s, 1.0), along(s, 0.5));
                let size = (one.point - middle.point).norm();
                let normals = one.unit_normal().zip(other.unit_normal());
                (one.point - other.point).norm() <= CLOSED * size
                    && normals.is_none_or(|(a, b)| (a - b).norm() < 1e-6)
            };
            periods[axis].is_some() || [0.1, 0.35, 0.6, 0.85].into_iter().all(meets)
        });
        Self { surface, width, domain, closed }
    }

    /// The jet, parameters of closed surfaces taken back into the domain.
    fn jet(&self, at: &Vector2<f64>) -> ImageJet {
        let inside = |axis: usize| {
            let interval = self.domain[axis];
            if self.closed[axis] { interval.wrap(at[axis]) } else { interval.clamp(at[axis]) }
        };
        let (u, v) = (inside(0), inside(1));
        let jet = self.surface.jet(u, v);
        let mut value = SVector::<f64, 6>::zeros();
        let mut first = [value; 2];
        value.fixed_rows_mut::<3>(0).copy_from(&jet.point);
        first[0].fixed_rows_mut::<3>(0).copy_from(&jet.du);
        first[1].fixed_rows_mut::<3>(0).copy_from(&jet.dv);
        if self.width > 0.0 {
            // At poles the normal is that of a point beside.
            let regular = jet.unit_normal().map(|normal| (jet, normal)).or_else(|| {
                let [a, b] = self.domain;
                let beside = |t: f64, interval: Interval| t + (interval.midpoint() - t) * 1e-6;
                let jet = self.surface.jet(beside(u, a), beside(v, b));
                jet.unit_normal().map(|normal| (jet, normal))
            });
            if let Some((jet, normal)) = regular {
                let cross = jet.du.cross(&jet.dv);
                let turn = |one: &Vector3<f64>, other: &Vector3<f64>| {
                    let change = one.cross(&jet.dv) + jet.du.cross(other);
                    (change - normal * normal.dot(&change)) / cross.norm()
                };
                let turns = [turn(&jet.duu, &jet.duv), turn(&jet.duv, &jet.dvv)];
                value.fixed_rows_mut::<3>(3).copy_from(&(normal * self.width));
                for (derivative, turn) in first.iter_mut().zip(turns) {
                    derivative.fixed_rows_mut::<3>(3).copy_from(&(turn * self.width));
                }
            }
        }
        ImageJet { point: jet.point, value, first }
    }

    /// Second derivatives, by differences of the first ones.
    fn second(&self, at: &Vector2<f64>) -> [SVector<f64, 6>; 3] {
        let along = |axis: usize| {
            let step = DIFFERENCE * self.domain[axis].length();
            let mut offset = Vector2::zeros();
            offset[axis] = step;
            let (ahead, behind) = (self.jet(&(at + offset)).first, self.jet(&(at - offset)).first);
            [0, 1].map(|k| (ahead[k] - behind[k]) / (2.0 * step))
        };
        let ([uu, uv], [vu, vv]) = (along(0), along(1));
        [uu, (uv + vu) * 0.5, vv]
    }

    fn starts(&self, from: [f64; 2], to: [f64; 2]) -> Vec<Vec<Vector2<f64>>> {
        let copies = |axis: usize| {
            let period = self.domain[axis].length();
            if self.closed[axis] { vec![0.0, period, -period] } else { vec![0.0] }
        };
        let from = Vector2::from(from);
        let mut starts = Vec::new();
        for du in copies(0) {
            for dv in copies(1) {
                let line = Vector2::from(to) + Vector2::new(du, dv) - from;
                let across = Vector2::new(-line.y, line.x);
                for bow in BOWS {
                    let node = |k: usize| {
                        let t = k as f64 / COARSE as f64;
                        self.held(&(from + line * t + across * (4.0 * bow * t * (1.0 - t)))).0
                    };
                    starts.push((0..=COARSE).map(node).collect());
                }
            }
        }
        starts
    }

    /// Parameters within the domain, and along which axes they were held.
    fn held(&self, at: &Vector2<f64>) -> (Vector2<f64>, [bool; 2]) {
        let clamp =
            |axis: usize| if self.closed[axis] { at[axis] } else { self.domain[axis].clamp(at[axis]) };
        let inside = Vector2::new(clamp(0), clamp(1));
        (inside, [inside.x != at.x, inside.y != at.y])
    }

    fn length(&self, nodes: &[Vector2<f64>]) -> f64 {
        let images: Vec<SVector<f64, 6>> = nodes.iter().map(|node| self.jet(node).value).collect();
        images.windows(2).map(|pair| (pair[1] - pair[0]).norm()).sum()
    }

    fn energy(&self, nodes: &[Vector2<f64>]) -> f64 {
        let images: Vec<SVector<f64, 6>> = nodes.iter().map(|node| self.jet(node).value).collect();
        images.windows(2).map(|pair| (pair[1] - pair[0]).norm_squared()).sum()
    }

    /// Newton's method with the damping of Levenberg and Marquardt; the ends stay.
    fn minimise(&self, mut nodes: Vec<Vector2<f64>>, max_iterations: usize) -> Polyline {
        let mut damping = 0.0;
        let mut energy = self.energy(&nodes);
        let mut is_stationary = nodes.len() < 3;
        for _ in 0..max_iterations {
            let system = self.system(&nodes);
            if system.gradient.iter().all(|g| g.is_finite() && *g <= STATIONARY) {
                is_stationary = !system.is_held;
                break;
            }
            let mut moved = None;
            for _ in 0..40 {
                let step = system.solve(damping);
                let trial =
                    step.map(|step| self.stepped(&nodes, &step)).map(|trial| (self.energy(&trial), trial));
                match trial.filter(|(value, _)| *value < energy) {
                    Some(found) => {
                        moved = Some(found);
                        break;
                    }
                    None => damping = if damping == 0.0 { 1e-6 } else { 10.0 * damping },
                }
                if damping > 1e12 {
                    break;
                }
            }
            let Some((value, trial)) = moved else {
                // No nearer: at the rounding of the energy this is the end.
                is_stationary = !system.is_held && system.gradient.iter().all(|g| *g <= STATIONARY.sqrt());
                break;
            };
            (nodes, energy) = (trial, value);
            damping = if damping < 1e-6 { 0.0 } else { 0.1 * damping };
        }
        Polyline { nodes, is_stationary }
    }

    fn stepped(&self, nodes: &[Vector2<f64>], step: &[Vector2<f64>]) -> Vec<Vector2<f64>> {
        let last = nodes.len() - 1;
        let moved = |k: usize| {
            if k == 0 || k == last { nodes[k] } else { self.held(&(nodes[k] + step[k - 1])).0 }
        };
        (0..=last).map(moved).collect()
    }

    fn system(&self, nodes: &[Vector2<f64>]) -> System {
        let jets: Vec<ImageJet> = nodes.iter().map(|node| self.jet(node)).collect();
        let count = nodes.len() - 2;
        let mut system = System {
            diagonal: Vec::with_capacity(count),
            scale: Vec::with_capacity(count),
            beside: Vec::with_capacity(count),
            right: Vec::with_capacity(count),
            gradient: Vec::with_capacity(count),
            is_held: false,
        };
        let product =
            |one: &ImageJet, other: &ImageJet| Matrix2::from_fn(|i, j| one.first[i].dot(&other.first[j]));
        let whole = (jets[0].value - jets[nodes.len() - 1].value).norm().max(self.length(nodes));
        for k in 1..=count {
            let residual = jets[k].value * 2.0 - jets[k - 1].value - jets[k + 1].value;
            let mut gradient = Vector2::from_fn(|i, _| jets[k].first[i].dot(&residual));
            let [uu, uv, vv] = self.second(&nodes[k]).map(|second| second.dot(&residual));
            let metric = product(&jets[k], &jets[k]);
            let mut block = metric * 2.0 + Matrix2::new(uu, uv, uv, vv);
            let mut next = -product(&jets[k], &jets[k + 1]);
            // Nodes at the boundary that would leave it stay on it.
            for axis in 0..2 {
                let interval = self.domain[axis];
                let at_end = |end: f64| (nodes[k][axis] - end).abs() <= 1e-14 * interval.length();
                let leaves = at_end(interval.start()) && gradient[axis] > 0.0
                    || at_end(interval.end()) && gradient[axis] < 0.0;
                if !self.closed[axis] && leaves {
                    system.is_held = true;
                    gradient[axis] = 0.0;
                    let kept = block[(axis, axis)].abs().max(f64::MIN_POSITIVE);
                    block.fill_row(axis, 0.0);
                    block.fill_column(axis, 0.0);
                    block[(axis, axis)] = kept;
                    next.fill_row(axis, 0.0);
                    if let Some(before) = system.beside.last_mut() {
                        let before: &mut Matrix2<f64> = before;
                        before.fill_column(axis, 0.0);
                    }
                }
            }
            // The gradient as a share of the length, by the length that the parameters have here.
            let size = |i: usize| metric[(i, i)].sqrt().max(f64::MIN_POSITIVE) * whole;
            system.gradient.push((gradient[0] / size(0)).abs().max((gradient[1] / size(1)).abs()));
            system.diagonal.push(block);
            system.scale.push(Vector2::new(metric[(0, 0)], metric[(1, 1)]));
            system.beside.push(next);
            system.right.push(-gradient);
        }
        system
    }
}

/// A symmetric block tridiagonal system.
struct System {
    diagonal: Vec<Matrix2<f64>>,
    /// What the damping adds to.
    scale: Vec<Vector2<f64>>,
    /// The blocks to the right of the diagonal.
    beside: Vec<Matrix2<f64>>,
    right: Vec<Vector2<f64>>,
    /// Size of the gradient at each node.
    gradient: Vec<f64>,
    is_held: bool,
}

impl System {
    /// The solution; `None` if the damped matrix is not positive definite.
    fn solve(&self, damping: f64) -> Option<Vec<Vector2<f64>>> {
        let count = self.diagonal.len();
        let mut inverses = Vec::with_capacity(count);
        let mut sums: Vec<Vector2<f64>> = Vec::with_capacity(count);
        for k in 0..count {
            let mut block = self.diagonal[k] + Matrix2::from_diagonal(&(self.scale[k] * damping));
            let mut sum = self.right[k];
            if k > 0 {
                let across: Matrix2<f64> = self.beside[k - 1].transpose() * inverses[k - 1];
                block -= across * self.beside[k - 1];
                sum -= across * sums[k - 1];
            }
            if !(block[(0, 0)] > 0.0 && block.determinant() > 0.0) {
                return None;
            }
            inverses.push(block.try_inverse()?);
            sums.push(sum);
        }
        let mut solution = vec![Vector2::zeros(); count];
        for k in (0..count).rev() {
            let mut sum = sums[k];
            if k + 1 < count {
                sum -= self.beside[k] * solution[k + 1];
            }
            solution[k] = inverses[k] * sum;
        }
        solution.iter().all(|x| x.iter().all(|c| c.is_finite())).then_some(solution)
    }
}

/// A polyline with another number of pieces, its nodes at equal shares of the index.
fn resampled(nodes: &[Vector2<f64>], pieces: usize) -> Vec<Vector2<f64>> {
    let before = nodes.len() - 1;
    let node = |k: usize| {
        let at = k as f64 * before as f64 / pieces as f64;
        let i = (k * before / pieces).min(before - 1);
        nodes[i] + (nodes[i + 1] - nodes[i]) * (at - i as f64)
    };
    (0..=pieces).map(node).collect()
}
