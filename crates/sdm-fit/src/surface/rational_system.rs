//! Normal equations in control points and weights.
//!
//! `∂s/∂dᵢ = Rᵢ` and `∂s/∂ln wᵢ = Rᵢ (dᵢ − s)` with the rational basis functions `Rᵢ`.

use super::active::unknowns_of;
use crate::assemble::add_products;
use crate::layout::{Blocks, Layout, triangle};
use crate::parallel;
use crate::rational::{LARGEST_CHANGE, LARGEST_LOGARITHM};
use crate::shape::CellTable;
use crate::simd::vectorized;
use distance_field::PrincipalFrame;
use nalgebra::{SVector, Vector3};
use nurbs_core::{BsplineSurface, MAX_DEGREE, basis};

/// Layout of the unknowns: coordinates of control points first, logarithms of weights behind them.
pub(super) struct Unknowns {
    /// Number of the point of each control point, which repetitions and poles share, and of its weight, which poles do not.
    points: Vec<usize>,
    weights: Vec<usize>,
    point_count: usize,
    pub(super) count: usize,
    /// The unknowns of each cell: three coordinates and the weight of one control point after the other.
    pub(super) cells: CellTable,
    spans: [Vec<usize>; 2],
}

impl Unknowns {
    pub(super) fn new(surface: &BsplineSurface) -> Self {
        let (points, point_count) = unknowns_of(surface);
        let (d_u, d_v) = (surface.knots_u().distinct_count(), surface.knots_v().distinct_count());
        let n_v = surface.n_v();
        let weights: Vec<usize> = (0..points.len()).map(|k| (k / n_v % d_u) * d_v + k % n_v % d_v).collect();
        let spans = [surface.knots_u(), surface.knots_v()].map(|k| k.spans().collect::<Vec<_>>());
        let controls = |u: usize, v: usize| controls_of(surface, u, v);
        let mut table = Vec::new();
        for &u in &spans[0] {
            for &v in &spans[1] {
                let of = |k: usize| {
                    let p = 3 * points[k];
                    [p, p + 1, p + 2, 3 * point_count + weights[k]]
                };
                table.push(controls(u, v).flat_map(of).collect::<Vec<_>>());
            }
        }
        let count = 3 * point_count + d_u * d_v;
        Self { points, weights, point_count, count, cells: CellTable::new(table), spans }
    }

    pub(super) fn weight_count(&self) -> usize {
        self.count - 3 * self.point_count
    }

    /// Normal equations of the mean squared distance.
    pub(super) fn system(
        &self,
        layout: &Layout,
        frames: &[PrincipalFrame<3>],
        surface: &BsplineSurface,
        points: &[Vector3<f64>],
    ) -> (Blocks, Vec<SVector<f64, 1>>) {
        let knots = [surface.knots_u(), surface.knots_v()];
        let mut members = vec![Vec::new(); self.cells.len()];
        for (i, frame) in frames.iter().enumerate().filter(|(_, frame)| frame.is_finite()) {
            let [u, v] = [0, 1].map(|d| {
                let span = knots[d].span(knots[d].normalize(frame.hint.parameter[d]));
                self.spans[d].partition_point(|&s| s < span).min(self.spans[d].len() - 1)
            });
            members[u * self.spans[1].len() + v].push(i);
        }
        let share = 1.0 / points.len().max(1) as f64;
        let sums = parallel::tasks(self.cells.len(), |cell| {
            let width = self.cells.columns(cell).len();
            let (mut pairs, mut products) = (vec![0.0; triangle(width)], vec![0.0; triangle(width)]);
            let (mut vector, mut form) = (vec![0.0; width], vec![0.0; width]);
            let spans = [cell / self.spans[1].len(), cell % self.spans[1].len()];
            let spans = [0, 1].map(|d| self.spans[d][spans[d]]);
            for &i in &members[cell] {
                let frame = &frames[i];
                let levers = levers(surface, spans, frame.hint.parameter);
                // The directions in which the foot cannot move.
                for axis in frame.axes.column_iter().skip(frame.tangent_dimension) {
                    for (slot, (value, lever)) in form.chunks_exact_mut(4).zip(&levers) {
                        for c in 0..3 {
                            slot[c] = value * axis[c];
                        }
                        slot[3] = lever.dot(&axis);
                    }
                    let residual = (points[i] - frame.foot).dot(&axis) * share;
                    vector.iter_mut().zip(&form).for_each(|(v, f)| *v += f * residual);
                    vectorized(
                        #[inline(always)]
                        || add_products(&form, &[share], &mut products, &mut pairs),
                    );
                }
            }
            (pairs, vector)
        });
        let mut matrix = layout.zeros(1);
        let mut vector = vec![SVector::<f64, 1>::zeros(); self.count];
        for (cell, (pairs, part)) in sums.iter().enumerate() {
            if members[cell].is_empty() {
                continue;
            }
            layout.scatter(&self.cells, cell, pairs, &mut matrix);
            for (&column, value) in self.cells.columns(cell).iter().zip(part) {
                vector[column].x += value;
            }
        }
        (matrix, vector)
    }

    /// The surface after a step and the longest way of a control point; `None` if it is none.
    pub(super) fn moved(
        &self,
        surface: &BsplineSurface,
        step: &[SVector<f64, 1>],
    ) -> Option<(BsplineSurface, f64)> {
        let (n_v, mut longest) = (surface.n_v(), 0.0f64);
        let mut net = Vec::with_capacity(self.points.len());
        let mut logs = vec![0.0; self.weight_count()];
        for (k, (&point, &weight)) in self.points.iter().zip(&self.weights).enumerate() {
            let way = Vector3::from_fn(|c, _| step[3 * point + c].x);
            longest = longest.max(way.norm());
            net.push(surface.control_points()[k] + way);
            let change = step[3 * self.point_count + weight].x.clamp(-LARGEST_CHANGE, LARGEST_CHANGE);
            logs[weight] = surface.weight(k / n_v, k % n_v).ln() + change;
        }
        // A common factor of the weights means nothing.
        let mean = logs.iter().sum::<f64>() / logs.len() as f64;
        let weights = self
            .weights
            .iter()
            .map(|&w| (logs[w] - mean).clamp(-LARGEST_LOGARITHM, LARGEST_LOGARITHM).exp())
            .collect();
        let (u, v) = (surface.knots_u().clone(), surface.knots_v().clone());
        Some((BsplineSurface::new(u, v, net, Some(weights)).ok()?, longest))
    }
}

/// The control points that act on the cell of two spans.
fn controls_of(surface: &BsplineSurface, span_u: usize, span_v: usize) -> impl Iterator<Item = usize> {
    let (p, q, n_v) = (surface.degree_u(), surface.degree_v(), surface.n_v());
    (span_u - p..=span_u).flat_map(move |i| (span_v - q..=span_v).map(move |j| i * n_v + j))
}

/// `Rᵢ` and `Rᵢ (dᵢ − s)` of the control points that act at a parameter.
fn levers(surface: &BsplineSurface, spans: [usize; 2], parameter: [f64; 2]) -> Vec<(f64, Vector3<f64>)> {
    let knots = [surface.knots_u(), surface.knots_v()];
    let mut rows = [[0.0; MAX_DEGREE + 1]; 2];
    for d in 0..2 {
        basis::values(knots[d], spans[d], knots[d].normalize(parameter[d]), &mut rows[d]);
    }
    let (width, n_v) = (surface.degree_v() + 1, surface.n_v());
    let mut out: Vec<(f64, Vector3<f64>)> = controls_of(surface, spans[0], spans[1])
        .enumerate()
        .map(|(at, k)| {
            let value = rows[0][at / width] * rows[1][at % width] * surface.weight(k / n_v, k % n_v);
            (value, surface.control_points()[k])
        })
        .collect();
    let total: f64 = out.iter().map(|(value, _)| value).sum();
    let point = out.iter().map(|(value, d)| d * (value / total)).sum::<Vector3<f64>>();
    for (value, d) in &mut out {
        *value /= total;
        *d = (*d - point) * *value;
    }
    out
}
