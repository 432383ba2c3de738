//! Values on a grid in the plane: colours, isolines, regions that are filled, lines and points.

use crate::canvas::{Canvas, FINE, Raster, cover, from_segment, range};
use crate::colour::NOTHING;
use crate::mesh::lined;

/// A line over a field.
#[derive(Clone, Debug)]
pub struct Line {
    /// Its vertices, in the coordinates of the field.
    pub points: Vec<[f64; 2]>,
    /// Its colour.
    pub colour: [f32; 3],
    /// Its width in pixels.
    pub width: f64,
}

/// Values at the nodes of a grid, and what is drawn over them.
#[derive(Clone, Debug)]
pub struct FieldScene<'a> {
    /// Nodes along x and y.
    pub counts: [usize; 2],
    /// First and last node.
    pub bounds: [[f64; 2]; 2],
    /// Values `[i][j]` with `i` along x and `j` along y; what is not finite is grey.
    pub values: &'a [f64],
    /// What has the first and the last colour.
    pub range: [f64; 2],
    /// Steps between isolines; 0 draws none.
    pub lines: usize,
    /// Polygons that are filled.
    pub filled: &'a [Vec<[f64; 2]>],
    /// Lines over the field.
    pub curves: Vec<Line>,
    /// Points over the field, with colour and radius in pixels.
    pub points: Vec<([f64; 2], [f32; 3], f64)>,
}

/// Colour of what is filled.
const FILLED: [f32; 3] = [0.36, 0.38, 0.41];

impl FieldScene<'_> {
    /// Draws it, the longer side with `size` pixels.
    #[must_use]
    pub fn draw(&self, size: usize) -> Raster {
        let [low, high] = self.bounds;
        let sides = [high[0] - low[0], high[1] - low[1]];
        let longest = sides[0].max(sides[1]).max(f64::MIN_POSITIVE);
        let pixels = sides.map(|side| range(0.0, side / longest * size as f64 - 1.0, size).len().max(1));
        let mut canvas = Canvas::new(pixels[0], pixels[1]);
        let scale = [canvas.width as f64 / sides[0], canvas.height as f64 / sides[1]];
        let place = |p: [f64; 2]| [(p[0] - low[0]) * scale[0], (high[1] - p[1]) * scale[1]];
        for y in 0..canvas.height {
            for x in 0..canvas.width {
                let at = [low[0] + (x as f64 + 0.5) / scale[0], high[1] - (y as f64 + 0.5) / scale[1]];
                canvas.pixels[y * canvas.width + x] = if self.filled.iter().any(|loop_| is_within(loop_, at))
                {
                    FILLED
                } else {
                    match self.value(at) {
                        Some((value, gradient)) => {
                            let slope = (gradient[0] / scale[0]).hypot(gradient[1] / scale[1]);
                            lined(value, slope, self.range, self.lines)
                        }
                        None => NOTHING,
                    }
                };
            }
        }
        let fine = FINE as f64;
        let dots = self.points.iter().map(|(p, colour, radius)| ([*p, *p], *colour, *radius));
        let lines = self.curves.iter().flat_map(|line| {
            line.points.windows(2).map(|pair| ([pair[0], pair[1]], line.colour, 0.5 * line.width))
        });
        for (ends, colour, half) in lines.chain(dots) {
            let ([a, b], half) = (ends.map(place), half * fine);
            if a.iter().chain(&b).any(|c| !c.is_finite()) {
                continue;
            }
            for y in range(a[1].min(b[1]) - half - 1.0, a[1].max(b[1]) + half + 1.0, canvas.height) {
                for x in range(a[0].min(b[0]) - half - 1.0, a[0].max(b[0]) + half + 1.0, canvas.width) {
                    let (distance, _) = from_segment([x as f64 + 0.5, y as f64 + 0.5], a, b);
                    canvas.blend(x, y, colour, cover(distance, half));
                }
            }
        }
        canvas.finished()
    }

    /// The value between the nodes, bilinear, and its gradient; `None` where one of the nodes around has none.
    fn value(&self, at: [f64; 2]) -> Option<(f64, [f64; 2])> {
        let [low, high] = self.bounds;
        let mut cell = [0usize; 2];
        let mut share = [0.0; 2];
        let mut step = [0.0; 2];
        for d in 0..2 {
            let last = self.counts[d].checked_sub(1).filter(|last| *last > 0)?;
            step[d] = (high[d] - low[d]) / last as f64;
            let place = ((at[d] - low[d]) / step[d]).clamp(0.0, last as f64);
            cell[d] = range(place, place, last).start.min(last - 1);
            share[d] = place - cell[d] as f64;
        }
        let node =
            |i: usize, j: usize| self.values.get((cell[0] + i) * self.counts[1] + cell[1] + j).copied();
        let (a, b, c, d) = (node(0, 0)?, node(1, 0)?, node(0, 1)?, node(1, 1)?);
        let [s, t] = share;
        let value = (a * (1.0 - s) + b * s) * (1.0 - t) + (c * (1.0 - s) + d * s) * t;
        let x = ((b - a) * (1.0 - t) + (d - c) * t) / step[0];
        let y = ((c - a) * (1.0 - s) + (d - b) * s) / step[1];
        value.is_finite().then_some((value, [x, y]))
    }
}

/// Whether a point is inside of a polygon, by the crossings of a ray.
fn is_within(polygon: &[[f64; 2]], p: [f64; 2]) -> bool {
    let mut inside = false;
    for (k, a) in polygon.iter().enumerate() {
        let b = polygon[(k + 1) % polygon.len()];
        if (a[1] > p[1]) != (b[1] > p[1]) && p[0] < a[0] + (b[0] - a[0]) * (p[1] - a[1]) / (b[1] - a[1]) {
            inside = !inside;
        }
    }
    inside
}
