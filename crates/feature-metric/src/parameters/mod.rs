//! Parameters of a patch: a mesh with one boundary over a square or a disc, in either metric.

mod boundary;
mod pieces;
mod solve;

use crate::{Error, Metric, MetricMesh};
use boundary::Boundary;
use mesh_core::TriangleMesh;
use nalgebra::Point3;
use pieces::{Piece, divided, pieces};
use std::collections::BTreeMap;

/// Marks a vertex of the image that belongs to no vertex of the mesh.
const NONE: u32 = u32::MAX;

/// Where the boundary of a patch goes; both domains fill `[0, 1]²`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum ParameterDomain {
    /// Along the sides of the unit square, with four corners.
    #[default]
    Square,
    /// Around the circle of radius 1/2 about (1/2, 1/2).
    Disc,
}

/// How a patch is parameterised.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ParameterOptions {
    /// Where its boundary goes.
    pub domain: ParameterDomain,
    /// The vertices at the corners of the square, in any order; the first goes to (0, 0), the others follow with the surface on the
    /// left. `None` takes the sharpest corners of the boundary, however the metric measures.
    pub corners: Option<[usize; 4]>,
}

impl ParameterOptions {
    /// The same with another domain.
    #[must_use]
    pub fn with_domain(self, domain: ParameterDomain) -> Self {
        Self { domain, ..self }
    }

    /// The same with given corners.
    #[must_use]
    pub fn with_corners(self, corners: Option<[usize; 4]>) -> Self {
        Self { corners, ..self }
    }
}

/// A vertex with its parameters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ParameterPlace {
    /// The vertex of the given mesh.
    pub vertex: usize,
    /// Its parameters `u` and `v`.
    pub parameters: [f64; 2],
}

/// A patch over a domain of the plane.
///
/// In the feature sensitive metric a vertex of a sharp edge has a place for each side: the domain has a strip between them, as it has one for
/// a narrow fillet.
#[derive(Clone, Debug, PartialEq)]
pub struct PatchParameters {
    /// Every vertex that belongs to a triangle, at each of its places, by vertices.
    pub places: Vec<ParameterPlace>,
    /// The triangles of the mesh between these places, in their order; those without area in space are left out.
    pub triangles: Vec<[u32; 3]>,
    /// The vertices at the corners of the square; `None` over a disc.
    pub corners: Option<[usize; 4]>,
    /// Length of the boundary in the metric.
    pub boundary_length: f64,
    /// Triangles that have no positive area in the plane: none but for triangles with three vertices on one side of the square, and for
    /// triangles between whose corners the normal turns by more than 15 degrees without an edge.
    pub folded: usize,
}

impl PatchParameters {
    /// Where `u` (direction 0) or `v` (1) is `k / count` for a whole number `k` on the triangles of the mesh that was parameterised, in
    /// segments, without the boundary of the domain.
    #[must_use]
    pub fn lines(&self, mesh: &TriangleMesh, direction: usize, count: u32) -> Vec<[Point3<f64>; 2]> {
        let mut found = Vec::new();
        for triangle in &self.triangles {
            let corners = triangle.map(|k| {
                let place = &self.places[k as usize];
                (mesh.vertices()[place.vertex], place.parameters[direction.min(1)])
            });
            for level in (1..count).map(|k| f64::from(k) / f64::from(count)) {
                let ends: Vec<Point3<f64>> = (0..3)
                    .filter_map(|k| {
                        let ((x, low), (y, high)) = (corners[k], corners[(k + 1) % 3]);
                        let share = (level - low) / (high - low);
                        ((low < level) != (high < level)).then(|| x + (y - x) * share)
                    })
                    .collect();
                if let [a, b] = ends[..] {
                    found.push([a, b]);
                }
            }
        }
        found
    }
}

/// Parameters of a patch by mean values of the neighbours (\[Fl03\]) in a metric.
///
/// The boundary goes to that of the domain by its lengths in the metric, and every inner vertex is the mean of its neighbours with the
/// weights `(tan α/2 + tan β/2) / length`, α and β the angles beside an edge. They are positive and the domain is convex, so that
/// no triangle of the image folds (\[Fl03, sec. 2\]); and linear functions come back, so that a flat square has its own coordinates.
/// With the lengths on the image `(x, w n)` features, across which the image is long, take more of the domain (\[P05, sec. 6\]).
///
/// # Errors
/// [`Error::NotADisc`] if the mesh is not one patch with one boundary; [`Error::Corners`] for corners that are not four vertices of the
/// boundary, [`Error::Unsolvable`] if the triangles are too thin for the weights; those of [`MetricMesh::new`].
///
/// ```
/// use feature_metric::{Metric, ParameterOptions, parameterize_patch};
/// use mesh_core::TriangleMesh;
/// use nalgebra::Point3;
///
/// // Two squares of side 1 that meet at a right angle, a middle vertex in the first.
/// let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0], [1.0, 0.0, 1.0], [1.0, 1.0, 1.0], [0.5, 0.5, 0.0]];
/// let triangles = vec![[0, 1, 6], [1, 2, 6], [2, 3, 6], [3, 0, 6], [1, 4, 5], [1, 5, 2]];
/// let mesh = TriangleMesh::new(corners.into_iter().map(Point3::from).collect(), triangles)?;
/// let plain = parameterize_patch(&mesh, Metric::Euclidean, &ParameterOptions::default())?;
/// let middle = plain.places[6].parameters;
/// assert!((middle[0] - 0.25).abs() < 1e-12 && (middle[1] - 0.5).abs() < 1e-12);
/// // The edge takes a share of the square: its vertices have one place on either side of it.
/// let feature = parameterize_patch(&mesh, Metric::Feature { width: 1.0 }, &ParameterOptions::default())?;
/// assert_eq!((feature.places.len(), feature.folded), (9, 0));
/// # Ok::<(), feature_metric::Error>(())
/// ```
pub fn parameterize_patch(
    mesh: &TriangleMesh,
    metric: Metric,
    options: &ParameterOptions,
) -> Result<PatchParameters, Error> {
    let image = MetricMesh::new(mesh, metric)?;
    let vertices = vertices_of(mesh, &image);
    let boundary = Boundary::of(mesh, &image, &vertices, options)?;
    let mut parts: Vec<Piece> = pieces(&image)?;
    let mut count = image.connectivity.vertex_count();
    if options.domain == ParameterDomain::Square {
        (parts, count) = divided(parts, count, &boundary.flat_edges(&image));
    }
    let parameters = solve::solve(&parts, count, &boundary.places)?;
    Ok(gathered(mesh, &image, &boundary, &parameters))
}

/// For each vertex of the image the first vertex of the mesh that is there.
fn vertices_of(mesh: &TriangleMesh, image: &MetricMesh) -> Vec<u32> {
    let mut vertices = vec![NONE; image.connectivity.vertex_count()];
    for (vertex, places) in (0u32..).zip(&image.of_vertex).take(mesh.vertices().len()) {
        for &place in places {
            let own = &mut vertices[place as usize];
            if *own == NONE {
                *own = vertex;
            }
        }
    }
    vertices
}

/// The parameters of the vertices of the mesh, and what folds.
fn gathered(
    mesh: &TriangleMesh,
    image: &MetricMesh,
    boundary: &Boundary,
    parameters: &[[f64; 2]],
) -> PatchParameters {
    let corners = || mesh.triangles().iter().zip(&image.corners).filter(|(_, places)| places[0] != NONE);
    let mut numbers: BTreeMap<(u32, u32), u32> = BTreeMap::new();
    for (triangle, places) in corners() {
        for k in 0..3 {
            numbers.insert((triangle[k], places[k]), 0);
        }
    }
    for (number, own) in (0u32..).zip(numbers.values_mut()) {
        *own = number;
    }
    let places: Vec<ParameterPlace> = numbers
        .keys()
        .map(|&(vertex, place)| ParameterPlace {
            vertex: vertex as usize,
            parameters: parameters[place as usize],
        })
        .collect();
    let triangles: Vec<[u32; 3]> = corners()
        .map(|(triangle, places)| {
            [0, 1, 2].map(|k| numbers.get(&(triangle[k], places[k])).copied().unwrap_or(0))
        })
        .collect();
    let folded = triangles.iter().filter(|t| area(t.map(|k| places[k as usize].parameters)) <= 0.0).count();
    PatchParameters { places, triangles, corners: boundary.corners, boundary_length: boundary.length, folded }
}

/// Twice the signed area of a triangle in the plane.
fn area([a, b, c]: [[f64; 2]; 3]) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}
