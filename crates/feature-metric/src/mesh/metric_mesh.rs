//! A mesh with the lengths of its edges in a metric.

use super::fillets::Image;
use super::wedges::Wedges;
use crate::metric::LENGTHS;
use crate::{Error, Metric};
use mesh_core::{HalfEdge, HalfEdgeMesh, TriangleMesh};
use nalgebra::Point3;
use std::collections::BTreeMap;

/// A mesh as a metric sees it: triangles with the lengths of their sides, and nothing else of space.
///
/// In the feature sensitive metric it is the image `(x, w n)` of the mesh in `R⁶`: its edges are chords there, so that the
/// triangle inequality holds. Normals are those of the mesh where it has some, otherwise means over triangles between sharp edges
/// (40 degrees and more). Where the normal jumps at an edge, the image has a strip of triangles without width in space; where
/// neighbouring normals differ by more than 15 degrees, edges are split.
///
/// Vertices at one place count as one corner, through which ways may lead from one fan of triangles to another. Edges that more than two triangles share, or that neighbours run through in the same
/// direction, are boundaries: [`is_manifold`](Self::is_manifold) tells.
#[derive(Clone, Debug)]
pub struct MetricMesh {
    pub(crate) connectivity: HalfEdgeMesh,
    /// Lengths of the half-edges, by `3 · triangle + edge`.
    pub(crate) lengths: Vec<f64>,
    /// The vertices in space.
    pub(crate) points: Vec<Point3<f64>>,
    /// The vertices here of every vertex of the given mesh; those at one place have the same ones.
    pub(crate) of_vertex: Vec<Vec<u32>>,
    /// The vertices here at the corners of every triangle of the given mesh; `u32::MAX` for one without area.
    pub(crate) corners: Vec<[u32; 3]>,
    /// All half-edges out of the vertices where several fans of triangles meet.
    fans: BTreeMap<u32, Vec<HalfEdge>>,
    metric: Metric,
    is_manifold: bool,
}

impl MetricMesh {
    /// A mesh with a metric.
    ///
    /// # Errors
    /// [`Error::NoSurface`] without a triangle; [`Error::Magnitude`] for a mesh too small or too large; [`Error::Option`] for a width that is negative or not finite;
    /// [`Error::TooLarge`] when normals differ too much for the number of triangles.
    pub fn new(mesh: &TriangleMesh, metric: Metric) -> Result<Self, Error> {
        metric.validate()?;
        let first = mesh.coincident_vertices();
        let finite = |triangle: &[u32; 3]| {
            triangle.iter().all(|&index| mesh.vertices()[index as usize].iter().all(|c| c.is_finite()))
        };
        // What is not finite keeps its place among the triangles, as one without area.
        let welded: Vec<[u32; 3]> = mesh
            .triangles()
            .iter()
            .map(
                |triangle| {
                    if finite(triangle) { triangle.map(|index| first[index as usize]) } else { [0; 3] }
                },
            )
            .collect();
        let given = HalfEdgeMesh::of(mesh.vertices().len(), &welded);
        if given.half_edges().next().is_none() {
            return Err(Error::NoSurface);
        }
        let defects = given.defects();
        let is_manifold = defects.non_manifold_edges.is_empty()
            && defects.inconsistent_edges.is_empty()
            && defects.non_manifold_vertices.is_empty();
        let width = metric.width();
        let in_space = lengths(&given, |a, b| (mesh.vertices()[a] - mesh.vertices()[b]).norm());
        let longest = in_space.iter().copied().fold(0.0, f64::max);
        if !LENGTHS.contains(&longest) {
            return Err(Error::Magnitude { length: longest });
        }
        if width == 0.0 {
            let lengths = in_space;
            let of_vertex = first.iter().map(|&corner| vec![corner]).collect();
            let points = mesh.vertices().to_vec();
            let fans = fans(&given);
            let mut corners = vec![[u32::MAX; 3]; welded.len()];
            for half_edge in given.half_edges() {
                corners[half_edge.triangle()][half_edge.edge()] = given.origin(half_edge);
            }
            return Ok(Self {
                connectivity: given,
                lengths,
                points,
                of_vertex,
                corners,
                fans,
                metric,
                is_manifold,
            });
        }
        let wedges = Wedges::of(mesh, &given);
        let mut image = Image::of(mesh.vertices(), &given, &wedges);
        image.refine()?;
        let connectivity = HalfEdgeMesh::of(image.places.len(), &image.triangles);
        let places = &image.places;
        let lengths = lengths(&connectivity, |a, b| {
            let (one, other) = (&places[a], &places[b]);
            (one.point - other.point).norm().hypot(width * (one.normal - other.normal).norm())
        });
        let of_vertex = first.iter().map(|&corner| image.of_vertex[corner as usize].clone()).collect();
        let points = places.iter().map(|place| place.point).collect();
        let fans = fans(&connectivity);
        let corners = wedges.corners;
        Ok(Self { connectivity, lengths, points, of_vertex, corners, fans, metric, is_manifold })
    }

    /// The metric.
    #[must_use]
    pub fn metric(&self) -> Metric {
        self.metric
    }

    /// Number of vertices of the given mesh.
    #[must_use]
    pub fn vertex_count(&self) -> usize {
        self.of_vertex.len()
    }

    /// Number of triangles that distances are propagated over.
    #[must_use]
    pub fn triangle_count(&self) -> usize {
        self.connectivity.triangles().len()
    }

    /// Whether the given mesh is an oriented manifold, so that no edge is cut.
    #[must_use]
    pub fn is_manifold(&self) -> bool {
        self.is_manifold
    }

    /// The half-edges out of a vertex here, of all of its fans.
    pub(crate) fn spokes(&self, vertex: u32) -> impl Iterator<Item = HalfEdge> {
        let fans = self.fans.get(&vertex);
        let one = fans.is_none().then(|| self.connectivity.spokes(vertex));
        fans.into_iter().flatten().copied().chain(one.into_iter().flatten())
    }

    /// Whether the surface ends at a vertex here, or several fans meet: ways may bend there.
    pub(crate) fn is_border(&self, vertex: u32) -> bool {
        self.fans.contains_key(&vertex) || self.connectivity.is_boundary(vertex)
    }

    /// The vertices here of a vertex of the given mesh.
    ///
    /// # Errors
    /// [`Error::Vertex`] if it belongs to no triangle.
    pub(crate) fn places(&self, vertex: usize) -> Result<&[u32], Error> {
        let count = self.of_vertex.len();
        let used = |place: &u32| self.connectivity.spokes(*place).next().is_some();
        let places = self.of_vertex.get(vertex).filter(|places| places.iter().any(used));
        places.map(Vec::as_slice).ok_or(Error::Vertex { vertex, count })
    }

    /// Values per vertex of the given mesh, the least of its places; infinite for one that belongs to no triangle.
    pub(crate) fn per_vertex(&self, values: &[f64]) -> Vec<f64> {
        let least = |places: &Vec<u32>| {
            places.iter().map(|&place| values[place as usize]).fold(f64::INFINITY, f64::min)
        };
        self.of_vertex.iter().map(least).collect()
    }

    /// The length of a half-edge.
    #[inline]
    pub(crate) fn length(&self, half_edge: HalfEdge) -> f64 {
        self.lengths[3 * half_edge.triangle() + half_edge.edge()]
    }

    /// The angle of a triangle at the origin of a half-edge.
    pub(crate) fn angle(&self, half_edge: HalfEdge) -> f64 {
        let [one, across, other] =
            [half_edge, half_edge.next(), half_edge.previous()].map(|edge| self.length(edge));
        let cosine = (one * one + other * other - across * across) / (2.0 * one * other);
        if cosine.is_finite() { cosine.clamp(-1.0, 1.0).acos() } else { 0.0 }
    }

    /// Where the vertex opposite to a half-edge lies if that runs from the origin along the first axis, to its left.
    #[inline]
    pub(crate) fn apex(&self, half_edge: HalfEdge) -> [f64; 2] {
        let length = self.length(half_edge);
        let (far, near) = (self.length(half_edge.next()), self.length(half_edge.previous()));
        let along = (length * length + near * near - far * far) / (2.0 * length);
        if length > 0.0 { [along, (near * near - along * along).max(0.0).sqrt()] } else { [0.0, near] }
    }
}

/// The half-edges out of each vertex that has more of them than those of one fan.
fn fans(connectivity: &HalfEdgeMesh) -> BTreeMap<u32, Vec<HalfEdge>> {
    let mut counts = vec![0usize; connectivity.vertex_count()];
    for half_edge in connectivity.half_edges() {
        counts[connectivity.origin(half_edge) as usize] += 1;
    }
    let mut fans: BTreeMap<u32, Vec<HalfEdge>> = (0u32..)
        .zip(&counts)
        .filter(|(vertex, count)| connectivity.spokes(*vertex).count() < **count)
        .map(|(vertex, _)| (vertex, Vec::new()))
        .collect();
    if !fans.is_empty() {
        for half_edge in connectivity.half_edges() {
            if let Some(fan) = fans.get_mut(&connectivity.origin(half_edge)) {
                fan.push(half_edge);
            }
        }
    }
    fans
}

fn lengths(connectivity: &HalfEdgeMesh, length: impl Fn(usize, usize) -> f64) -> Vec<f64> {
    let mut lengths = vec![0.0; 3 * connectivity.triangles().len()];
    for half_edge in connectivity.half_edges() {
        // In one direction, so that both sides have the same bits.
        let (a, b) = (connectivity.origin(half_edge) as usize, connectivity.target(half_edge) as usize);
        lengths[3 * half_edge.triangle() + half_edge.edge()] = length(a.min(b), a.max(b));
    }
    lengths
}
