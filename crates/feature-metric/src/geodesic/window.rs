//! Windows: pieces of edges that straight paths from one vertex come over, and how they go on in the next triangle.

use super::sides::{Number, Sides, next, previous};

/// Shortest window, as a share of its edge.
const SHORTEST: f64 = 1e-12;
/// Share by which a way over a vertex must be shorter for a window to be dropped: ways of equal length are both kept.
const SHORTER: f64 = 1e-12;

/// The part of an edge that is reached along straight lines from a vertex over unfolded triangles.
#[derive(Clone, Copy, Debug)]
pub(super) struct Window {
    /// The half-edge in the triangle that the lines go on into.
    pub(super) edge: Number,
    /// Where the window begins and ends along it.
    pub(super) span: [f64; 2],
    /// The vertex, unfolded: along the edge, and its distance from the line of the edge, which it lies behind.
    pub(super) source: [f64; 2],
    /// Distance of the vertex.
    pub(super) offset: f64,
}

/// Length of a vector; the lengths of a mesh are bounded so that their squares are numbers.
#[inline]
pub(super) fn length_of(x: f64, y: f64) -> f64 {
    (x * x + y * y).sqrt()
}

impl Window {
    /// Distance from the source of the distances to a place of the edge.
    #[inline]
    pub(super) fn at(&self, place: f64) -> f64 {
        self.offset + length_of(place - self.source[0], self.source[1])
    }

    /// The shortest distance in the window.
    #[inline]
    pub(super) fn least(&self) -> f64 {
        self.at(self.source[0].clamp(self.span[0], self.span[1].max(self.span[0])))
    }

    /// Where the line from the source to a point above the edge crosses it.
    #[inline]
    pub(super) fn crossing(&self, [x, y]: [f64; 2]) -> f64 {
        let [u, v] = self.source;
        if v + y > 0.0 { u + (x - u) * v / (v + y) } else { x }
    }

    /// The window on the edge from the origin of this one to the apex: of the lines that cross this edge within a span.
    pub(super) fn left(&self, sides: &Sides, span: [f64; 2], crossing: f64) -> Option<Self> {
        let side = sides.get(self.edge);
        let edge = sides.twin(previous(self.edge))?;
        let length = sides.get(previous(self.edge)).length;
        let reaches = span[1] >= crossing;
        let (span, source) = turned(length, side.apex, self.source, span, reaches)?;
        Some(Self { edge, span, source, offset: self.offset })
    }

    /// The window on the edge from the apex to the end of this one.
    pub(super) fn right(&self, sides: &Sides, span: [f64; 2], crossing: f64) -> Option<Self> {
        // As seen in a mirror, where this edge runs the other way.
        let side = sides.get(self.edge);
        let edge = sides.twin(next(self.edge))?;
        let length = sides.get(next(self.edge)).length;
        let whole = side.length;
        let mirrored = |[x, y]: [f64; 2]| [whole - x, y];
        let reaches = span[0] <= crossing;
        let flipped = [whole - span[1], whole - span[0]];
        let (span, source) = turned(length, mirrored(side.apex), mirrored(self.source), flipped, reaches)?;
        let (span, source) = ([length - span[1], length - span[0]], [length - source[0], source[1]]);
        Some(Self { edge, span, source, offset: self.offset })
    }

    /// Whether ways over the ends of the edge, or over the vertex behind it, are shorter everywhere in the window
    /// (Xin and Wang's filter).
    pub(super) fn is_dominated(&self, sides: &Sides, distances: &[f64]) -> bool {
        let side = sides.get(self.edge);
        let [start, end] = self.span;
        let (to_start, to_end) = (self.at(start), self.at(end));
        let known = |vertex: u32| distances[vertex as usize];
        let shorter = |way: f64, here: f64| way * (1.0 + SHORTER) < here;
        if shorter(known(side.origin) + end, to_end)
            || shorter(known(sides.target(self.edge)) + side.length - start, to_start)
        {
            return true;
        }
        // The vertex behind the edge lies to one side of all lines: the far end counts.
        let Some(behind) = sides.twin(self.edge) else { return false };
        let apex = known(sides.opposite(behind));
        let [x, y] = sides.get(behind).apex;
        let x = side.length - x;
        shorter(apex + length_of(start - x, y), to_start) && shorter(apex + length_of(end - x, y), to_end)
    }
}

/// Lines over a span of an edge on the edge of some length from its origin to the apex, as the triangle behind that one sees them: their
/// span, which ends at the apex where it `reaches` that, and their source. `None` for windows without length.
#[inline]
fn turned(
    length: f64,
    [x, y]: [f64; 2],
    [u, v]: [f64; 2],
    [first, last]: [f64; 2],
    reaches: bool,
) -> Option<([f64; 2], [f64; 2])> {
    if length <= 0.0 {
        return None;
    }
    // The frame of the edge from the origin to the apex.
    let (cosine, sine) = (x / length, y / length);
    let source = [u * cosine - v * sine, (u * sine + v * cosine).max(0.0)];
    let meet = |place: f64| {
        // From the source through the place, to the line of the edge.
        let across = (place - u) * sine - v * cosine;
        let t = -(v * cosine + u * sine) / across;
        if across.abs() > 0.0 {
            (u + t * (place - u)) * cosine + (t - 1.0) * v * sine
        } else {
            place * cosine
        }
    };
    let end = if reaches { length } else { meet(last).clamp(0.0, length) };
    let start = if first <= 0.0 { 0.0 } else { meet(first).clamp(0.0, end) };
    (end - start > SHORTEST * length).then_some(([start, end], source))
}
