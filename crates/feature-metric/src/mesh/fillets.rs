//! The image of a mesh in `R⁶`, sharp edges included: there the normal turns at one place, which the image shows as a strip.

use super::wedges::{Wedge, Wedges};
use mesh_core::{HalfEdge, HalfEdgeMesh};
use nalgebra::{Point3, Vector3};
use std::collections::BTreeMap;

/// Largest angle between neighbouring normals of a strip, radians: 15 degrees.
const STEP: f64 = 0.262;

/// A vertex of an image.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Place {
    /// In space.
    pub(crate) point: Point3<f64>,
    /// The unit normal.
    pub(crate) normal: Vector3<f64>,
}

/// A mesh of places.
#[derive(Clone, Debug, Default)]
pub(crate) struct Image {
    pub(crate) places: Vec<Place>,
    pub(crate) triangles: Vec<[u32; 3]>,
    /// The places of every vertex of the mesh.
    pub(crate) of_vertex: Vec<Vec<u32>>,
}

struct Builder<'a> {
    points: &'a [Point3<f64>],
    wedges: &'a Wedges,
    image: Image,
    /// The places along the arcs of normals between wedges of a vertex, from the smaller wedge to the larger.
    arcs: BTreeMap<[u32; 2], Vec<u32>>,
}

impl Image {
    /// The image of a mesh: every wedge becomes a vertex, every edge between different wedges a strip, every vertex with three
    /// sharp edges or more a piece of a sphere.
    pub(crate) fn of(points: &[Point3<f64>], connectivity: &HalfEdgeMesh, wedges: &Wedges) -> Self {
        let image = Self { of_vertex: vec![Vec::new(); connectivity.vertex_count()], ..Self::default() };
        let mut builder = Builder { points, wedges, image, arcs: BTreeMap::new() };
        for Wedge { vertex, normal } in &wedges.all {
            builder.place(*vertex, *normal);
        }
        for half_edge in connectivity.half_edges().filter(|half_edge| half_edge.edge() == 0) {
            builder.image.triangles.push(wedges.corners[half_edge.triangle()]);
        }
        // The sides of the arcs that the strips leave open, by vertex.
        let mut open: BTreeMap<u32, Vec<[u32; 2]>> = BTreeMap::new();
        for half_edge in connectivity.half_edges() {
            let Some(twin) = connectivity.twin(half_edge).filter(|twin| half_edge < *twin) else { continue };
            builder.strip(connectivity, half_edge, twin, &mut open);
        }
        for (vertex, sides) in open {
            builder.cap(vertex, &sides);
        }
        builder.image
    }
}

impl Builder<'_> {
    fn place(&mut self, vertex: u32, normal: Vector3<f64>) -> u32 {
        let index = u32::try_from(self.image.places.len()).unwrap_or(u32::MAX);
        self.image.places.push(Place { point: self.points[vertex as usize], normal });
        self.image.of_vertex[vertex as usize].push(index);
        index
    }

    /// The places from one wedge of a vertex to another, both included.
    fn arc(&mut self, vertex: u32, from: u32, to: u32) -> Vec<u32> {
        let key = [from.min(to), from.max(to)];
        if !self.arcs.contains_key(&key) {
            let mut arc = vec![key[0]];
            if key[0] != key[1] {
                let [one, other] = key.map(|wedge| self.wedges.all[wedge as usize].normal);
                let angle = one.cross(&other).norm().atan2(one.dot(&other));
                #[expect(
                    clippy::cast_possible_truncation,
                    clippy::cast_sign_loss,
                    reason = "an angle of at most half a turn"
                )]
                let steps = (angle / STEP).ceil().max(1.0) as u32;
                for k in 1..steps {
                    let normal = between(&one, &other, angle, f64::from(k) / f64::from(steps));
                    arc.push(self.place(vertex, normal));
                }
                arc.push(key[1]);
            }
            self.arcs.insert(key, arc);
        }
        let arc = self.arcs.get(&key).cloned().unwrap_or_default();
        if from <= to { arc } else { arc.into_iter().rev().collect() }
    }

    /// The strip between the triangles of two half-edges of one edge.
    fn strip(
        &mut self,
        connectivity: &HalfEdgeMesh,
        half_edge: HalfEdge,
        twin: HalfEdge,
        open: &mut BTreeMap<u32, Vec<[u32; 2]>>,
    ) {
        let corner = |half_edge: HalfEdge| self.wedges.corners[half_edge.triangle()][half_edge.edge()];
        let (a1, b1) = (corner(half_edge), corner(half_edge.next()));
        let (b2, a2) = (corner(twin), corner(twin.next()));
        if (a1, b1) == (a2, b2) {
            return;
        }
        let [a, b] = [connectivity.origin(half_edge), connectivity.target(half_edge)];
        let (left, right) = (self.arc(a, a1, a2), self.arc(b, b1, b2));
        let (mut i, mut j) = (0, 0);
        while i + 1 < right.len() || j + 1 < left.len() {
            // The side that is behind, as a share of its length.
            let ahead_left = (j + 1) * (right.len() - 1).max(1);
            let ahead_right = (i + 1) * (left.len() - 1).max(1);
            if j + 1 < left.len() && (i + 1 >= right.len() || ahead_left <= ahead_right) {
                self.image.triangles.push([right[i], left[j], left[j + 1]]);
                open.entry(a).or_default().push([left[j], left[j + 1]]);
                j += 1;
            } else {
                self.image.triangles.push([right[i], left[j], right[i + 1]]);
                open.entry(b).or_default().push([right[i + 1], right[i]]);
                i += 1;
            }
        }
    }

    /// Fills what the strips around a vertex leave open, unless it is nothing or lies at the boundary.
    fn cap(&mut self, vertex: u32, sides: &[[u32; 2]]) {
        let is_open = |side: &&[u32; 2]| !sides.contains(&[side[1], side[0]]);
        let sides: Vec<[u32; 2]> = sides.iter().filter(is_open).copied().collect();
        // A cycle: as many sides that begin in a place as end in it.
        let closed = sides.iter().all(|side| sides.iter().any(|other| other[0] == side[1]));
        if sides.len() < 3 || !closed {
            return;
        }
        let sum: Vector3<f64> = sides.iter().map(|side| self.image.places[side[0] as usize].normal).sum();
        let length = sum.norm();
        if length < 1e-6 {
            return;
        }
        let centre = self.place(vertex, sum / length);
        for [from, to] in sides {
            self.image.triangles.push([to, from, centre]);
        }
    }
}

/// A unit vector between two others that make this angle.
fn between(one: &Vector3<f64>, other: &Vector3<f64>, angle: f64, share: f64) -> Vector3<f64> {
    let sine = angle.sin();
    if sine > 1e-9 {
        return one * (((1.0 - share) * angle).sin() / sine) + other * ((share * angle).sin() / sine);
    }
    // Opposite normals: by way of any direction across.
    let across = one.cross(&Vector3::ith(one.iamin(), 1.0)).normalize();
    one * (share * angle).cos() + across * (share * angle).sin()
}
