//! Areas of surfaces.

use super::{Measure, attainable, noise, rule};
use crate::ParametricSurface;
use std::cmp::Ordering;
use std::collections::BinaryHeap;

/// Most cells that a surface is cut into.
const MAX_CELLS: usize = 20_000;

/// A rectangle of the parameter plane with the area above it.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Cell {
    u: [f64; 2],
    v: [f64; 2],
    area: f64,
    /// Error estimates from the rules in `u` and in `v`.
    errors: [f64; 2],
}

impl Cell {
    fn new<S: ParametricSurface + ?Sized>(surface: &S, u: [f64; 2], v: [f64; 2]) -> Self {
        let nodes = rule::nodes();
        let place = |x: f64, side: [f64; 2]| 0.5 * (side[0] + side[1]) + 0.5 * (side[1] - side[0]) * x;
        let mut values = [[0.0; 15]; 15];
        for (row, a) in values.iter_mut().zip(&nodes) {
            for (value, b) in row.iter_mut().zip(&nodes) {
                *value = surface.jet(place(a.x, u), place(b.x, v)).normal_direction().norm();
            }
        }
        let (mut kronrod, mut gauss_u, mut gauss_v) = (0.0, 0.0, 0.0);
        for (row, a) in values.iter().zip(&nodes) {
            for (value, b) in row.iter().zip(&nodes) {
                kronrod += a.kronrod * b.kronrod * value;
                gauss_u += a.gauss * b.kronrod * value;
                gauss_v += a.kronrod * b.gauss * value;
            }
        }
        let mean = 0.25 * kronrod;
        let mut spread = 0.0;
        for (row, a) in values.iter().zip(&nodes) {
            for (value, b) in row.iter().zip(&nodes) {
                spread += a.kronrod * b.kronrod * (value - mean).abs();
            }
        }
        let scale = 0.25 * (u[1] - u[0]) * (v[1] - v[0]);
        let error = |gauss: f64| scale * rule::error_estimate((kronrod - gauss).abs(), spread);
        Self { u, v, area: scale * kronrod, errors: [error(gauss_u), error(gauss_v)] }
    }

    fn error(&self) -> f64 {
        self.errors[0] + self.errors[1]
    }

    fn halves<S: ParametricSurface + ?Sized>(&self, surface: &S) -> [Self; 2] {
        let halves = |side: [f64; 2]| {
            let middle = 0.5 * (side[0] + side[1]);
            [[side[0], middle], [middle, side[1]]]
        };
        if self.errors[0] >= self.errors[1] {
            halves(self.u).map(|u| Self::new(surface, u, self.v))
        } else {
            halves(self.v).map(|v| Self::new(surface, self.u, v))
        }
    }
}

impl Eq for Cell {}

impl PartialOrd for Cell {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

/// By error, for the heap; the rest makes the order total, so that the result is always the same.
impl Ord for Cell {
    fn cmp(&self, other: &Self) -> Ordering {
        self.error()
            .total_cmp(&other.error())
            .then(other.u[0].total_cmp(&self.u[0]))
            .then(other.v[0].total_cmp(&self.v[0]))
    }
}

/// The area of a surface over its whole domain, to a relative tolerance such as
/// [`MEASURE_TOLERANCE`](crate::MEASURE_TOLERANCE).
///
/// Poles and collapsed edges need no care; points are counted as often as the surface covers them.
/// NaN when the surface is not finite.
pub fn area<S: ParametricSurface + ?Sized>(surface: &S, relative_tolerance: f64) -> Measure {
    let tolerance = attainable(relative_tolerance);
    let domain = surface.domain();
    let breaks = surface.breaks();
    let ends = |k: usize| {
        let mut ends = vec![domain[k].start()];
        ends.extend(&breaks[k]);
        ends.push(domain[k].end());
        ends
    };
    let (us, vs) = (ends(0), ends(1));
    let mut heap = BinaryHeap::new();
    for u in us.windows(2) {
        for v in vs.windows(2) {
            heap.push(Cell::new(surface, [u[0], u[1]], [v[0], v[1]]));
        }
    }
    let limit = MAX_CELLS.max(2 * heap.len());
    let mut total: f64 = heap.iter().map(|c| c.area).sum();
    let mut error: f64 = heap.iter().map(Cell::error).sum();
    let size = noise(
        us.iter().flat_map(|&u| vs.iter().map(move |&v| (u, v))).map(|(u, v)| surface.point(u, v).amax()),
    );
    // Rounding moves points by `size`, and thus areas by that times a length.
    while error > (tolerance * total).max(size * total.sqrt()).max(size * size) && heap.len() < limit {
        let Some(worst) = heap.pop() else { break };
        let halves = worst.halves(surface);
        total += halves[0].area + halves[1].area - worst.area;
        error += halves[0].error() + halves[1].error() - worst.error();
        heap.extend(halves);
    }
    let mut cells = heap.into_vec();
    cells.sort_by(|a, b| a.u[0].total_cmp(&b.u[0]).then(a.v[0].total_cmp(&b.v[0])));
    Measure { value: cells.iter().map(|c| c.area).sum(), error: cells.iter().map(Cell::error).sum() }
}
