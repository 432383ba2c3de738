//! How far a fitted surface and the true one are apart, in both directions, by code that shares nothing with the fit.

use crate::truths::Truth;
use nalgebra::Vector3;
use serde_json::Value;
use std::collections::HashMap;

/// Allowed distance in spacings, and in standard deviations of the noise.
const NEAR: f64 = 3.0;
/// Samples of a fitted surface per direction, at most; per spacing.
const MOST: f64 = 700.0;
const PER_SPACING: f64 = 4.0;

/// A B-spline surface by its numbers, as its file has them.
pub(crate) struct Spline {
    degrees: [usize; 2],
    knots: [Vec<f64>; 2],
    controls: Vec<Vec<Vector3<f64>>>,
    /// Loops in the parameters that bound it; none for the whole surface.
    trim: Vec<Vec<[f64; 2]>>,
}

impl Spline {
    /// From NURBS JSON.
    pub(crate) fn read(text: &str) -> Option<Self> {
        let json: Value = serde_json::from_str(text).ok()?;
        let numbers =
            |value: &Value| value.as_array()?.iter().map(Value::as_f64).collect::<Option<Vec<f64>>>();
        let degree = |name: &str| json[name].as_u64().and_then(|p| usize::try_from(p).ok());
        let point = |value: &Value| numbers(value).map(|x| Vector3::new(x[0], x[1], x[2]));
        let row = |value: &Value| value.as_array()?.iter().map(point).collect::<Option<Vec<_>>>();
        let pair = |value: &Value| numbers(value).map(|x| [x[0], x[1]]);
        let boundary = |value: &Value| value.as_array()?.iter().map(pair).collect::<Option<Vec<_>>>();
        let trim = match json["trim"].as_array() {
            Some(loops) => loops.iter().map(boundary).collect::<Option<Vec<_>>>()?,
            None => Vec::new(),
        };
        Some(Self {
            degrees: [degree("degree_u")?, degree("degree_v")?],
            knots: [numbers(&json["knots_u"])?, numbers(&json["knots_v"])?],
            controls: json["control_points"].as_array()?.iter().map(row).collect::<Option<Vec<_>>>()?,
            trim,
        })
    }

    /// Places of one direction: a span, the weights of its control points, and the parameter.
    fn stations(&self, direction: usize, count: usize) -> Vec<(usize, Vec<f64>, f64)> {
        let (p, knots) = (self.degrees[direction], &self.knots[direction]);
        let controls = knots.len() - p - 1;
        let (low, high) = (knots[p], knots[controls]);
        let mut span = p;
        (0..=count)
            .map(|k| {
                let t = low + (high - low) * k as f64 / count as f64;
                while span + 1 < controls && knots[span + 1] <= t {
                    span += 1;
                }
                (span, weights(knots, p, span, t), t)
            })
            .collect()
    }

    /// Places all over what is bounded by the loops, closer than a distance if not too many.
    fn places(&self, spacing: f64) -> Vec<Vector3<f64>> {
        let lengths = [
            (0..self.controls[0].len())
                .map(|j| self.controls.windows(2).map(|r| (r[1][j] - r[0][j]).norm()).sum::<f64>())
                .fold(0.0, f64::max),
            self.controls
                .iter()
                .map(|row| row.windows(2).map(|p| (p[1] - p[0]).norm()).sum::<f64>())
                .fold(0.0, f64::max),
        ];
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped")]
        let counts = lengths.map(|l| (PER_SPACING * l / spacing).clamp(60.0, MOST) as usize);
        let [us, vs] = [0, 1].map(|d| self.stations(d, counts[d]));
        let mut out = Vec::new();
        for (span_u, weights_u, u) in &us {
            for (span_v, weights_v, v) in &vs {
                if !self.trim.is_empty() && !self.is_inside([*u, *v]) {
                    continue;
                }
                let mut place = Vector3::zeros();
                for (a, wu) in weights_u.iter().enumerate() {
                    for (b, wv) in weights_v.iter().enumerate() {
                        let control =
                            self.controls[span_u - self.degrees[0] + a][span_v - self.degrees[1] + b];
                        place += control * (wu * wv);
                    }
                }
                out.push(place);
            }
        }
        out
    }

    /// Whether an odd number of edges lies to the right of a place.
    fn is_inside(&self, [u, v]: [f64; 2]) -> bool {
        let mut inside = false;
        for boundary in &self.trim {
            for (k, a) in boundary.iter().enumerate() {
                let b = boundary[(k + 1) % boundary.len()];
                if (a[1] > v) != (b[1] > v) && u < a[0] + (v - a[1]) / (b[1] - a[1]) * (b[0] - a[0]) {
                    inside = !inside;
                }
            }
        }
        inside
    }
}

/// What the control points of a span weigh at a parameter, by the recursion of Cox and de Boor.
fn weights(knots: &[f64], p: usize, span: usize, t: f64) -> Vec<f64> {
    let mut found = vec![1.0];
    for r in 1..=p {
        let mut next = vec![0.0; r + 1];
        for (k, w) in found.iter().enumerate() {
            let i = span + k + 1 - r;
            let (low, high) = (knots[i], knots[i + r]);
            let share = if high > low { (t - low) / (high - low) } else { 0.0 };
            next[k] += w * (1.0 - share);
            next[k + 1] += w * share;
        }
        found = next;
    }
    found
}

/// Points in the cells of a grid, to find the nearest one of many by looking around.
struct Cells {
    size: f64,
    cells: HashMap<[i64; 3], Vec<Vector3<f64>>>,
}

impl Cells {
    fn new(points: &[Vector3<f64>], size: f64) -> Self {
        let mut cells: HashMap<[i64; 3], Vec<Vector3<f64>>> = HashMap::new();
        for p in points {
            cells.entry(Self::key(p, size)).or_default().push(*p);
        }
        Self { size, cells }
    }

    #[expect(clippy::cast_possible_truncation, reason = "small numbers of cells")]
    fn key(p: &Vector3<f64>, size: f64) -> [i64; 3] {
        [0, 1, 2].map(|k| (p[k] / size).floor() as i64)
    }

    /// Distance of the nearest point, or a lower bound of it beyond some cells.
    fn distance(&self, p: &Vector3<f64>) -> f64 {
        let [i, j, k] = Self::key(p, self.size);
        let mut best = f64::INFINITY;
        for reach in 0..12_i64 {
            for a in -reach..=reach {
                for b in -reach..=reach {
                    for c in -reach..=reach {
                        // What is nearer was looked at before.
                        if a.abs().max(b.abs()).max(c.abs()) == reach {
                            let found = self.cells.get(&[i + a, j + b, k + c]).into_iter().flatten();
                            best = found.map(|q| (q - p).norm()).fold(best, f64::min);
                        }
                    }
                }
            }
            if best <= self.size * reach as f64 {
                return best;
            }
        }
        best.min(11.0 * self.size)
    }
}

/// How far surface and truth are from each other: the surface from the truth, the truth from the surface, and what is allowed.
///
/// Allowed are three spacings of the points or three standard deviations of the noise; where random points happen to leave a larger hole, as far as
/// the truth in it is from them.
pub(crate) fn distance(truth: &Truth, points: &[Vector3<f64>], sigma: f64, fitted: &Spline) -> [f64; 3] {
    let spacing = (truth.area() / points.len() as f64).sqrt();
    let cell = 1.5 * spacing;
    let data = Cells::new(points, cell);
    let widest = truth.places.iter().step_by(5).map(|p| data.distance(p)).fold(0.0, f64::max);
    let allowed = (NEAR * sigma).max(NEAR * spacing).max(widest);
    let found = fitted.places(spacing);
    let (truths, surfaces) = (Cells::new(&truth.places, 0.5 * cell), Cells::new(&found, 0.5 * cell));
    let there = found.iter().step_by(3).map(|p| truths.distance(p)).fold(0.0, f64::max);
    let back = truth.places.iter().step_by(2).map(|p| surfaces.distance(p)).fold(0.0, f64::max);
    [there, back, allowed]
}
