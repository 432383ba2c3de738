//! The boundary of a face in its parameter plane, and on which side of it a place lies.
//!
//! Loops are traced with continuous parameters, so that a loop around a periodic carrier ends a period away from its
//! start. Whether a place is inside is decided by the parity of the crossings of all loops, in all their copies, with a
//! path from the place to where the answer is known: far out on planes, cylinders and cones; the end of the second
//! parameter, which may be a pole, on spheres and closed B-splines; a fixed place on tori. The number of crossings with a
//! chord is exact; a chord whose edge may pass on the other side of the place is halved until that is settled.

use crate::carrier::Surface;
use crate::edge::Edge;
use crate::trace::{Chord, Trace, distance_to, length};
use nalgebra::Vector2;
use robust::{Coord, orient2d};

/// Halvings of a chord at most.
const MAX_DEPTH: u32 = 24;

/// Share of a period by which a place on a seam is moved.
const NUDGE: f64 = 1e-8;

/// Share of a period within which a place counts as one on the line where a loop around the carrier is closed.
const CLOSURE: f64 = 1e-12;

/// Where a place of the parameter plane lies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Inside {
    In,
    Out,
    /// Closer to the edge of the use with this index than the edge is known.
    Near(usize),
}

/// An edge as part of the boundary.
#[derive(Clone, Debug)]
pub(crate) struct Use {
    /// Index of the edge in the part.
    pub(crate) edge: usize,
    pub(crate) forward: bool,
    /// Largest distance between the edge and the carrier.
    pub(crate) tolerance: f64,
    /// The face lies on both sides of it.
    pub(crate) seam: bool,
    /// Loop and place in the loop.
    pub(crate) turn: [usize; 2],
}

/// What is known about a place of the parameter plane.
#[derive(Clone, Copy, Debug)]
enum Known {
    /// Beyond the largest second parameter.
    Top(bool),
    /// At the start of the line with this second parameter; the crossings of the loops with it are sorted.
    Line(f64, bool),
}

/// The loops of a face.
#[derive(Clone, Debug)]
pub(crate) struct Boundary {
    /// Chords, their two parameters exchanged if `swap` is set.
    pub(crate) chords: Vec<Chord>,
    pub(crate) uses: Vec<Use>,
    /// Periods run through by each loop.
    pub(crate) windings: Vec<[i64; 2]>,
    pub(crate) swap: bool,
    period: [Option<f64>; 2],
    /// First parameters at which loops around the carrier close.
    closures: Vec<f64>,
    /// First parameters of the crossings with the line of [`Known::Line`], within one period.
    crossings: Vec<f64>,
    known: Known,
    /// Length below which nothing is told apart.
    floor: f64,
}

/// A loop of edges as the description has it: index of the edge and whether it is run through forwards.
pub(crate) type Turns<'a> = &'a [(usize, bool)];

pub(crate) fn flip(p: Vector2<f64>) -> Vector2<f64> {
    Vector2::new(p.y, p.x)
}

impl Boundary {
    /// Traces the loops. `size` is the size of the model, `outwards` whether the face has the sense of its carrier.
    pub(crate) fn trace(
        surface: &Surface,
        edges: &[Edge],
        loops: &[Vec<(usize, bool)>],
        size: f64,
        same_sense: bool,
    ) -> Self {
        let floor = 1e-11 * size;
        let swap = surface.period[1].is_some() && surface.period[0].is_none();
        let mut this = Self {
            chords: Vec::new(),
            uses: Vec::new(),
            windings: Vec::new(),
            swap,
            period: if swap { [surface.period[1], surface.period[0]] } else { surface.period },
            closures: Vec::new(),
            crossings: Vec::new(),
            known: Known::Top(false),
            floor,
        };
        for (index, turns) in loops.iter().enumerate() {
            this.add_loop(surface, edges, index, turns);
        }
        let edges_used: Vec<usize> = this.uses.iter().map(|u| u.edge).collect();
        for u in &mut this.uses {
            u.seam = edges_used.iter().filter(|e| **e == u.edge).count() > 1;
        }
        if swap {
            for chord in &mut this.chords {
                chord.uv = chord.uv.map(flip);
                chord.scale = flip(chord.scale);
            }
            this.windings.iter_mut().for_each(|w| w.swap(0, 1));
        }
        this.orient(surface, edges, same_sense);
        this
    }

    fn add_loop(&mut self, surface: &Surface, edges: &[Edge], index: usize, turns: Turns<'_>) {
        let first = self.chords.len();
        let mut hint: Option<Vector2<f64>> = None;
        for (place, &(edge, forward)) in turns.iter().enumerate() {
            let (curve, [a, b]) = (&edges[edge].curve, edges[edge].range);
            let owner = self.uses.len();
            let mut trace =
                Trace { surface, curve, owner, fine: self.floor, tolerance: 0.0, chords: Vec::new() };
            let (from, to) = if forward { (a, b) } else { (b, a) };
            trace.run(from, to, hint.as_ref());
            let (tolerance, mut chords) = (trace.tolerance, trace.chords);
            // An edge that starts at a pole has no parameter of its own there; it was moved next to the hint.
            if let (Some(end), Some(start)) = (hint, chords.first().map(|c| c.uv[0])) {
                let moved = surface.next_to(&start, &end) - start;
                if moved != Vector2::zeros() {
                    chords.iter_mut().for_each(|c| c.uv = c.uv.map(|p| p + moved));
                }
                let start = start + moved;
                if start != end {
                    self.chords.push(Chord::connection(end, start));
                }
            }
            hint = chords.last().map(|c| c.uv[1]).or(hint);
            self.chords.append(&mut chords);
            self.uses.push(Use { edge, forward, tolerance, seam: false, turn: [index, place] });
        }
        let (Some(start), Some(end)) = (self.chords.get(first).map(|c| c.uv[0]), hint) else {
            self.windings.push([0, 0]);
            return;
        };
        let target = surface.next_to(&start, &end);
        let winding = [0, 1].map(|i| match surface.period[i] {
            #[expect(clippy::cast_possible_truncation, reason = "a few turns")]
            Some(period) => ((target[i] - start[i]) / period).round() as i64,
            None => 0,
        });
        if end != target {
            self.chords.push(Chord::connection(end, target));
        }
        for (i, turns) in winding.into_iter().enumerate() {
            if turns != 0 && (i == 1) == self.swap {
                self.closures.push(start[i]);
            }
        }
        self.windings.push(winding);
    }

    /// Finds out what is known about the end of the path.
    fn orient(&mut self, surface: &Surface, edges: &[Edge], same_sense: bool) {
        if self.chords.is_empty() {
            self.known = Known::Top(true);
            return;
        }
        if self.period[1].is_some() {
            let line = self.free_line();
            self.crossings = self.line_crossings(surface, edges, line);
            self.known = Known::Line(line, false);
        } else if surface.unbounded() || !self.ends_in_pole(surface) {
            return;
        }
        // The face lies on the left of its loops, seen against its normal.
        let mut votes = 0.0;
        let flip_side = same_sense == self.swap;
        for chord in &self.chords {
            let Some(owner) = chord.owner.filter(|o| !self.uses[*o].seam) else { continue };
            let d = (chord.uv[1] - chord.uv[0]).component_mul(&chord.scale);
            let size = d.norm();
            let offset = (4.0 * (chord.bend + self.uses[owner].tolerance)).max(1e-4 * size);
            if !(size > 0.0 && offset < size) {
                continue;
            }
            let left = Vector2::new(-d.y, d.x) * (if flip_side { -offset } else { offset } / size);
            let left = left.component_div(&chord.scale);
            if !left.iter().all(|c| c.is_finite()) {
                continue;
            }
            let (inside, _) = self.parity(surface, edges, &((chord.uv[0] + chord.uv[1]) * 0.5 + left));
            votes += if inside { size } else { -size };
        }
        if votes < 0.0 {
            self.known = match self.known {
                Known::Top(_) => Known::Top(true),
                Known::Line(line, _) => Known::Line(line, true),
            };
        }
    }

    /// Whether the end of the second parameter, towards which paths lead, is one point of the carrier.
    fn ends_in_pole(&self, surface: &Surface) -> bool {
        match surface.spline() {
            None => true,
            Some(spline) => spline.has_pole(usize::from(!self.swap)),
        }
    }

    /// A second parameter on which no chord ends: the middle of the largest gap.
    fn free_line(&self) -> f64 {
        let period = self.period[1].unwrap_or(1.0);
        let mut ends: Vec<f64> =
            self.chords.iter().flat_map(|c| c.uv).map(|p| p.y.rem_euclid(period)).collect();
        ends.sort_by(f64::total_cmp);
        let first = ends.first().copied().unwrap_or(0.0);
        ends.push(first + period);
        let widest = ends.windows(2).max_by(|a, b| (a[1] - a[0]).total_cmp(&(b[1] - b[0])));
        widest.map_or(0.0, |w| 0.5 * (w[0] + w[1]))
    }

    /// First parameters, within one period, at which loops cross a line.
    fn line_crossings(&self, surface: &Surface, edges: &[Edge], line: f64) -> Vec<f64> {
        let [width, height] = self.period.map(|p| p.unwrap_or(1.0));
        let mut out = Vec::new();
        for chord in &self.chords {
            let low = chord.uv[0].y.min(chord.uv[1].y);
            let high = chord.uv[0].y.max(chord.uv[1].y);
            let mut level = line + ((low - line) / height).ceil() * height;
            while level <= high {
                let above = |p: &Vector2<f64>| p.y > level;
                if above(&chord.uv[0]) != above(&chord.uv[1]) {
                    let (mut t, mut uv) = (chord.t, chord.uv);
                    for _ in 0..60 {
                        let s = (level - uv[0].y) / (uv[1].y - uv[0].y);
                        let chordwise = uv[0] + (uv[1] - uv[0]) * s;
                        let Some(owner) = chord.owner else { break };
                        if length(&(uv[1] - uv[0]), &chord.scale) <= self.floor {
                            break;
                        }
                        let middle = 0.5 * (t[0] + t[1]);
                        let p = self.place(surface, &edges[self.uses[owner].edge], middle, &chordwise);
                        let half = usize::from(above(&p) == above(&uv[1]));
                        (t[half], uv[half]) = (middle, p);
                    }
                    let s = (level - uv[0].y) / (uv[1].y - uv[0].y);
                    out.push((uv[0].x + (uv[1].x - uv[0].x) * s).rem_euclid(width));
                }
                level += height;
            }
        }
        out.sort_by(f64::total_cmp);
        out
    }

    /// The periods in the plane of the chords.
    pub(crate) fn period(&self) -> [Option<f64>; 2] {
        self.period
    }

    /// The place of an edge in the plane of the chords, next to another one.
    pub(crate) fn place(
        &self,
        surface: &Surface,
        edge: &Edge,
        t: f64,
        next_to: &Vector2<f64>,
    ) -> Vector2<f64> {
        let hint = if self.swap { flip(*next_to) } else { *next_to };
        let found = surface.invert(&edge.curve.point(t), Some(&hint)).at;
        if self.swap { flip(found) } else { found }
    }

    /// Where a place of the parameter plane of the carrier lies.
    pub(crate) fn inside(&self, surface: &Surface, edges: &[Edge], uv: &Vector2<f64>) -> Inside {
        if self.chords.is_empty() {
            return Inside::In;
        }
        let mut p = if self.swap { flip(*uv) } else { *uv };
        let step = self.period[0].map_or_else(|| self.floor, |period| NUDGE * period);
        // On a line where the face goes on, a place beside it tells as much.
        for _ in 0..8 {
            let (inside, near) = self.parity(surface, edges, &p);
            match near {
                Some(owner) if self.uses[owner].seam => p += Vector2::new(step, 0.37 * step),
                Some(owner) => return Inside::Near(owner),
                None if inside => return Inside::In,
                None => return Inside::Out,
            }
        }
        Inside::Out
    }

    /// Whether the path from a place crosses the loops so that it is inside, and the use of an edge that is too close
    /// for a certain answer.
    fn parity(&self, surface: &Surface, edges: &[Edge], p: &Vector2<f64>) -> (bool, Option<usize>) {
        let mut p = *p;
        if let Some(period) = self.period[0] {
            // Where a loop closes a period away, rounding could let a path slip through.
            for closure in &self.closures {
                let off = (p.x - closure) / period;
                if (off - off.round()).abs() < CLOSURE {
                    p.x += 4.0 * CLOSURE * period;
                }
            }
        }
        let mut near: Option<(usize, f64)> = None;
        let top = match (self.known, self.period[1]) {
            (Known::Line(line, _), Some(height)) => Some(line + ((p.y - line) / height).ceil() * height),
            _ => None,
        };
        let walk = Walk { boundary: self, surface, edges };
        let mut odd = false;
        for chord in &self.chords {
            let [a, b] = chord.uv;
            let mut margin = chord.margin();
            for (m, period) in margin.iter_mut().zip(self.period) {
                // No edge goes further round than a whole turn between the ends of a chord.
                *m = period.map_or(*m, |period| m.min(period));
            }
            let shifts = |low: f64, high: f64, at: [f64; 2], period: Option<f64>| match period {
                Some(period) => ((low - at[1]) / period).ceil()..=((high - at[0]) / period).floor(),
                None => 0.0..=0.0,
            };
            let us = shifts(a.x.min(b.x) - margin.x, a.x.max(b.x) + margin.x, [p.x; 2], self.period[0]);
            let end = top.unwrap_or(p.y);
            let vs = shifts(a.y.min(b.y) - margin.y, a.y.max(b.y) + margin.y, [p.y, end], self.period[1]);
            let mut k = *us.start();
            while k <= *us.end() {
                let mut m = *vs.start();
                while m <= *vs.end() {
                    let shift = Vector2::new(
                        self.period[0].map_or(0.0, |period| k * period),
                        self.period[1].map_or(0.0, |period| m * period),
                    );
                    odd ^= walk.above(chord, &(p + shift), 0, &mut near);
                    if let Some(top) = top {
                        odd ^= walk.above(chord, &(Vector2::new(p.x, top) + shift), 0, &mut None);
                    }
                    m += 1.0;
                }
                k += 1.0;
            }
        }
        let known = match self.known {
            Known::Top(inside) => inside,
            Known::Line(_, inside) => {
                let x = p.x.rem_euclid(self.period[0].unwrap_or(1.0));
                inside ^ (self.crossings.iter().filter(|c| **c <= x).count() % 2 == 1)
            }
        };
        (odd ^ known, near.map(|n| n.0))
    }

    /// Whether the ends of the second parameter belong to the face, first and last.
    pub(crate) fn ends_inside(&self) -> [bool; 2] {
        let turns: i64 = self.windings.iter().map(|w| w[0]).sum();
        match self.known {
            Known::Top(top) => [top ^ (turns.rem_euclid(2) == 1), top],
            Known::Line(_, inside) => [inside; 2],
        }
    }

    /// Box of the chords in the parameter plane of the carrier, and for each parameter whether the face may go all round.
    pub(crate) fn extent(&self) -> Option<([Vector2<f64>; 2], [bool; 2])> {
        let first = self.chords.first()?.uv[0];
        let (mut low, mut high) = (first, first);
        for chord in &self.chords {
            let margin = chord.margin();
            for p in chord.uv {
                low = low.inf(&(p - margin));
                high = high.sup(&(p + margin));
            }
        }
        let mut round = [0, 1].map(|i| self.windings.iter().any(|w| w[i] != 0));
        if self.period[1].is_some()
            && (self.ends_inside()[0] || round[0] || round[1] || !self.crossings.is_empty())
        {
            round = [true; 2];
        }
        let [bottom, top] = self.ends_inside();
        round[0] |= self.period[1].is_none() && (bottom || top);
        Some(if self.swap { ([flip(low), flip(high)], [round[1], round[0]]) } else { ([low, high], round) })
    }
}

impl Chord {
    /// How far, in parameters, the edge may be away from the chord.
    pub(crate) fn margin(&self) -> Vector2<f64> {
        self.scale
            .map(|s| if self.bend > 0.0 { self.bend / s.max(f64::MIN_POSITIVE) } else { 0.0 })
            .map(|m| m.min(1e6))
    }
}

/// A path upwards that meets chords.
struct Walk<'a> {
    boundary: &'a Boundary,
    surface: &'a Surface,
    edges: &'a [Edge],
}

impl Walk<'_> {
    /// Whether the edge of a chord is crossed an odd number of times by the path upwards from a place.
    fn above(&self, chord: &Chord, p: &Vector2<f64>, depth: u32, near: &mut Option<(usize, f64)>) -> bool {
        let [a, b] = chord.uv;
        let astride = (a.x <= p.x) != (b.x <= p.x);
        let margin = chord.margin();
        let strip = chord.owner.map_or(0.0, |o| self.boundary.uses[o].tolerance) + self.boundary.floor;
        let reach = margin + chord.scale.map(|s| (strip / s.max(f64::MIN_POSITIVE)).min(1e6));
        if p.y > a.y.max(b.y) + reach.y {
            return false;
        }
        if p.y < a.y.min(b.y) - reach.y {
            return astride;
        }
        if p.x < a.x.min(b.x) - reach.x || p.x > a.x.max(b.x) + reach.x {
            return false;
        }
        let by_chord = || astride && below(&a, &b, p);
        let distance = distance_to(&chord.uv, p, &chord.scale);
        if distance > chord.bend + strip {
            return by_chord();
        }
        let Some(owner) = chord.owner else { return by_chord() };
        if chord.bend <= strip || depth >= MAX_DEPTH {
            if near.is_none_or(|(_, d)| distance < d) {
                *near = Some((owner, distance));
            }
            return by_chord();
        }
        let edge = &self.edges[self.boundary.uses[owner].edge];
        let lerp = |s: f64| a * (1.0 - s) + b * s;
        let place = |s: f64, hint: &Vector2<f64>| {
            let t = (1.0 - s) * chord.t[0] + s * chord.t[1];
            (t, self.boundary.place(self.surface, edge, t, hint))
        };
        let (tm, middle) = place(0.5, &lerp(0.5));
        let (_, first) = place(0.25, &((a + middle) * 0.5));
        let (_, second) = place(0.75, &((b + middle) * 0.5));
        let half = |t: [f64; 2], uv: [Vector2<f64>; 2], inner: &Vector2<f64>| {
            let bend = 1.5 * distance_to(&uv, inner, &chord.scale);
            Chord { t, uv, bend: bend.max(0.125 * chord.bend).min(chord.bend), ..*chord }
        };
        let low = half([chord.t[0], tm], [a, middle], &first);
        let high = half([tm, chord.t[1]], [middle, b], &second);
        self.above(&low, p, depth + 1, near) ^ self.above(&high, p, depth + 1, near)
    }
}

/// Whether a place is below a chord that it is under, exactly.
fn below(a: &Vector2<f64>, b: &Vector2<f64>, p: &Vector2<f64>) -> bool {
    let c = |q: &Vector2<f64>| Coord { x: q.x, y: q.y };
    let (left, right) = if a.x <= b.x { (a, b) } else { (b, a) };
    orient2d(c(left), c(right), c(p)) < 0.0
}
