//! Windows: pieces of edges that straight paths from one vertex come over, and how they go on in the next triangle.

use crate::MetricMesh;
use mesh_core::HalfEdge;

/// Shortest window, as a share of its edge.
const SHORTEST: f64 = 1e-12;
/// Share by which a way over a vertex must be shorter for a window to be dropped: ways of equal length are both kept.
const SHORTER: f64 = 1e-12;

/// The part of an edge that is reached along straight lines from a vertex over unfolded triangles.
#[derive(Clone, Copy, Debug)]
pub(super) struct Window {
    /// The half-edge in the triangle that the lines go on into.
    pub(super) edge: HalfEdge,
    /// Where the window begins and ends along it.
    pub(super) span: [f64; 2],
    /// The vertex, unfolded: along the edge, and its distance from the line of the edge, which it lies behind.
    pub(super) source: [f64; 2],
    /// Distance of the vertex.
    pub(super) offset: f64,
}

impl Window {
    /// Distance from the source of the distances to a place of the edge.
    #[inline]
    pub(super) fn at(&self, place: f64) -> f64 {
        self.offset + (place - self.source[0]).hypot(self.source[1])
    }

    /// The shortest distance in the window.
    pub(super) fn least(&self) -> f64 {
        self.at(self.source[0].clamp(self.span[0], self.span[1].max(self.span[0])))
    }

    /// Where the line from the source to a point above the edge crosses it.
    pub(super) fn crossing(&self, [x, y]: [f64; 2]) -> f64 {
        let [u, v] = self.source;
        if v + y > 0.0 { u + (x - u) * v / (v + y) } else { x }
    }

    /// The window on the edge from the origin of this one to the apex: of the lines that cross this edge within a span.
    pub(super) fn left(&self, mesh: &MetricMesh, apex: [f64; 2], span: [f64; 2]) -> Option<Self> {
        let edge = self.edge.previous();
        let length = mesh.length(edge);
        let [x, y] = apex;
        if length <= 0.0 {
            return None;
        }
        // The frame of the edge from the origin to the apex.
        let (cosine, sine) = (x / length, y / length);
        let (u, v) = (self.source[0], -self.source[1]);
        let source = [u * cosine + v * sine, (u * sine - v * cosine).max(0.0)];
        let meet = |place: f64| {
            // From the source through the place, to the line of the edge.
            let (du, dv) = (place - u, -v);
            let across = du * sine - dv * cosine;
            let at = |t: f64| (u + t * du) * cosine + (v + t * dv) * sine;
            if across.abs() > 0.0 { at((v * cosine - u * sine) / across) } else { place * cosine }
        };
        let end = if span[1] >= self.crossing(apex) { length } else { meet(span[1]).clamp(0.0, length) };
        let start = meet(span[0]).clamp(0.0, end);
        Self { edge, span: [start, end], source, offset: self.offset }.on_other_side(mesh, length, false)
    }

    /// The window on the edge from the apex to the end of this one.
    pub(super) fn right(&self, mesh: &MetricMesh, apex: [f64; 2], span: [f64; 2]) -> Option<Self> {
        // As seen in a mirror, where this edge runs the other way.
        let whole = mesh.length(self.edge);
        let edge = self.edge.next();
        let length = mesh.length(edge);
        if length <= 0.0 {
            return None;
        }
        let (x, y) = (whole - apex[0], apex[1]);
        let (cosine, sine) = (x / length, y / length);
        let (u, v) = (whole - self.source[0], -self.source[1]);
        let source = [u * cosine + v * sine, (u * sine - v * cosine).max(0.0)];
        let meet = |place: f64| {
            let (du, dv) = (place - u, -v);
            let across = du * sine - dv * cosine;
            let at = |t: f64| (u + t * du) * cosine + (v + t * dv) * sine;
            if across.abs() > 0.0 { at((v * cosine - u * sine) / across) } else { place * cosine }
        };
        let end =
            if span[0] <= self.crossing(apex) { length } else { meet(whole - span[0]).clamp(0.0, length) };
        let start = meet(whole - span[1]).clamp(0.0, end);
        Self { edge, span: [start, end], source, offset: self.offset }.on_other_side(mesh, length, true)
    }

    /// The window as the triangle on the other side of its edge sees it; places were measured from the end that this edge shares
    /// with the one before. `None` at the boundary, and for windows without length.
    fn on_other_side(self, mesh: &MetricMesh, length: f64, mirrored: bool) -> Option<Self> {
        let [start, end] = self.span;
        let wide = end - start > SHORTEST * length;
        let edge = mesh.connectivity.twin(self.edge).filter(|_| wide)?;
        let (span, source) = if mirrored {
            ([length - end, length - start], [length - self.source[0], self.source[1]])
        } else {
            (self.span, self.source)
        };
        Some(Self { edge, span, source, offset: self.offset })
    }

    /// Whether ways over the ends of the edge, or over the vertex behind it, are shorter everywhere in the window
    /// (Xin and Wang's filter).
    pub(super) fn is_dominated(&self, mesh: &MetricMesh, distances: &[f64]) -> bool {
        let length = mesh.length(self.edge);
        let [start, end] = self.span;
        let (to_start, to_end) = (self.at(start), self.at(end));
        let known = |vertex: u32| distances[vertex as usize];
        let shorter = |way: f64, here: f64| way * (1.0 + SHORTER) < here;
        let (origin, target) = (mesh.connectivity.origin(self.edge), mesh.connectivity.target(self.edge));
        if shorter(known(origin) + end, to_end) || shorter(known(target) + length - start, to_start) {
            return true;
        }
        // The vertex behind the edge lies to one side of all lines: the far end counts.
        let Some(behind) = mesh.connectivity.twin(self.edge) else { return false };
        let apex = mesh.connectivity.origin(behind.previous());
        let [x, y] = mesh.apex(behind);
        let x = length - x;
        let from_apex = |place: f64| known(apex) + (place - x).hypot(y);
        shorter(from_apex(start), to_start) && shorter(from_apex(end), to_end)
    }
}
