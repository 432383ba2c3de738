//! Edges in the parameter plane of a face.

use crate::carrier::Surface;
use crate::description::EdgeCurve;
use nalgebra::Vector2;
use nurbs_core::ParametricCurve;
use std::f64::consts::FRAC_PI_8;

/// Halvings of the pieces of an edge at most.
const MAX_HALVINGS: u32 = 12;

/// Pieces of a line, or of a span of a B-spline, before any is halved.
const PIECES: usize = 4;

/// Bend of a chord, as a share of its own length, up to which a piece is not halved.
const BEND: f64 = 0.05;

/// A piece of an edge whose image in the parameter plane lies close to its chord.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Chord {
    /// Parameters on the edge; the loop may run through them backwards.
    pub(crate) t: [f64; 2],
    /// Ends in the parameter plane.
    pub(crate) uv: [Vector2<f64>; 2],
    /// Lengths of the derivatives in `u` and `v` in the middle: parameters times these are lengths.
    pub(crate) scale: Vector2<f64>,
    /// Bound for the distance, as a length, between the image of the edge and the chord.
    pub(crate) bend: f64,
    /// Index among the uses of the face; `None` for a connection between uses, which is straight.
    pub(crate) owner: Option<usize>,
}

impl Chord {
    /// A straight connection.
    pub(crate) fn connection(from: Vector2<f64>, to: Vector2<f64>) -> Self {
        Self { t: [0.0; 2], uv: [from, to], scale: Vector2::repeat(1.0), bend: 0.0, owner: None }
    }
}

/// An edge that is traced on a surface.
pub(crate) struct Trace<'a> {
    pub(crate) surface: &'a Surface,
    pub(crate) curve: &'a EdgeCurve,
    pub(crate) owner: usize,
    /// Length below which a bend does not matter.
    pub(crate) fine: f64,
    /// Largest distance found between curve and surface.
    pub(crate) tolerance: f64,
    pub(crate) chords: Vec<Chord>,
}

/// Distance between two places of the parameter plane, as a length.
pub(crate) fn length(d: &Vector2<f64>, scale: &Vector2<f64>) -> f64 {
    (d.x * scale.x).hypot(d.y * scale.y)
}

impl Trace<'_> {
    /// Parameters, next to `hint`, of the place at `t`; at a pole the first parameter is that of the hint.
    fn at(&mut self, t: f64, hint: Option<&Vector2<f64>>) -> (Vector2<f64>, bool) {
        let x = self.curve.point(t);
        let found = self.surface.invert(&x, hint);
        self.tolerance = self.tolerance.max((self.surface.point(&found.at) - x).norm());
        (found.at, found.pole)
    }

    /// Traces the edge from one parameter to another. The first place is chosen next to `hint`.
    pub(crate) fn run(&mut self, from: f64, to: f64, hint: Option<&Vector2<f64>>) {
        let stations = stations(self.curve, from, to, self.surface.is_plane());
        let places: Vec<_> = {
            let mut last = hint.copied();
            stations
                .iter()
                .map(|&t| {
                    let (uv, pole) = self.at(t, last.as_ref());
                    if !pole {
                        last = Some(uv);
                    }
                    (uv, pole)
                })
                .collect()
        };
        for i in 1..stations.len() {
            let ((mut a, pole_a), (mut b, pole_b)) = (places[i - 1], places[i]);
            // The image of an edge into a pole ends at the parameter line on which it arrives.
            if pole_a || pole_b {
                let between = 0.5 * (stations[i - 1] + stations[i]);
                let close = |end: f64| end + (between - end) * 1e-3;
                if pole_a && !pole_b {
                    let (uv, _) = self.at(close(stations[i - 1]), Some(&b));
                    a = self.at_pole(&a, &uv);
                } else if pole_b && !pole_a {
                    let (uv, _) = self.at(close(stations[i]), Some(&a));
                    b = self.at_pole(&b, &uv);
                }
            }
            if let Some(end) = self.chords.last().map(|c| c.uv[1]).filter(|end| *end != a) {
                self.chords.push(Chord { owner: Some(self.owner), ..Chord::connection(end, a) });
            }
            self.halve([stations[i - 1], stations[i]], [a, b], 0);
        }
    }

    /// The pole, with the parameter that is free there taken from a place next to it.
    fn at_pole(&self, pole: &Vector2<f64>, beside: &Vector2<f64>) -> Vector2<f64> {
        let jet = self.surface.jet(pole);
        if jet.du.norm() <= jet.dv.norm() {
            Vector2::new(beside.x, pole.y)
        } else {
            Vector2::new(pole.x, beside.y)
        }
    }

    fn halve(&mut self, t: [f64; 2], uv: [Vector2<f64>; 2], depth: u32) {
        let lerp = |s: f64| uv[0] * (1.0 - s) + uv[1] * s;
        let place = |trace: &mut Self, s: f64| trace.at((1.0 - s) * t[0] + s * t[1], Some(&lerp(s))).0;
        let inner = [0.25, 0.5, 0.75].map(|s| (s, place(self, s)));
        let middle = inner[1].1;
        let jet = self.surface.jet(&middle);
        let scale = Vector2::new(jet.du.norm(), jet.dv.norm());
        let bend = inner.iter().map(|(_, p)| distance_to(&uv, p, &scale)).fold(0.0, f64::max);
        let size = length(&(uv[1] - uv[0]), &scale);
        if depth < MAX_HALVINGS && bend > self.fine && bend > BEND * size {
            let tm = 0.5 * (t[0] + t[1]);
            self.halve([t[0], tm], [uv[0], middle], depth + 1);
            self.halve([tm, t[1]], [middle, uv[1]], depth + 1);
            return;
        }
        // The bend is largest near the middle; the factor covers what lies between the places looked at.
        self.chords.push(Chord { t, uv, scale, bend: 1.5 * bend + 1e-15 * size, owner: Some(self.owner) });
    }
}

/// Distance of a place from a chord, as a length: from the nearest point of the chord.
pub(crate) fn distance_to(uv: &[Vector2<f64>; 2], p: &Vector2<f64>, scale: &Vector2<f64>) -> f64 {
    let (d, w) = ((uv[1] - uv[0]).component_mul(scale), (p - uv[0]).component_mul(scale));
    let squared = d.norm_squared();
    let s = if squared > 0.0 { (w.dot(&d) / squared).clamp(0.0, 1.0) } else { 0.0 };
    (w - d * s).norm()
}

/// Parameters between which a curve is smooth and turns little.
#[expect(clippy::cast_possible_truncation, reason = "a few pieces")]
fn stations(curve: &EdgeCurve, from: f64, to: f64, plane: bool) -> Vec<f64> {
    let (low, high) = (from.min(to), from.max(to));
    let mut breaks = vec![low];
    let pieces = match curve {
        EdgeCurve::Line { .. } if plane => 1,
        EdgeCurve::Line { .. } => PIECES,
        EdgeCurve::Circle { .. } | EdgeCurve::Ellipse { .. } => {
            // Seldom more than 16 for a whole turn.
            (((high - low) / FRAC_PI_8).ceil() as usize).clamp(1, 64)
        }
        EdgeCurve::Nurbs(curve) => {
            breaks.extend(curve.breaks().into_iter().filter(|b| *b > low && *b < high));
            PIECES
        }
    };
    breaks.push(high);
    let mut out = vec![low];
    for pair in breaks.windows(2) {
        for k in 1..=pieces {
            let s = k as f64 / pieces as f64;
            out.push(if k == pieces { pair[1] } else { (1.0 - s) * pair[0] + s * pair[1] });
        }
    }
    if from > to {
        out.reverse();
    }
    out
}
