//! Where a line meets a B-spline surface: common zeros of two polynomials on its Bézier patches.
//!
//! The distances from two planes through the line are polynomials with Bernstein coefficients. A box of the parameters where one of
//! them has coefficients of one sign only holds no zero; one where the cones of their derivatives keep apart holds at most one,
//! which Newton's method finds. All others are divided.

use super::{Line, Zeros};
use crate::carrier::{Spline, Surface};
use nalgebra::{Matrix2, Vector2};
use nurbs_core::{BezierPatch, ParametricSurface};

/// Boxes that are looked at for one line at most.
const MOST: usize = 20_000;
/// Divisions of a box at most.
const MAX_DEPTH: u32 = 80;
/// Steps of Newton's method at most.
const STEPS: usize = 20;
/// Share of a box by which a zero may lie outside of it.
const OUTSIDE: f64 = 1e-9;

/// Bernstein coefficients over a box of the parameters: distances from the planes times weights, offsets times weights, weights.
#[derive(Clone)]
struct Cell {
    rows: usize,
    columns: usize,
    coefficients: Vec<[f64; 4]>,
    low: Vector2<f64>,
    high: Vector2<f64>,
    depth: u32,
}

/// All zeros with offsets in a range. `nothing` is a length that counts as nothing.
pub(super) fn zeros(line: &Line, spline: &Spline, range: [f64; 2], nothing: f64) -> Zeros {
    let mut out = Zeros { at: Vec::new(), open: f64::INFINITY };
    let Some(across) = Surface::across(&line.direction) else { return out };
    let mut open: Vec<Cell> = spline.patches().iter().map(|patch| Cell::new(patch, line, &across)).collect();
    let mut looked_at = 0;
    while let Some(cell) = open.pop() {
        looked_at += 1;
        if cell.is_empty(range, nothing) {
            continue;
        }
        if looked_at > MOST || cell.depth >= MAX_DEPTH {
            // A line that touches the surface along a curve: told, not hidden.
            out.open = 0.0;
            if looked_at > MOST {
                return out;
            }
            continue;
        }
        if let Some(found) = cell.small(nothing) {
            out.at.push((found, Some((cell.low + cell.high) * 0.5)));
            continue;
        }
        if cell.is_one_to_one()
            && let Some((offset, uv)) = cell.newton(line, spline, &across)
        {
            if (range[0]..=range[1]).contains(&offset) {
                out.at.push((offset, Some(uv)));
            }
            continue;
        }
        open.extend(cell.halves());
    }
    out
}

impl Cell {
    fn new(patch: &BezierPatch, line: &Line, across: &[nalgebra::Vector3<f64>; 2]) -> Self {
        let coefficient = |(k, point): (usize, &nalgebra::Vector3<f64>)| {
            let weight = patch.weights.as_ref().map_or(1.0, |weights| weights[k]);
            let off = point - line.origin;
            [across[0].dot(&off), across[1].dot(&off), line.direction.dot(&off), 1.0].map(|x| x * weight)
        };
        let [u, v] = patch.intervals;
        Self {
            rows: patch.degrees[0] + 1,
            columns: patch.degrees[1] + 1,
            coefficients: patch.control_points.iter().enumerate().map(coefficient).collect(),
            low: Vector2::new(u.start(), v.start()),
            high: Vector2::new(u.end(), v.end()),
            depth: 0,
        }
    }

    /// Whether it is proven to hold no zero in the range.
    fn is_empty(&self, range: [f64; 2], nothing: f64) -> bool {
        let all = |test: &dyn Fn(&[f64; 4]) -> bool| self.coefficients.iter().all(test);
        (0..2).any(|k| all(&|c| c[k] > nothing * c[3]) || all(&|c| c[k] < -nothing * c[3]))
            || all(&|c| c[2] < range[0] * c[3])
            || all(&|c| c[2] > range[1] * c[3])
    }

    /// The offset, where the box is a point.
    fn small(&self, nothing: f64) -> Option<f64> {
        let extent = |k: usize| {
            let values = self.coefficients.iter().map(|c| c[k] / c[3]);
            let (low, high) =
                values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(x), high.max(x)));
            (high - low, 0.5 * (low + high))
        };
        let is_small = (0..3).all(|k| extent(k).0 <= 4.0 * nothing);
        is_small.then(|| extent(2).1)
    }

    fn at(&self, i: usize, j: usize) -> &[f64; 4] {
        &self.coefficients[i * self.columns + j]
    }

    /// Whether the two distances take no pair of values twice: all their derivatives in `u` are on one side of all in `v`.
    fn is_one_to_one(&self) -> bool {
        let step = |a: &[f64; 4], b: &[f64; 4]| Vector2::new(b[0] - a[0], b[1] - a[1]);
        let along_u: Vec<_> = (0..self.rows - 1)
            .flat_map(|i| (0..self.columns).map(move |j| (i, j)))
            .map(|(i, j)| step(self.at(i, j), self.at(i + 1, j)))
            .collect();
        let along_v: Vec<_> = (0..self.rows)
            .flat_map(|i| (0..self.columns - 1).map(move |j| (i, j)))
            .map(|(i, j)| step(self.at(i, j), self.at(i, j + 1)))
            .collect();
        let Some(sign) = along_u.first().zip(along_v.first()).map(|(a, b)| a.perp(b)) else { return false };
        along_u.iter().all(|a| along_v.iter().all(|b| a.perp(b) * sign > 0.0))
    }

    /// The zero in the box, if Newton's method finds it there.
    fn newton(
        &self,
        line: &Line,
        spline: &Spline,
        across: &[nalgebra::Vector3<f64>; 2],
    ) -> Option<(f64, Vector2<f64>)> {
        let size = self.high - self.low;
        let slack = size * OUTSIDE;
        let mut uv = (self.low + self.high) * 0.5;
        for _ in 0..STEPS {
            let jet = spline.surface.jet(uv.x, uv.y);
            let off = jet.point - line.origin;
            let value = Vector2::new(across[0].dot(&off), across[1].dot(&off));
            let slopes = Matrix2::new(
                across[0].dot(&jet.du),
                across[0].dot(&jet.dv),
                across[1].dot(&jet.du),
                across[1].dot(&jet.dv),
            );
            let step = slopes.try_inverse()? * value;
            let next = uv - step;
            let next = next.sup(&(self.low - size * 0.5)).inf(&(self.high + size * 0.5));
            let domain = spline.surface.domain();
            let next = Vector2::new(domain[0].clamp(next.x), domain[1].clamp(next.y));
            let is_done = (0..2).all(|i| (next[i] - uv[i]).abs() <= 1e-15 * (next[i].abs() + size[i]));
            uv = next;
            if is_done {
                break;
            }
        }
        let is_inside = (0..2).all(|i| uv[i] >= self.low[i] - slack[i] && uv[i] <= self.high[i] + slack[i]);
        let off = spline.surface.point(uv.x, uv.y) - line.origin;
        let offset = line.direction.dot(&off);
        let miss = (off - line.direction * offset).norm();
        let scale = self.coefficients.iter().map(|c| (c[0].abs() + c[1].abs()) / c[3]).fold(0.0, f64::max);
        let coordinates =
            spline.surface.control_box().max.amax().max(spline.surface.control_box().min.amax());
        (is_inside && miss <= 1e-9 * scale + 1e-14 * coordinates).then_some((offset, uv))
    }

    /// Both halves across the longer side.
    fn halves(&self) -> [Self; 2] {
        let length =
            |a: &[f64; 4], b: &[f64; 4]| (0..3).map(|k| (b[k] / b[3] - a[k] / a[3]).powi(2)).sum::<f64>();
        let last = (self.rows - 1, self.columns - 1);
        let u = length(self.at(0, 0), self.at(last.0, 0))
            .max(length(self.at(0, last.1), self.at(last.0, last.1)));
        let v = length(self.at(0, 0), self.at(0, last.1))
            .max(length(self.at(last.0, 0), self.at(last.0, last.1)));
        let along_u = if u == v { self.depth.is_multiple_of(2) } else { u > v };
        let (mut first, mut second) = (self.clone(), self.clone());
        let middle = (self.low + self.high) * 0.5;
        let axis = usize::from(!along_u);
        (first.high[axis], second.low[axis]) = (middle[axis], middle[axis]);
        (first.depth, second.depth) = (self.depth + 1, self.depth + 1);
        let (count, lines, step, next) = if along_u {
            (self.rows, self.columns, self.columns, 1)
        } else {
            (self.columns, self.rows, 1, self.columns)
        };
        let mut row = vec![[0.0; 4]; count];
        for l in 0..lines {
            let place = |i: usize| l * next + i * step;
            (0..count).for_each(|i| row[i] = self.coefficients[place(i)]);
            for k in 0..count {
                first.coefficients[place(k)] = row[0];
                second.coefficients[place(count - 1 - k)] = row[count - 1 - k];
                for i in 0..count - 1 - k {
                    row[i] = std::array::from_fn(|c| 0.5 * (row[i][c] + row[i + 1][c]));
                }
            }
        }
        [first, second]
    }
}
