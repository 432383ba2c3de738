//! Grids of samples and the surfaces through them.

use crate::curves::LayerCurve;
use crate::{AxisFrame, Error, parallel};
use nalgebra::{Vector2, Vector3};
use nurbs_core::{BsplineSurface, KnotVector, ParametricSurface};

/// A grid of places, closed in the first direction or not, and the bicubic surface through it.
#[derive(Clone, Debug, PartialEq)]
pub struct SampleGrid {
    /// Number of places in `u` and `v`.
    pub size: [usize; 2],
    /// The places, `u` outer.
    pub points: Vec<Vector3<f64>>,
    /// Whether `u` is closed; the first row is not repeated then.
    pub closed: bool,
}

impl SampleGrid {
    /// The parameters of the places: uniform, from 0 to 1.
    #[must_use]
    pub fn parameters(&self) -> [Vec<f64>; 2] {
        let [m, n] = self.size;
        let steps = if self.closed { m } else { m - 1 };
        [
            (0..m).map(|i| i as f64 / steps as f64).collect(),
            (0..n).map(|j| j as f64 / (n - 1) as f64).collect(),
        ]
    }

    /// The surface through the places: global interpolation with uniform parameters ([MPK, sec. 3.6], [PT97, A9.4]).
    ///
    /// # Errors
    /// [`Error::Nurbs`] for grids of fewer than four places in a direction, or places that are not finite.
    pub fn surface(&self) -> Result<BsplineSurface, Error> {
        let [u, v] = self.parameters();
        let knots_u = if self.closed {
            KnotVector::averaged_periodic(3, &u, 1.0)?
        } else {
            KnotVector::averaged(3, &u)?
        };
        Ok(BsplineSurface::interpolate_grid_at(
            [knots_u, KnotVector::averaged(3, &v)?],
            [&u, &v],
            &self.points,
        )?)
    }

    /// The places of a surface through a grid of this size, moved along its parameter lines to equal distances from each
    /// other: first in `v`, then in `u`. Ends in `v` stay where they are.
    pub(crate) fn equalised(&self, surface: &BsplineSurface) -> Self {
        let [u, v] = self.parameters();
        let [m, n] = self.size;
        let columns = parallel::map(m, |i| equal_steps(&|t| surface.point(u[i], t), n, n));
        let along = Self { points: columns.into_iter().flatten().map(|(_, p)| p).collect(), ..self.clone() };
        if !self.closed {
            return along;
        }
        // Curves through the new rows would be as good; those of the surface through all of them are at hand.
        let Ok(next) = along.surface() else { return self.clone() };
        let rows = parallel::map(n, |j| equal_steps(&|t| next.point(t, v[j]), m + 1, m));
        let points = (0..m * n).map(|k| rows[k % n][k / n].1).collect();
        Self { points, ..self.clone() }
    }

    /// Smooths the grid: every place is moved halfway to the middle of its neighbours, on the ends along these only.
    pub(crate) fn smoothed(&self) -> Self {
        self.smoothed_where(&vec![true; self.points.len()])
    }

    /// Smooths some places of the grid.
    pub(super) fn smoothed_where(&self, chosen: &[bool]) -> Self {
        let n = self.size[1];
        let mut smooth = self.clone();
        for (k, slot) in smooth.points.iter_mut().enumerate().filter(|(k, _)| chosen[*k]) {
            let (i, j) = (k / n, k % n);
            let Some([a, b]) = self.beside(i, j) else { continue };
            let middle = if j == 0 || j + 1 == n {
                (a + b) / 2.0
            } else {
                (a + b + self.at(i, j - 1) + self.at(i, j + 1)) / 4.0
            };
            *slot += (middle - *slot) / 2.0;
        }
        smooth
    }

    /// The place `(i, j)`; `i` wraps around where `u` is closed.
    pub(crate) fn at(&self, i: usize, j: usize) -> Vector3<f64> {
        self.points[(i % self.size[0]) * self.size[1] + j]
    }

    /// Neighbours in `u` of a place that is no end.
    pub(crate) fn beside(&self, i: usize, j: usize) -> Option<[Vector3<f64>; 2]> {
        let m = self.size[0];
        (self.closed || (i > 0 && i + 1 < m)).then(|| [self.at((i + m - 1) % m, j), self.at((i + 1) % m, j)])
    }
}

/// Samples per step by which a parameter line is measured.
const FINE: usize = 4;

/// The first `kept` of `count` places on a line over `[0, 1]` that are at equal distances along it, with their parameters.
fn equal_steps(line: &dyn Fn(f64) -> Vector3<f64>, count: usize, kept: usize) -> Vec<(f64, Vector3<f64>)> {
    let steps = FINE * (count - 1);
    let at = |k: usize| k as f64 / steps as f64;
    let fine: Vec<Vector3<f64>> = (0..=steps).map(|k| line(at(k))).collect();
    let mut lengths = vec![0.0];
    for pair in fine.windows(2) {
        lengths.push(lengths[lengths.len() - 1] + (pair[1] - pair[0]).norm());
    }
    let total = lengths[steps];
    let place = |i: usize| {
        let wanted = total * i as f64 / (count - 1) as f64;
        let after = lengths.partition_point(|&l| l < wanted).clamp(1, steps);
        let (a, b) = (lengths[after - 1], lengths[after]);
        let within = if b > a { ((wanted - a) / (b - a)).clamp(0.0, 1.0) } else { 0.0 };
        let t = at(after - 1) + within / steps as f64;
        (t, line(t))
    };
    (0..kept).map(place).collect()
}

/// The same number of samples from each curve, as many as the longest has, at equal lengths; every curve starts where it
/// lies best over the one before ([MPK, sec. 3.6]).
///
/// `heights` are the heights of the rows: those of layers without a curve are interpolated linearly between their neighbours,
/// those beyond the curves continued.
///
/// # Errors
/// [`Error::TooFewPoints`] for fewer than two curves.
pub fn grid_of_curves(
    frame: &AxisFrame,
    curves: &[LayerCurve],
    heights: &[f64],
    count: usize,
) -> Result<SampleGrid, Error> {
    if curves.len() < 2 {
        return Err(Error::TooFewPoints { total: curves.len(), usable: curves.len(), needed: 2 });
    }
    let middle = curves.len() / 2;
    let mut rings: Vec<Vec<Vector2<f64>>> = vec![Vec::new(); curves.len()];
    // The middle one starts in the direction of the first axis.
    let first = &curves[middle].curve;
    let start = (0..count)
        .map(|k| k as f64 / count as f64)
        .map(|share| (first.resampled(1, share)[0], share))
        .fold((f64::NEG_INFINITY, 0.0), |best, (p, share)| {
            if p.x - p.y.abs() > best.0 { (p.x - p.y.abs(), share) } else { best }
        });
    rings[middle] = first.resampled(count, start.1);
    for j in middle + 1..curves.len() {
        rings[j] = aligned(&curves[j], &rings[j - 1]);
    }
    for j in (0..middle).rev() {
        rings[j] = aligned(&curves[j], &rings[j + 1]);
    }
    let mut points = vec![Vector3::zeros(); count * heights.len()];
    for (row, &height) in heights.iter().enumerate() {
        let after = curves.partition_point(|c| c.height <= height).clamp(1, curves.len() - 1);
        let (a, b) = (&curves[after - 1], &curves[after]);
        let share = (height - a.height) / (b.height - a.height);
        for i in 0..count {
            let p = rings[after - 1][i] + (rings[after][i] - rings[after - 1][i]) * share;
            points[i * heights.len() + row] = frame.to_world(&Vector3::new(p.x, p.y, height));
        }
    }
    Ok(SampleGrid { size: [count, heights.len()], points, closed: true })
}

/// Samples of a curve from where they are nearest to those of another.
fn aligned(curve: &LayerCurve, other: &[Vector2<f64>]) -> Vec<Vector2<f64>> {
    let count = other.len();
    let cost = |samples: &[Vector2<f64>], shift: usize| {
        (0..count).map(|i| (samples[(i + shift) % count] - other[i]).norm_squared()).sum::<f64>()
    };
    let samples = curve.curve.resampled(count, 0.0);
    let costs: Vec<f64> = (0..count).map(|shift| cost(&samples, shift)).collect();
    let best = (0..count).fold(0, |best, k| if costs[k] < costs[best] { k } else { best });
    // The parabola through the three best shifts.
    let (a, b, c) = (costs[(best + count - 1) % count], costs[best], costs[(best + 1) % count]);
    let bend = a - 2.0 * b + c;
    let offset = if bend > 0.0 { 0.5 * (a - c) / bend } else { 0.0 };
    curve.curve.resampled(count, (best as f64 + offset) / count as f64)
}
