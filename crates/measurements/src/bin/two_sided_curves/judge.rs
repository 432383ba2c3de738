//! How far a fitted curve and the true one are apart, in both directions, by code that shares nothing with the fit.

use crate::truths::Truth;
use nalgebra::Vector2;
use std::collections::HashMap;

/// Samples of a fitted curve per span at least, and chords per distance that is allowed.
const PER_SPAN: usize = 60;
const PER_ALLOWED: f64 = 20.0;
/// Allowed distance in spacings, and in standard deviations of the noise.
const NEAR: f64 = 3.0;

/// A B-spline curve by its numbers, the control points that repeat included.
pub(crate) struct Spline {
    pub(crate) degree: usize,
    pub(crate) knots: Vec<f64>,
    pub(crate) controls: Vec<Vector2<f64>>,
}

impl Spline {
    /// The point at a parameter, by the triangle of de Boor.
    fn point(&self, span: usize, t: f64) -> Vector2<f64> {
        let p = self.degree;
        let mut d: Vec<Vector2<f64>> = self.controls[span - p..=span].to_vec();
        for r in 1..=p {
            for j in (r..=p).rev() {
                let i = span - p + j;
                let (low, high) = (self.knots[i], self.knots[i + p + 1 - r]);
                let share = if high > low { (t - low) / (high - low) } else { 0.0 };
                d[j] = d[j - 1] * (1.0 - share) + d[j] * share;
            }
        }
        d[p]
    }

    /// Places along the curve that are no further apart than a distance, unless it is very fast somewhere.
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a positive number of chords"
    )]
    fn places(&self, apart: f64) -> Vec<Vector2<f64>> {
        let mut out = Vec::new();
        for span in self.degree..self.controls.len() {
            let (low, high) = (self.knots[span], self.knots[span + 1]);
            if high > low {
                let sampled = |count: usize| {
                    let at = move |k: usize| low + (high - low) * k as f64 / count as f64;
                    (0..=count).map(move |k| self.point(span, at(k)))
                };
                let coarse: Vec<Vector2<f64>> = sampled(PER_SPAN).collect();
                let widest = coarse.windows(2).map(|p| (p[1] - p[0]).norm()).fold(0.0, f64::max);
                let finer = (widest / apart).ceil().clamp(1.0, 100.0) as usize;
                out.extend(sampled(finer * PER_SPAN));
            }
        }
        out
    }
}

/// Points in the cells of a grid, to find the nearest one of many by looking around.
struct Cells {
    size: f64,
    cells: HashMap<[i64; 2], Vec<Vector2<f64>>>,
}

impl Cells {
    fn new(points: impl Iterator<Item = Vector2<f64>>, size: f64) -> Self {
        let mut cells: HashMap<[i64; 2], Vec<Vector2<f64>>> = HashMap::new();
        for p in points {
            cells.entry(Self::key(&p, size)).or_default().push(p);
        }
        Self { size, cells }
    }

    #[expect(clippy::cast_possible_truncation, reason = "small numbers of cells")]
    fn key(p: &Vector2<f64>, size: f64) -> [i64; 2] {
        [(p.x / size).floor() as i64, (p.y / size).floor() as i64]
    }

    /// Distance of the nearest point, or a lower bound of it beyond some cells.
    fn distance(&self, p: &Vector2<f64>) -> f64 {
        let [i, j] = Self::key(p, self.size);
        for reach in 1..40_i64 {
            let mut best = f64::INFINITY;
            for a in -reach..=reach {
                for b in -reach..=reach {
                    let found = self.cells.get(&[i + a, j + b]).into_iter().flatten();
                    best = found.map(|q| (q - p).norm()).fold(best, f64::min);
                }
            }
            if best <= self.size * reach as f64 {
                return best;
            }
        }
        39.0 * self.size
    }
}

/// How far curves and the truth are apart: the places of the curves furthest from the truth or the points, and of the truth from the curves.
pub(crate) struct Apart {
    beyond: (f64, Vector2<f64>),
    missing: (f64, Vector2<f64>),
    pub(crate) allowed: f64,
}

impl Apart {
    /// In both directions.
    pub(crate) fn most(&self) -> f64 {
        self.beyond.0.max(self.missing.0)
    }
}

impl std::fmt::Display for Apart {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let [(beyond, a), (missing, b)] = [self.beyond, self.missing];
        write!(
            f,
            "curve {beyond:.3} off at ({:.2}, {:.2}), truth {missing:.3} off at ({:.2}, {:.2}), of {:.3}",
            a.x, a.y, b.x, b.y, self.allowed
        )
    }
}

/// The largest distance between fitted curves and the truth, in both directions, and what is allowed.
///
/// The curve may be near the truth or near the points: where parts of the truth cross or run into each other, points of one are near the other.
///
/// Allowed are three spacings of the points or three standard deviations of the noise; where random points happen to leave a larger hole, as far as the
/// truth in it is from them, and three standard deviations, by which the last of them may be off.
pub(crate) fn distance(truth: &Truth, points: &[Vector2<f64>], sigma: f64, fitted: &[Spline]) -> Apart {
    let spacing = truth.length() / points.len() as f64;
    let cell = (0.02 * truth.size()).max(2.0 * spacing);
    let all = || truth.pieces.iter().flatten().copied();
    let data = Cells::new(points.iter().copied(), cell);
    let widest = all().map(|p| data.distance(&p)).fold(0.0, f64::max);
    let allowed = (NEAR * sigma).max(NEAR * spacing).max(widest + NEAR * sigma);
    let found: Vec<Vector2<f64>> = fitted.iter().flat_map(|s| s.places(allowed / PER_ALLOWED)).collect();
    let (truths, curves) = (Cells::new(all(), cell), Cells::new(found.iter().copied(), cell));
    Apart {
        beyond: farthest(found.iter().map(|p| (truths.distance(p).min(data.distance(p)), *p))),
        missing: farthest(all().map(|p| (curves.distance(&p), p))),
        allowed,
    }
}

fn farthest(places: impl Iterator<Item = (f64, Vector2<f64>)>) -> (f64, Vector2<f64>) {
    places.fold((0.0, Vector2::zeros()), |most, one| if one.0 > most.0 { one } else { most })
}
