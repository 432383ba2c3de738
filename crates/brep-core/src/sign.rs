//! Sides of the surface at feet on faces, edges and vertices.
//!
//! At an edge between two faces the sum of their normals decides, at a vertex the sum of the normals of all faces around
//! it, each weighted with its angle (J. A. Bærentzen, H. Aanæs, Signed distance computation using the angle weighted
//! pseudonormal, IEEE TVCG 11, 2005): for a closed surface the sign is exact.

use crate::foot::Side;
use crate::part::Part;
use nalgebra::{Vector2, Vector3};
use std::f64::consts::TAU;

/// Cosine between offset and pseudo-normal below which the side is left open.
const UNDECIDED: f64 = 1e-6;

/// Angle below which a corner counts as a cusp.
const CUSP: f64 = 1e-6;

/// Sides of a foot.
pub(crate) struct Sides {
    pub(crate) side: Side,
    pub(crate) normal: Vector3<f64>,
    /// The foot lies on the boundary of an open shell.
    pub(crate) open: bool,
    pub(crate) face: Option<usize>,
}

/// The side to which an offset from the foot points.
pub(crate) fn side(offset: &Vector3<f64>, normal: &Vector3<f64>) -> Side {
    let (along, length) = (offset.dot(normal), offset.norm());
    // NaN is on no side either.
    let is_decided = along.abs() > UNDECIDED * length;
    if !is_decided {
        Side::Undecided
    } else if along > 0.0 {
        Side::Positive
    } else {
        Side::Negative
    }
}

impl Part {
    /// Normal of a face at a point of one of its edges.
    pub(crate) fn normal_at(
        &self,
        face: usize,
        use_index: usize,
        t: f64,
        point: &Vector3<f64>,
    ) -> Vector3<f64> {
        let f = &self.faces[face];
        let chords = f.boundary.chords.iter().filter(|c| c.owner == Some(use_index));
        let near = chords.min_by(|a, b| {
            let off = |c: &crate::trace::Chord| (0.5 * (c.t[0] + c.t[1]) - t).abs();
            off(a).total_cmp(&off(b))
        });
        let hint = near.map(|c| {
            let p = (c.uv[0] + c.uv[1]) * 0.5;
            if f.boundary.swap { Vector2::new(p.y, p.x) } else { p }
        });
        let uv = f.surface.invert(point, hint.as_ref()).at;
        f.normal([uv.x, uv.y])
    }

    pub(crate) fn edge_sides(&self, edge: usize, t: f64, offset: &Vector3<f64>) -> Sides {
        let e = &self.edges[edge];
        let point = e.curve.point(t);
        let normals: Vec<_> =
            e.uses.iter().map(|[face, u]| (*face, self.normal_at(*face, *u, t, &point))).collect();
        let sum: Vector3<f64> = normals.iter().map(|n| n.1).sum();
        let face = normals
            .iter()
            .max_by(|a, b| {
                // Of the faces the one that the point sees best; the first of equals.
                offset.dot(&a.1).abs().total_cmp(&offset.dot(&b.1).abs()).then(b.0.cmp(&a.0))
            })
            .map(|n| n.0);
        // More than two faces at an edge bound nothing that has an inside.
        let (open, decided) = (e.uses.len() < 2, matches!(e.uses.len(), 1 | 2));
        let normal = sum.try_normalize(1e-9).unwrap_or_else(Vector3::zeros);
        let side = if decided { side(offset, &normal) } else { Side::Undecided };
        Sides { side, normal, open, face }
    }

    pub(crate) fn vertex_sides(&self, vertex: usize, edge: usize, offset: &Vector3<f64>) -> Sides {
        let point = self.vertices[vertex];
        let mut sum = Vector3::zeros();
        let (mut open, mut broken) = (false, false);
        let mut faces = Vec::new();
        for &e in &self.stars[vertex] {
            // A closed surface has two faces at each edge.
            open |= self.edges[e].uses.len() < 2;
            broken |= self.edges[e].uses.len() > 2;
            for &[face, u] in &self.edges[e].uses {
                let this = &self.faces[face].boundary.uses[u];
                let end = self.edges[e].vertices[usize::from(this.forward)];
                if end != vertex {
                    continue;
                }
                // The corner between this use, which arrives, and the next one of its loop.
                let uses = &self.faces[face].boundary.uses;
                let [turn, place] = this.turn;
                let next = uses
                    .iter()
                    .find(|n| n.turn == [turn, place + 1])
                    .or_else(|| uses.iter().find(|n| n.turn == [turn, 0]));
                let Some(next) = next else { continue };
                // Vertices at one place that are not shared: the faces around cannot be told.
                broken |= self.edges[next.edge].vertices[usize::from(!next.forward)] != vertex;
                let t = self.edges[e].range[usize::from(this.forward)];
                let normal = self.normal_at(face, u, t, &point);
                let back = -self.tangent(e, this.forward, true);
                let onwards = self.tangent(next.edge, next.forward, false);
                let angle = normal.dot(&onwards.cross(&back)).atan2(onwards.dot(&back)).rem_euclid(TAU);
                // Edges that leave in one direction make a cusp, not a slit.
                let angle = if angle > TAU - CUSP { 0.0 } else { angle };
                sum += normal * angle;
                faces.push((face, normal));
            }
        }
        let face = faces
            .iter()
            .max_by(|a, b| offset.dot(&a.1).abs().total_cmp(&offset.dot(&b.1).abs()).then(b.0.cmp(&a.0)))
            .map(|f| f.0)
            .or_else(|| self.edges[edge].uses.first().map(|u| u[0]));
        let normal = sum.try_normalize(1e-9).unwrap_or_else(Vector3::zeros);
        let side = if broken { Side::Undecided } else { side(offset, &normal) };
        Sides { side, normal, open, face }
    }

    /// Unit tangent, in the direction of the loop, where it leaves the start or arrives at the end of a use.
    fn tangent(&self, edge: usize, forward: bool, arriving: bool) -> Vector3<f64> {
        let e = &self.edges[edge];
        let at_end = forward == arriving;
        let [a, b] = e.range;
        let t = if at_end { b } else { a };
        let mut d = e.curve.jet(t).d1;
        if d.norm() <= 1e-12 * e.bounds.diagonal() / (b - a) {
            // A curve that starts at rest: the chord of a short piece has its direction.
            let inner = t + (0.5 * (a + b) - t) * 1e-4;
            d = (e.curve.point(inner) - e.curve.point(t)) * if at_end { -1.0 } else { 1.0 };
        }
        let d = d.try_normalize(0.0).unwrap_or_else(Vector3::zeros);
        if forward { d } else { -d }
    }

    /// The side at the apex of a cone: that of the solid angle, along the axis.
    pub(crate) fn apex_side(&self, face: usize, x: &Vector3<f64>, point: &Vector3<f64>) -> Sides {
        let normal = self.apex_normal(face).unwrap_or_else(Vector3::zeros);
        Sides { side: side(&(x - point), &normal), normal, open: false, face: Some(face) }
    }

    /// The mean of the normals around the apex of a cone, which lies on its axis.
    fn apex_normal(&self, face: usize) -> Option<Vector3<f64>> {
        let f = &self.faces[face];
        let crate::description::Carrier::Cone { frame, .. } = f.carrier() else { return None };
        let apex = f.surface.apex()?;
        let inner = f.boundary.chords.first().map(|c| c.uv[0].y)?;
        let beside = Vector2::new(0.0, apex + 1e-3 * (inner - apex));
        let n = f.surface.normal(&beside);
        let n = if f.same_sense { n } else { -n };
        (frame.z() * n.dot(&frame.z())).try_normalize(0.0)
    }
}
