//! Points on the edges of a part, shared by the faces on both sides.

use crate::description::EdgeCurve;
use crate::edge::Edge;
use crate::part::Part;
use nalgebra::Vector3;
use nurbs_core::ParametricCurve;
use std::f64::consts::TAU;

/// Halvings of a piece of an edge at most.
const MAX_DEPTH: u32 = 14;
/// Share of the chord tolerance that edges take.
const SHARE: f64 = 0.5;
/// Smallest share of an edge by which two of its points differ.
const APART: f64 = 1e-9;
/// Share of the size of an edge below which its bend does not matter.
const SMALL: f64 = 1e-7;
/// How many times farther from a vertex the points of an edge are than it is known where the edge ends.
const CLEAR: f64 = 4.0;

/// A point on an edge.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct EdgePoint {
    /// Parameter on the edge.
    pub(super) t: f64,
    /// Index of the vertex.
    pub(super) id: usize,
}

/// Points on all edges, with their vertices.
pub(super) struct EdgePoints {
    points: Vec<Vector3<f64>>,
    on: Vec<Vec<EdgePoint>>,
    /// For each edge the length up to which it misses its surfaces and its vertices.
    loose: Vec<f64>,
}

impl EdgePoints {
    /// Divides the edges so that their chords are within a share of the tolerance.
    pub(super) fn new(part: &Part, chord: f64) -> Self {
        let mut this = Self { points: part.vertices.clone(), on: Vec::new(), loose: Vec::new() };
        let mut placed = vec![false; part.vertices.len()];
        for edge in &part.edges {
            let ts = divided(edge, SHARE * chord);
            let last = ts.len() - 1;
            let mut on = Vec::with_capacity(ts.len());
            for (k, t) in ts.into_iter().enumerate() {
                let point = edge.curve.point(t);
                let end = (k == 0).then_some(0).or_else(|| (k == last).then_some(1));
                let id = match end.map(|end| edge.vertices[end]).filter(|id| *id < placed.len()) {
                    Some(id) => {
                        if !std::mem::replace(&mut placed[id], true) {
                            this.points[id] = point;
                        }
                        id
                    }
                    None => this.push(point),
                };
                on.push(EdgePoint { t, id });
            }
            this.on.push(on);
        }
        this.clear_vertices(part);
        this
    }

    /// Leaves out points that are as near to the vertex at an end of their edge as the edge misses it: the chord between them would
    /// lead back.
    fn clear_vertices(&mut self, part: &Part) {
        for (edge, on) in part.edges.iter().zip(&mut self.on) {
            let (Some(first), Some(last)) = (on.first().copied(), on.last().copied()) else {
                self.loose.push(edge.tolerance);
                continue;
            };
            let ends = [first, last].map(|end| self.points[end.id]);
            let miss = |k: usize| (edge.curve.point(edge.range[k]) - ends[k]).norm();
            let loose = edge.tolerance.max(miss(0)).max(miss(1));
            self.loose.push(loose);
            let is_clear = |p: &EdgePoint| {
                let point = self.points[p.id];
                ends.iter().all(|end| (point - end).norm() > CLEAR * loose)
            };
            let kept = on.iter().filter(|p| is_clear(p)).count();
            // A closed edge needs points of its own.
            if first.id != last.id || kept >= 2 {
                on.retain(|p| p.t == first.t || p.t == last.t || is_clear(p));
            }
        }
    }

    /// Distance up to which places that belong together may be apart.
    pub(super) fn slack(&self) -> f64 {
        CLEAR * self.loose.iter().copied().fold(0.0, f64::max)
    }

    /// Adds a point to an edge, unless its chord is as near to it as it is known, or a vertex is; whether it was added.
    pub(super) fn divide(&mut self, edges: &[Edge], edge: usize, t: f64) -> bool {
        let before = self.on[edge].len();
        let point = edges[edge].curve.point(t);
        let least = CLEAR * self.loose[edge].max(SMALL * edges[edge].bounds.diagonal());
        let place = self.on[edge].partition_point(|p| p.t < t);
        let around =
            [place.saturating_sub(1), place.min(before - 1)].map(|k| self.points[self.on[edge][k].id]);
        let along = (around[1] - around[0]).try_normalize(0.0).unwrap_or_else(Vector3::zeros);
        let off = point - around[0];
        let is_bent = (off - along * off.dot(&along)).norm() > least;
        let ends = [0, before - 1].map(|k| self.points[self.on[edge][k].id]);
        if is_bent && ends.iter().all(|end| (point - end).norm() > least) {
            self.add(edges, edge, t);
        }
        self.on[edge].len() > before
    }

    fn push(&mut self, point: Vector3<f64>) -> usize {
        self.points.push(point);
        self.points.len() - 1
    }

    /// The points of an edge in the order of their parameters.
    pub(super) fn of(&self, edge: usize) -> &[EdgePoint] {
        &self.on[edge]
    }

    /// Adds a point to an edge, unless there is one.
    pub(super) fn add(&mut self, edges: &[Edge], edge: usize, t: f64) {
        let [a, b] = edges[edge].range;
        let place = self.on[edge].partition_point(|p| p.t < t);
        let is_near = |p: &EdgePoint| (p.t - t).abs() <= APART * (b - a);
        let near = [place.checked_sub(1), Some(place)];
        if near.into_iter().flatten().filter_map(|k| self.on[edge].get(k)).any(is_near) {
            return;
        }
        let id = self.push(edges[edge].curve.point(t));
        self.on[edge].insert(place, EdgePoint { t, id });
    }

    /// Number of vertices on all edges.
    pub(super) fn count(&self) -> usize {
        self.points.len()
    }

    /// Position of a vertex.
    pub(super) fn point(&self, id: usize) -> Vector3<f64> {
        self.points[id]
    }

    /// The chords along an edge.
    pub(super) fn line(&self, edge: usize) -> Vec<Vector3<f64>> {
        self.on[edge].iter().map(|p| self.points[p.id]).collect()
    }

    /// All positions.
    pub(super) fn into_points(self) -> Vec<Vector3<f64>> {
        self.points
    }
}

/// Parameters of an edge, its ends included, between which the chords are within the tolerance.
fn divided(edge: &Edge, tolerance: f64) -> Vec<f64> {
    let [a, b] = edge.range;
    let mut stations = vec![a];
    match &edge.curve {
        EdgeCurve::Line { .. } => {}
        EdgeCurve::Circle { .. } | EdgeCurve::Ellipse { .. } => {
            // Never less than six chords for a turn: a closed edge has no other point than its end.
            let count = (6.0 * (b - a) / TAU).ceil().max(1.0);
            let mut k = 1.0;
            while k < count {
                stations.push(a + (b - a) * k / count);
                k += 1.0;
            }
        }
        EdgeCurve::Nurbs(spline) => {
            let breaks = spline.breaks();
            let inner = breaks.into_iter().filter(|t| *t > a && *t < b);
            for t in inner.chain([b]) {
                let from = stations.last().copied().unwrap_or(a);
                stations.push(from + (t - from) * 0.5);
                stations.push(t);
            }
            stations.pop();
        }
    }
    stations.push(b);
    let mut out = vec![a];
    for pair in stations.windows(2) {
        halve(&edge.curve, [pair[0], pair[1]], tolerance, MAX_DEPTH, &mut out);
    }
    out
}

/// Appends the parameters after the first up to the second.
fn halve(curve: &EdgeCurve, [a, b]: [f64; 2], tolerance: f64, depth: u32, out: &mut Vec<f64>) {
    let (start, end) = (curve.point(a), curve.point(b));
    let along = end - start;
    let off = |s: f64| {
        let d = curve.point(a + (b - a) * s) - start;
        let length = along.norm_squared();
        let foot = if length > 0.0 { (d.dot(&along) / length).clamp(0.0, 1.0) } else { 0.0 };
        (d - along * foot).norm()
    };
    let middle = 0.5 * (a + b);
    let is_near = [0.25, 0.5, 0.75].into_iter().all(|s| off(s) <= tolerance);
    if depth == 0 || is_near || matches!(curve, EdgeCurve::Line { .. }) || !(middle > a && middle < b) {
        out.push(b);
        return;
    }
    halve(curve, [a, middle], tolerance, depth - 1, out);
    halve(curve, [middle, b], tolerance, depth - 1, out);
}
