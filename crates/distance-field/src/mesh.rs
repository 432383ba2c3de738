//! The distance from triangle meshes.

use crate::local_geometry::{LocalGeometry, of_bend, of_point, of_principal, of_tensor, tangents};
use crate::{DistanceField, Error, Hint, PrincipalFrame, Search, parallel};
use footpoint::Status;
use mesh_core::{Feature, HalfEdge, HalfEdgeMesh, MeshCurvature, MeshFootpoint, MeshProjector, TriangleMesh};
use nalgebra::{Matrix3, Point3, Vector3};
use nurbs_core::Aabb;

/// What a mesh stands for between its vertices.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "snake_case"))]
pub enum MeshGeometry {
    /// A smooth surface that the mesh samples: every foot has two tangent directions and the estimated curvatures of the
    /// mesh there, whether it lies on a face, an edge or a vertex.
    #[default]
    Smooth,
    /// The polyhedron itself: faces are planes, edges straight lines, vertices points.
    Exact,
}

/// How the distance from a mesh is modelled.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct MeshOptions {
    /// What the mesh stands for; default [`MeshGeometry::Smooth`].
    pub geometry: MeshGeometry,
    /// How often curvatures are averaged over neighbouring vertices; default 1.
    pub smoothing: usize,
}

impl Default for MeshOptions {
    fn default() -> Self {
        Self { geometry: MeshGeometry::default(), smoothing: 1 }
    }
}

impl MeshOptions {
    /// Sets what the mesh stands for.
    #[must_use]
    pub fn with_geometry(self, geometry: MeshGeometry) -> Self {
        Self { geometry, ..self }
    }

    /// Sets how often curvatures are averaged over neighbouring vertices.
    #[must_use]
    pub fn with_smoothing(self, smoothing: usize) -> Self {
        Self { smoothing, ..self }
    }
}

/// The distance from a triangle mesh, signed by the angle-weighted pseudo-normals (\[BA05\]).
///
/// Feet are exact closest points of the polyhedron, whatever the [`Search`]; hints shorten the search and do not change it. On open meshes the sign
/// is that of the side of the nearest face. Where an open mesh ends, the foot moves along the boundary edge only, and at
/// a boundary vertex not at all.
///
/// ```
/// use distance_field::{DistanceField, Hint, MeshField, Search};
/// use mesh_core::TriangleMesh;
/// use nalgebra::{Point3, Vector3};
///
/// let corners = [[0., 0., 0.], [4., 0., 0.], [0., 4., 0.]].map(Point3::from).to_vec();
/// let field = MeshField::new(&TriangleMesh::new(corners, vec![[0, 1, 2]])?)?;
/// let inside = field.frame(&Vector3::new(1.0, 1.0, -2.0), Search::Global, &Hint::NONE);
/// assert_eq!((inside.distance, inside.tangent_dimension, inside.on_boundary), (-2.0, 2, false));
/// let beside = field.frame(&Vector3::new(1.0, -1.0, 0.0), Search::Global, &Hint::NONE);
/// assert_eq!((beside.tangent_dimension, beside.on_boundary), (1, true));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct MeshField {
    projector: MeshProjector,
    positions: Vec<Point3<f64>>,
    triangles: Vec<[u32; 3]>,
    boundary: Boundary,
    /// Second fundamental form and normal per vertex; empty for the exact geometry, zero where there is none.
    forms: Vec<(Matrix3<f64>, Vector3<f64>)>,
    bounds: Aabb<3>,
    /// How far beyond the nearest triangle others are looked for, so that feet of queries that move a little are known.
    wanted_slack: f64,
}

/// Triangles beyond the nearest one are looked for up to this share of the side of a mean triangle: a few more are looked at.
const SLACK: f64 = 0.25;

/// Where a mesh ends.
#[derive(Clone, Debug)]
struct Boundary {
    /// One bit per edge of each triangle.
    edges: Vec<u8>,
    vertices: Vec<bool>,
}

impl MeshField {
    /// The distance from a mesh, with the default options.
    ///
    /// # Errors
    /// [`Error::Mesh`] if no triangle has finite coordinates.
    pub fn new(mesh: &TriangleMesh) -> Result<Self, Error> {
        Self::with_options(mesh, &MeshOptions::default())
    }

    /// The distance from a mesh.
    ///
    /// # Errors
    /// [`Error::Mesh`] if no triangle has finite coordinates.
    pub fn with_options(mesh: &TriangleMesh, options: &MeshOptions) -> Result<Self, Error> {
        let projector = MeshProjector::new(mesh)?;
        let forms = match options.geometry {
            MeshGeometry::Exact => Vec::new(),
            MeshGeometry::Smooth => {
                let curvature = MeshCurvature::new(mesh).smoothed(options.smoothing);
                let form = |frame: &mesh_core::CurvatureFrame| (frame.tensor(), frame.normal);
                let zero = (Matrix3::zeros(), Vector3::zeros());
                curvature.frames().iter().map(|f| f.as_ref().map_or(zero, form)).collect()
            }
        };
        let positions = mesh.vertices().to_vec();
        let finite = positions.iter().map(|p| &p.coords).filter(|p| p.iter().all(|c| c.is_finite()));
        let bounds = Aabb::of_points(finite).unwrap_or_else(|| Aabb::of_point(Vector3::zeros()));
        let triangles = mesh.triangles().to_vec();
        let area = mesh.area() / triangles.len().max(1) as f64;
        let wanted_slack = if area.is_finite() { SLACK * area.sqrt() } else { 0.0 };
        let boundary = Boundary::new(mesh);
        Ok(Self { projector, boundary, positions, triangles, forms, bounds, wanted_slack })
    }

    /// The projector that finds the feet.
    #[must_use]
    pub fn projector(&self) -> &MeshProjector {
        &self.projector
    }

    /// The second fundamental form and the normal at a foot, interpolated between the vertices.
    fn form_at(&self, foot: &MeshFootpoint) -> Option<(Matrix3<f64>, Vector3<f64>)> {
        let corners = self.triangles.get(foot.triangle)?;
        let (mut form, mut normal) = (Matrix3::zeros(), Vector3::zeros());
        for (&corner, weight) in corners.iter().zip(foot.barycentric) {
            let (at_corner, normal_there) = self.forms.get(corner as usize)?;
            form += at_corner * weight;
            normal += normal_there * weight;
        }
        (normal != Vector3::zeros()).then_some((form, normal))
    }

    /// Unit vector along an edge of a triangle.
    fn along(&self, triangle: usize, edge: u8) -> Option<Vector3<f64>> {
        let corners = self.triangles.get(triangle)?;
        let [from, to] =
            [edge, edge + 1].map(|corner| self.positions[corners[usize::from(corner) % 3] as usize]);
        (to - from).try_normalize(f64::MIN_POSITIVE)
    }

    /// The local geometry at a foot, and whether the mesh ends there.
    fn geometry(&self, foot: &MeshFootpoint, residual: &Vector3<f64>) -> (LocalGeometry<3>, bool) {
        let side = &foot.normal;
        let on_boundary = self.boundary.contains(foot, &self.triangles);
        let held = on_boundary || self.forms.is_empty();
        match foot.feature {
            Feature::Vertex(_) if held => (of_point(residual, Some(side)), on_boundary),
            Feature::Edge(edge) if held => {
                let along = self.along(foot.triangle, edge);
                let geometry = along.map_or_else(
                    || of_point(residual, Some(side)),
                    |along| of_bend(&along, &Vector3::zeros(), residual, Some(side)),
                );
                (geometry, on_boundary)
            }
            Feature::Face | Feature::Edge(_) | Feature::Vertex(_) => (self.smooth(foot, residual), false),
        }
    }

    /// The geometry of a surface whose normal is the direction of the residual, so that the gradient of the squared
    /// distance is exact, with the interpolated curvatures in the plane normal to it.
    fn smooth(&self, foot: &MeshFootpoint, residual: &Vector3<f64>) -> LocalGeometry<3> {
        let sign = if foot.normal.dot(residual) < 0.0 { -1.0 } else { 1.0 };
        let normal = match foot.feature {
            // The foot of a face may be rounded by more than a short residual is long.
            Feature::Face if foot.normal != Vector3::zeros() => foot.normal,
            _ => {
                let length = residual.norm();
                let noise = 64.0 * f64::EPSILON * foot.point.coords.amax();
                if length > noise || foot.normal == Vector3::zeros() {
                    (residual * sign).try_normalize(f64::MIN_POSITIVE).unwrap_or_else(Vector3::z)
                } else {
                    foot.normal
                }
            }
        };
        let distance = residual.dot(&normal);
        match self.form_at(foot) {
            // The form belongs to its own normal, which may point to the other side of a badly oriented mesh.
            Some((form, own)) => {
                of_tensor(&(form * if own.dot(&normal) < 0.0 { -1.0 } else { 1.0 }), &normal, distance)
            }
            None => of_principal(&tangents(&normal), &normal, [0.0; 2], distance),
        }
    }
}

impl Boundary {
    fn new(mesh: &TriangleMesh) -> Self {
        let connectivity = HalfEdgeMesh::new(mesh);
        let defects = connectivity.defects();
        // Edges where more than two triangles meet, or two that disagree, have no twins either, but no end.
        let mut inner: Vec<[u32; 2]> =
            defects.non_manifold_edges.iter().chain(&defects.inconsistent_edges).copied().collect();
        inner.sort_unstable();
        let welded = mesh.coincident_vertices();
        let mut edges = vec![0u8; mesh.triangles().len()];
        let mut ends = vec![false; mesh.vertices().len()];
        for half_edge in connectivity.half_edges().filter(|&edge| connectivity.twin(edge).is_none()) {
            let (from, to) = (connectivity.origin(half_edge), connectivity.target(half_edge));
            if inner.binary_search(&[from.min(to), from.max(to)]).is_err() {
                edges[half_edge.triangle()] |= 1 << half_edge.edge();
                ends[from as usize] = true;
                ends[to as usize] = true;
            }
        }
        Self { edges, vertices: welded.iter().map(|&first| ends[first as usize]).collect() }
    }

    fn contains(&self, foot: &MeshFootpoint, triangles: &[[u32; 3]]) -> bool {
        match foot.feature {
            Feature::Face => false,
            Feature::Edge(edge) => {
                let edge = u32::try_from(foot.triangle).map_or(0, |t| HalfEdge::new(t, edge).edge());
                self.edges.get(foot.triangle).is_some_and(|bits| bits >> edge & 1 == 1)
            }
            Feature::Vertex(corner) => triangles
                .get(foot.triangle)
                .and_then(|corners| self.vertices.get(corners[usize::from(corner) % 3] as usize))
                .is_some_and(|end| *end),
        }
    }
}

impl MeshField {
    /// The frame of a query; which triangle the search begins with does not change it.
    fn frame_from(
        &self,
        x: &Vector3<f64>,
        guess: Option<usize>,
        known: f64,
        wanted: f64,
    ) -> PrincipalFrame<3> {
        let x_point = Point3::from(*x);
        let proven = guess.filter(|_| known > 0.0).and_then(|i| self.projector.project_onto(&x_point, i));
        let found = match proven {
            Some(foot) => Ok((foot, known)),
            None => self.projector.project_with_slack(&x_point, guess, wanted),
        };
        let (foot, slack) = match found {
            Ok(found) => found,
            Err(mesh_core::Error::NonFinitePoint { .. }) => {
                return PrincipalFrame::invalid(Status::InvalidPoint);
            }
            Err(_) => return PrincipalFrame::invalid(Status::Diverged),
        };
        let (geometry, on_boundary) = self.geometry(&foot, &(x - foot.point.coords));
        PrincipalFrame {
            foot: foot.point.coords,
            axes: geometry.axes,
            curvatures: geometry.curvatures,
            tangent_dimension: geometry.tangent_dimension,
            distance: geometry.distance,
            on_boundary,
            hint: Hint { slack, ..Hint::new(foot.triangle, [foot.barycentric[1], foot.barycentric[2]]) },
            status: if on_boundary { Status::OnBoundary } else { Status::Converged },
        }
    }
}

/// How far a query may still move for which its triangle is known; 0 where it is not.
fn known_slack(hint: &Hint) -> f64 {
    if hint.is_proven { hint.slack } else { 0.0 }
}

impl DistanceField<3> for MeshField {
    fn frame(&self, x: &Vector3<f64>, _search: Search, hint: &Hint) -> PrincipalFrame<3> {
        self.frame_from(x, hint.element_below(self.triangles.len()), known_slack(hint), 0.0)
    }

    fn frames(&self, points: &[Vector3<f64>], _search: Search, hints: &[Hint]) -> Vec<PrincipalFrame<3>> {
        // Without a hint the search begins with the triangle of the query before, which often is a neighbour.
        let mut frames = vec![PrincipalFrame::invalid(Status::InvalidPoint); points.len()];
        parallel::fill_frames(&mut frames, |first, stretch| {
            let mut before = None;
            for (i, frame) in (first..).zip(stretch) {
                let hinted = hints.get(i).and_then(|hint| hint.element_below(self.triangles.len()));
                let known = hinted.map_or(0.0, |_| known_slack(&hints[i]));
                *frame = self.frame_from(&points[i], hinted.or(before), known, self.wanted_slack);
                before = frame.hint.element_below(self.triangles.len());
            }
        });
        frames
    }

    fn bounding_box(&self) -> Aabb<3> {
        self.bounds
    }
}
