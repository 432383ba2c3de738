//! The picture of a field: colours, isolines, obstacles, ways and a scale. Of a field in space the middle section is shown.

use super::PathResult;
use crate::error::Error;
use crate::files;
use industrial_geometry::distance_field::grid::Lattice;
use std::fmt::Write;
use std::path::Path;

/// Width and height of the longer side, in pixels.
const SIZE: f64 = 720.0;
/// Free space around, and for the scale.
const MARGIN: f64 = 30.0;
const SCALE: f64 = 110.0;
/// Isolines.
const LINES: usize = 20;
/// Most cells along a side that are coloured one by one.
const CELLS: usize = 180;

/// Makes sure that the picture can have its format.
pub(super) fn check(path: &Path) -> Result<(), Error> {
    if files::extension(path) == "svg" || files::is_stream(path) {
        return Ok(());
    }
    Err(Error::content(path, "pictures of fields are SVG", "choose a name that ends in .svg"))
}

/// A section of a field: values `[i][j]` with `i` along x and `j` along y.
struct Section {
    counts: [usize; 2],
    low: [f64; 2],
    high: [f64; 2],
    values: Vec<f64>,
}

impl Section {
    fn of<const D: usize>(lattice: &Lattice<D>, values: &[f64]) -> Self {
        let counts = lattice.counts();
        let middle = if D == 3 { counts[2] / 2 } else { 0 };
        let step = if D == 3 { counts[2] } else { 1 };
        let values = (0..counts[0] * counts[1]).map(|place| values[place * step + middle]).collect();
        let (low, high) = (lattice.low(), lattice.high());
        Self { counts: [counts[0], counts[1]], low: [low[0], low[1]], high: [high[0], high[1]], values }
    }

    fn at(&self, i: usize, j: usize) -> f64 {
        self.values[i * self.counts[1] + j]
    }

    fn x(&self, i: f64) -> f64 {
        self.low[0] + (self.high[0] - self.low[0]) * i / (self.counts[0] - 1) as f64
    }

    fn y(&self, j: f64) -> f64 {
        self.low[1] + (self.high[1] - self.low[1]) * j / (self.counts[1] - 1) as f64
    }
}

/// Draws a field.
pub(super) fn draw<const D: usize>(
    lattice: &Lattice<D>,
    values: &[f64],
    obstacles: &[Vec<[f64; 2]>],
    paths: &[PathResult],
) -> String {
    let section = Section::of(lattice, values);
    let is_value = |value: f64| value.is_finite() && (obstacles.is_empty() || value >= 0.0);
    let shown = section.values.iter().copied().filter(|value| is_value(*value));
    let (min, max) = shown.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(v), b.max(v)));
    let (min, max) = if max > min { (min, max) } else { (0.0, 1.0) };
    let sides = [section.high[0] - section.low[0], section.high[1] - section.low[1]];
    let zoom = SIZE / sides[0].max(sides[1]);
    let place =
        |[x, y]: [f64; 2]| [MARGIN + (x - section.low[0]) * zoom, MARGIN + (section.high[1] - y) * zoom];
    let (width, height) = (sides[0] * zoom + 2.0 * MARGIN + SCALE, sides[1] * zoom + 2.0 * MARGIN);
    let mut out = String::new();
    // Writing to memory cannot fail.
    let _ = write!(
        out,
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width:.1} {height:.1}\" font-family=\"sans-serif\" font-size=\"13\">\n\
         <rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n<g shape-rendering=\"crispEdges\">\n"
    );
    let steps = section.counts.map(|count| (count - 1).div_ceil(CELLS).max(1));
    for i in (0..section.counts[0] - 1).step_by(steps[0]) {
        for j in (0..section.counts[1] - 1).step_by(steps[1]) {
            let [k, l] =
                [(i + steps[0]).min(section.counts[0] - 1), (j + steps[1]).min(section.counts[1] - 1)];
            let corners = [section.at(i, j), section.at(k, j), section.at(i, l), section.at(k, l)];
            let known: Vec<f64> = corners.into_iter().filter(|value| is_value(*value)).collect();
            if known.is_empty() {
                continue;
            }
            let value = known.iter().sum::<f64>() / known.len() as f64;
            let [x0, y1] = place([section.x(i as f64), section.y(j as f64)]);
            let [x1, y0] = place([section.x(k as f64), section.y(l as f64)]);
            let [r, g, b] = colour((value - min) / (max - min));
            let _ = writeln!(
                out,
                "<rect x=\"{x0:.2}\" y=\"{y0:.2}\" width=\"{:.2}\" height=\"{:.2}\" fill=\"#{r:02x}{g:02x}{b:02x}\"/>",
                x1 - x0,
                y1 - y0
            );
        }
    }
    out.push_str("</g>\n");
    for obstacle in obstacles {
        let points: Vec<String> =
            obstacle.iter().map(|p| place(*p)).map(|[x, y]| format!("{x:.2},{y:.2}")).collect();
        let _ = writeln!(out, "<polygon points=\"{}\" fill=\"#5b6168\"/>", points.join(" "));
    }
    for line in 1..LINES {
        let level = min + (max - min) * line as f64 / LINES as f64;
        isoline(&mut out, &section, level, &is_value, &place, "#1b1f24", 0.7);
    }
    if min < 0.0 && max > 0.0 {
        isoline(&mut out, &section, 0.0, &is_value, &place, "#c2185b", 2.0);
    }
    for path in paths {
        let points: Vec<String> =
            path.points.iter().map(|p| place(*p)).map(|[x, y]| format!("{x:.2},{y:.2}")).collect();
        let _ = writeln!(
            out,
            "<polyline points=\"{}\" fill=\"none\" stroke=\"#d81b60\" stroke-width=\"2.5\"/>",
            points.join(" ")
        );
        let [x, y] = place(path.target);
        let _ = writeln!(out, "<circle cx=\"{x:.2}\" cy=\"{y:.2}\" r=\"4\" fill=\"#d81b60\"/>");
    }
    scale(&mut out, [min, max], width - SCALE, height);
    out.push_str("</svg>\n");
    out
}

/// One level, cell by cell.
fn isoline(
    out: &mut String,
    section: &Section,
    level: f64,
    is_value: &dyn Fn(f64) -> bool,
    place: &dyn Fn([f64; 2]) -> [f64; 2],
    stroke: &str,
    width: f64,
) {
    let _ = write!(out, "<path fill=\"none\" stroke=\"{stroke}\" stroke-width=\"{width}\" d=\"");
    for i in 0..section.counts[0] - 1 {
        for j in 0..section.counts[1] - 1 {
            let corners = [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)];
            let values = corners.map(|(i, j)| section.at(i, j));
            if !values.iter().all(|value| is_value(*value)) {
                continue;
            }
            let mut cuts = Vec::new();
            for k in 0..4 {
                let (a, b) = (values[k], values[(k + 1) % 4]);
                if (a < level) != (b < level) {
                    let share = (level - a) / (b - a);
                    let ((i0, j0), (i1, j1)) = (corners[k], corners[(k + 1) % 4]);
                    let between = |from: usize, to: usize| from as f64 + share * (to as f64 - from as f64);
                    cuts.push(place([section.x(between(i0, i1)), section.y(between(j0, j1))]));
                }
            }
            for pair in cuts.chunks_exact(2) {
                let [[x0, y0], [x1, y1]] = [pair[0], pair[1]];
                let _ = write!(out, "M{x0:.2} {y0:.2}L{x1:.2} {y1:.2}");
            }
        }
    }
    out.push_str("\"/>\n");
}

/// A bar of colours with its numbers.
fn scale(out: &mut String, [min, max]: [f64; 2], left: f64, height: f64) {
    let tall = height - 2.0 * MARGIN;
    for k in 0..60 {
        let [r, g, b] = colour((f64::from(k) + 0.5) / 60.0);
        let y = MARGIN + tall * (1.0 - f64::from(k + 1) / 60.0);
        let _ = writeln!(
            out,
            "<rect x=\"{left:.1}\" y=\"{y:.2}\" width=\"18\" height=\"{:.2}\" fill=\"#{r:02x}{g:02x}{b:02x}\"/>",
            tall / 60.0 + 0.5
        );
    }
    for k in 0..=4 {
        let share = f64::from(k) / 4.0;
        let y = MARGIN + tall * (1.0 - share) + 4.0;
        let value = min + (max - min) * share;
        let _ = writeln!(out, "<text x=\"{:.1}\" y=\"{y:.1}\">{value:.4}</text>", left + 24.0);
    }
}

/// From dark blue over green to yellow (anchors of viridis).
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "between 0 and 255, and an index of an anchor"
)]
fn colour(share: f64) -> [u8; 3] {
    const ANCHORS: [[f64; 3]; 6] = [
        [68.0, 1.0, 84.0],
        [65.0, 68.0, 135.0],
        [42.0, 120.0, 142.0],
        [34.0, 168.0, 132.0],
        [122.0, 209.0, 81.0],
        [253.0, 231.0, 37.0],
    ];
    let at = share.clamp(0.0, 1.0) * (ANCHORS.len() - 1) as f64;
    let first = (at as usize).min(ANCHORS.len() - 2);
    let rest = at - first as f64;
    [0, 1, 2].map(|k| (ANCHORS[first][k] + rest * (ANCHORS[first + 1][k] - ANCHORS[first][k])).round() as u8)
}
