//! The boundary of a face in its parameter plane, cut open where the parameters are periodic.

use super::edge_points::EdgePoints;
use crate::face::Face;
use crate::part::Part;
use nalgebra::Vector2;
use robust::{Coord, orient2d};

/// Share of a period within which a place counts as one on a cut.
const ON_CUT: f64 = 1e-9;
/// Share of a period that has to be free of edges for a cut that crosses none.
const FREE: f64 = 1e-3;
/// Halvings until an edge meets a cut.
const STEPS: usize = 60;

/// For each parameter of the plane of the chords the place at which a period begins; `None` where there is no period.
pub(super) type Cuts = [Option<Cut>; 2];

/// A line along which a face is cut open, and its copies a period apart.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cut {
    pub(super) at: f64,
    pub(super) period: f64,
}

/// A place on the boundary.
#[derive(Clone, Copy, Debug)]
pub(super) struct Place {
    pub(super) at: Vector2<f64>,
    pub(super) id: usize,
    /// Parameter and use of the edge that it lies on.
    pub(super) on: Option<(f64, usize)>,
}

impl Cut {
    /// How often the period fits between the cut and a value, and whether the value lies on a copy of the cut.
    fn copies(&self, value: f64) -> (f64, bool) {
        let turns = (value - self.at) / self.period;
        (turns, (turns - turns.round()).abs() < ON_CUT)
    }

    /// The value itself, or exactly that of the copy of the cut which it lies on.
    fn snapped(&self, value: f64) -> f64 {
        let (turns, is_on) = self.copies(value);
        if is_on { self.at + turns.round() * self.period } else { value }
    }

    /// The end of the period that begins at the cut.
    pub(super) fn end(&self) -> f64 {
        self.at + self.period
    }
}

/// Chooses the cuts of a face: where no edge is, if there is such a place, else as far as can be from ends of chords.
pub(super) fn cuts(part: &Part, face: &Face, points: &EdgePoints) -> Cuts {
    let loops = loops(part, face, points);
    [0, 1].map(|axis| {
        let period = face.boundary.period()[axis]?;
        let mut spans: Vec<[f64; 2]> = Vec::new();
        let mut ends: Vec<[f64; 2]> = Vec::new();
        for pair in loops.iter().flat_map(|places| places.windows(2)) {
            let (a, b) = (pair[0].at[axis], pair[1].at[axis]);
            let low = a.min(b).rem_euclid(period);
            let length = (a - b).abs().min(period);
            spans.push([low, low + length]);
            if low + length > period {
                spans.push([low - period, low + length - period]);
            }
            ends.push([a.rem_euclid(period); 2]);
        }
        let (free, width) = widest_gap(spans, period);
        let at = if width > FREE * period { free } else { widest_gap(ends, period).0 };
        Some(Cut { at, period })
    })
}

/// The middle of the widest gap between spans within a period, and its width.
fn widest_gap(mut spans: Vec<[f64; 2]>, period: f64) -> (f64, f64) {
    spans.sort_by(|a, b| a[0].total_cmp(&b[0]));
    let mut end = 0.0;
    let mut best = (0.5 * period, 0.0);
    for span in spans.iter().chain([&[period; 2]]) {
        let gap = span[0] - end;
        if gap > best.1 {
            best = (end + 0.5 * gap, gap);
        }
        end = f64::max(end, span[1]);
    }
    best
}

/// Adds points to the edges of a face where it is cut.
pub(super) fn divide(part: &Part, face: &Face, cuts: &Cuts, points: &mut EdgePoints) {
    for axis in 0..2 {
        let Some(cut) = cuts[axis] else { continue };
        let mut found = Vec::new();
        for pair in loops(part, face, points).iter().flat_map(|places| places.windows(2)) {
            let (Some((ta, use_a)), Some((tb, use_b))) = (pair[0].on, pair[1].on) else { continue };
            let ((a, on_a), (b, on_b)) = (cut.copies(pair[0].at[axis]), cut.copies(pair[1].at[axis]));
            let is_crossed = use_a == use_b && !on_a && !on_b && a.floor() != b.floor();
            if is_crossed {
                let level = cut.at + a.floor().max(b.floor()) * cut.period;
                let t = crossing(part, face, use_a, [(ta, pair[0].at), (tb, pair[1].at)], axis, level);
                found.push((face.boundary.uses[use_a].edge, t));
            }
        }
        for (edge, t) in found {
            points.add(&part.edges, edge, t);
        }
    }
}

/// Parameter of the edge at which it meets a line of the plane.
fn crossing(
    part: &Part,
    face: &Face,
    index: usize,
    ends: [(f64, Vector2<f64>); 2],
    axis: usize,
    level: f64,
) -> f64 {
    let edge = &part.edges[face.boundary.uses[index].edge];
    let [(mut ta, mut a), (mut tb, mut b)] = ends;
    for _ in 0..STEPS {
        let middle = 0.5 * (ta + tb);
        if middle == ta || middle == tb {
            break;
        }
        let at = face.boundary.place(&face.surface, edge, middle, &((a + b) * 0.5));
        if (at[axis] > level) == (a[axis] > level) {
            (ta, a) = (middle, at);
        } else {
            (tb, b) = (middle, at);
        }
    }
    0.5 * (ta + tb)
}

/// The loops of a face as places of the plane of the chords, each closed by a last place that is the first one, a period on
/// where it goes around.
pub(super) fn loops(part: &Part, face: &Face, points: &EdgePoints) -> Vec<Vec<Place>> {
    let boundary = &face.boundary;
    let mut out: Vec<Vec<Place>> = vec![Vec::new(); boundary.windings.len()];
    for (index, used) in boundary.uses.iter().enumerate() {
        let chords: Vec<_> = boundary.chords.iter().filter(|chord| chord.owner == Some(index)).collect();
        let (Some(first), Some(last)) = (chords.first(), chords.last()) else { continue };
        let edge = &part.edges[used.edge];
        let mut on = points.of(used.edge).to_vec();
        if !used.forward {
            on.reverse();
        }
        let end = on.len() - 1;
        let mut chord = 0;
        for (k, point) in on.iter().enumerate() {
            let at = if k == 0 {
                first.uv[0]
            } else if k == end {
                last.uv[1]
            } else {
                let is_past = |t: f64| if used.forward { point.t > t } else { point.t < t };
                while chord + 1 < chords.len() && is_past(chords[chord].t[1]) {
                    chord += 1;
                }
                let [t0, t1] = chords[chord].t;
                let share = ((point.t - t0) / (t1 - t0)).clamp(0.0, 1.0);
                let guess = chords[chord].uv[0].lerp(&chords[chord].uv[1], share);
                boundary.place(&face.surface, edge, point.t, &guess)
            };
            out[used.turn[0]].push(Place { at, id: point.id, on: Some((point.t, index)) });
        }
    }
    for (places, winding) in out.iter_mut().zip(&boundary.windings) {
        let Some(first) = places.first().copied() else { continue };
        let shift = Vector2::from_fn(|i, _| boundary.period()[i].map_or(0.0, |p| winding[i] as f64 * p));
        places.push(Place { at: first.at + shift, on: None, ..first });
    }
    out
}

/// The edge of a piece and the parameter in its middle; `None` for pieces that lie on no edge.
pub(super) fn middle(part: &Part, face: &Face, piece: &[Place; 2]) -> Option<(usize, f64)> {
    let (from, used) = piece[0].on?;
    let used_there = &face.boundary.uses[used];
    let end = part.edges[used_there.edge].range[usize::from(used_there.forward)];
    let to = piece[1].on.filter(|(_, other)| *other == used).map_or(end, |(t, _)| t);
    Some((used_there.edge, 0.5 * (from + to)))
}

/// Whether two pieces cross at a place that is an end of neither.
pub(super) fn cross(a: &[Place; 2], b: &[Place; 2]) -> bool {
    let coord = |p: &Place| Coord { x: p.at.x, y: p.at.y };
    let sides = |line: &[Place; 2], of: &[Place; 2]| {
        of.map(|p| orient2d(coord(&line[0]), coord(&line[1]), coord(&p)))
    };
    let apart = |s: [f64; 2]| s[0] * s[1] < 0.0;
    apart(sides(a, b)) && apart(sides(b, a))
}

/// The pieces of the loops within one period: pairs of places. Those on a cut lie exactly on it.
pub(super) fn pieces(loops: &[Vec<Place>], cuts: &Cuts) -> Vec<[Place; 2]> {
    let mut pieces: Vec<[Place; 2]> =
        loops.iter().flat_map(|places| places.windows(2)).map(|pair| [pair[0], pair[1]]).collect();
    for (axis, cut) in cuts.iter().enumerate().filter_map(|(axis, cut)| cut.map(|cut| (axis, cut))) {
        let mut within = Vec::with_capacity(pieces.len());
        for mut ends in pieces {
            for end in &mut ends {
                end.at[axis] = cut.snapped(end.at[axis]);
            }
            within.extend(parts(ends, axis, &cut).map(|part| moved(part, axis, &cut)));
        }
        pieces = within;
    }
    pieces
}

/// A piece divided at the copies of a cut that it crosses: edges have points there, but lines along a pole have not.
fn parts([a, b]: [Place; 2], axis: usize, cut: &Cut) -> impl Iterator<Item = [Place; 2]> {
    let (from, to) = (cut.copies(a.at[axis]).0, cut.copies(b.at[axis]).0);
    let (first, last) = (from.min(to).floor() + 1.0, from.max(to).ceil() - 1.0);
    let mut places = vec![a];
    let mut turn = first;
    // A piece goes around a few times at most.
    while turn <= last && places.len() < 8 {
        let share = (turn - from.min(to)) / (to - from).abs();
        let s = if to > from { share } else { 1.0 - share };
        let mut at = a.at.lerp(&b.at, s);
        at[axis] = cut.at + turn * cut.period;
        places.push(Place { at, id: if s < 0.5 { a.id } else { b.id }, on: None });
        turn += 1.0;
    }
    if to < from {
        places[1..].reverse();
    }
    places.push(b);
    let pairs: Vec<[Place; 2]> = places.windows(2).map(|pair| [pair[0], pair[1]]).collect();
    pairs.into_iter()
}

/// A piece in the period that begins at the cut.
fn moved(mut ends: [Place; 2], axis: usize, cut: &Cut) -> [Place; 2] {
    let middle = 0.5 * (ends[0].at[axis] + ends[1].at[axis]);
    let shift = ((middle - cut.at) / cut.period).floor() * cut.period;
    for end in &mut ends {
        let value = end.at[axis] - shift;
        // The copies of a cut differ by rounding.
        let on = [cut.at, cut.end()].into_iter().find(|on| (value - on).abs() < ON_CUT * cut.period);
        end.at[axis] = on.unwrap_or(value);
    }
    ends
}
