//! The picture of a field: colours, isolines, obstacles, ways and a scale. Of a field in space the middle section is shown.

use super::PathResult;
use crate::error::Error;
use crate::on_surface::picture::write_sheet;
use crate::report::Report;
use industrial_geometry::distance_field::grid::Lattice;
use industrial_geometry::picture::{FieldScene, Line, Sheet};
use std::path::Path;

/// Pixels of the longer side.
const SIZE: usize = 900;
/// Isolines.
const LINES: usize = 20;
/// Steps of the zero level along a side of a cell.
const ZERO: f64 = 2.5;
/// Colour and width of ways and of the zero level; radius of the ends of ways.
const WAY: [f32; 3] = [0.85, 0.11, 0.38];
const WIDTH: f64 = 3.0;
const END: f64 = 5.0;

pub(super) use crate::on_surface::picture::check;

/// A section of a field: values `[i][j]` with `i` along x and `j` along y.
struct Section {
    counts: [usize; 2],
    bounds: [[f64; 2]; 2],
    values: Vec<f64>,
}

impl Section {
    fn of<const D: usize>(lattice: &Lattice<D>, values: &[f64]) -> Self {
        let counts = lattice.counts();
        let middle = if D == 3 { counts[2] / 2 } else { 0 };
        let step = if D == 3 { counts[2] } else { 1 };
        let values = (0..counts[0] * counts[1]).map(|place| values[place * step + middle]).collect();
        let (low, high) = (lattice.low(), lattice.high());
        Self { counts: [counts[0], counts[1]], bounds: [[low[0], low[1]], [high[0], high[1]]], values }
    }

    /// Where a level crosses the cells.
    fn level(&self, level: f64) -> Vec<Line> {
        let [low, high] = self.bounds;
        let [m, n] = self.counts;
        let place = |i: f64, j: f64| {
            let share = [i / (m - 1) as f64, j / (n - 1) as f64];
            [0, 1].map(|d| low[d] + (high[d] - low[d]) * share[d])
        };
        let mut lines = Vec::new();
        for i in 0..m - 1 {
            for j in 0..n - 1 {
                let corners = [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)];
                let values = corners.map(|(i, j)| self.values[i * n + j]);
                if !values.iter().all(|value| value.is_finite()) {
                    continue;
                }
                let mut cuts = Vec::new();
                for k in 0..4 {
                    let (a, b) = (values[k], values[(k + 1) % 4]);
                    if (a < level) != (b < level) {
                        let share = (level - a) / (b - a);
                        let ((i0, j0), (i1, j1)) = (corners[k], corners[(k + 1) % 4]);
                        let between =
                            |from: usize, to: usize| from as f64 + share * (to as f64 - from as f64);
                        cuts.push(place(between(i0, i1), between(j0, j1)));
                    }
                }
                let pairs = cuts.chunks_exact(2);
                lines.extend(pairs.map(|pair| Line { points: pair.to_vec(), colour: WAY, width: ZERO }));
            }
        }
        lines
    }
}

/// Draws a field and writes the picture.
pub(super) fn write<const D: usize>(
    path: &Path,
    lattice: &Lattice<D>,
    values: &[f64],
    obstacles: &[Vec<[f64; 2]>],
    paths: &[PathResult],
    report: &mut Report,
) -> Result<(), Error> {
    let mut section = Section::of(lattice, values);
    if !obstacles.is_empty() {
        // Nodes inside of obstacles have no value: under their polygons, those around them are continued.
        fill(&mut section);
    }
    let finite = section.values.iter().copied().filter(|value| value.is_finite());
    let (min, max) = finite.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(v), b.max(v)));
    let range = if max > min { [min, max] } else { [0.0, 1.0] };
    let zero = if min < 0.0 && max > 0.0 { section.level(0.0) } else { Vec::new() };
    let ways = paths.iter().map(|way| Line { points: way.points.clone(), colour: WAY, width: WIDTH });
    let scene = FieldScene {
        counts: section.counts,
        bounds: section.bounds,
        values: &section.values,
        range,
        lines: LINES,
        filled: obstacles,
        curves: zero.into_iter().chain(ways).collect(),
        points: paths.iter().map(|way| (way.target, WAY, END)).collect(),
    };
    let sheet = Sheet::new().with("", scene.draw(SIZE)).with_bar(range);
    write_sheet(path, &sheet, "picture", report)
}

/// Gives nodes inside of obstacles the mean of those around them that have a value, two layers deep, so that colours reach the borders.
fn fill(section: &mut Section) {
    let [m, n] = section.counts;
    for value in section.values.iter_mut().filter(|value| **value < 0.0) {
        *value = f64::NAN;
    }
    for _ in 0..2 {
        let before = section.values.clone();
        for i in 0..m {
            for j in 0..n {
                if before[i * n + j].is_nan() {
                    let rows = i.saturating_sub(1)..(i + 2).min(m);
                    let around =
                        rows.flat_map(|k| (j.saturating_sub(1)..(j + 2).min(n)).map(move |l| k * n + l));
                    let known: Vec<f64> =
                        around.map(|k| before[k]).filter(|value| value.is_finite()).collect();
                    if !known.is_empty() {
                        section.values[i * n + j] = known.iter().sum::<f64>() / known.len() as f64;
                    }
                }
            }
        }
    }
}
