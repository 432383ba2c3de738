//! Closest points on a triangle mesh.

use std::sync::OnceLock;

use nalgebra::{Point3, Vector3};

use crate::bounds::is_finite;
use crate::bvh::{Aabb, Bvh};
use crate::nearest_triangle::Nearest;
use crate::normal_cone::NormalCone;
use crate::pseudo_normal::PseudoNormals;
use crate::topology::EdgeMap;
use crate::triangle::{Feature, Triangle, TriangleFoot};
use crate::{BoundingBox, Error, MeshTopology, TriangleMesh};

/// Part of the mesh's diagonal within which triangles count as meeting at a point, where one of them has no area.
const MEETING: f64 = 1e-9;

/// The closest point on a mesh.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MeshFootpoint {
    /// Index of the triangle; the smallest where several are equally near.
    pub triangle: usize,
    /// Weights of the triangle's corners: not negative, their sum is 1 up to rounding.
    pub barycentric: [f64; 3],
    /// The part of the triangle on which the point lies.
    pub feature: Feature,
    /// The closest point.
    pub point: Point3<f64>,
    /// Distance to it.
    pub distance: f64,
    /// The distance, negative inside; `None` where the mesh encloses no solid ([`MeshProjector::is_solid`]).
    ///
    /// Inside is where the normals point away from: in a mesh turned inside out the signs are reversed.
    pub signed_distance: Option<f64>,
    /// Unit angle-weighted pseudo-normal at the closest point; zero where all triangles there have no area.
    pub normal: Vector3<f64>,
}

/// Answers closest point queries on a mesh. Built once per mesh in O(n log n); a query takes O(log n) in practice.
///
/// Triangles with a vertex that is not finite are left out ([`MeshProjector::skipped`]); degenerate ones act as the
/// segments or points they are. Vertices that are one corner but for rounding
/// count as one ([`TriangleMesh::weld`]). Answers do not depend on anything
/// but mesh and point, so that queries may be spread over threads at will.
#[derive(Debug, Clone)]
pub struct MeshProjector {
    pub(crate) bvh: Bvh,
    /// Triangles in the order of the hierarchy, and the same for their indices in the mesh, vertices and neighbours.
    pub(crate) triangles: Vec<Triangle>,
    pub(crate) indices: Vec<u32>,
    corners: Vec<[u32; 3]>,
    neighbours: Vec<[u32; 3]>,
    pub(crate) normals: PseudoNormals,
    topology: MeshTopology,
    skipped: usize,
    pub(crate) meeting: f64,
    /// Largest absolute coordinate.
    pub(crate) reach: f64,
    /// Place of each triangle of the mesh, and the normals under each node; made when they are first asked for.
    pub(crate) places: OnceLock<Vec<u32>>,
    pub(crate) cones: OnceLock<Vec<NormalCone>>,
}

impl MeshProjector {
    /// Prepares a mesh for queries.
    ///
    /// # Errors
    /// [`Error::NoTriangles`] if no triangle has finite coordinates.
    pub fn new(mesh: &TriangleMesh) -> Result<Self, Error> {
        let positions = mesh.vertices();
        let welded = mesh.welded_triangles();
        let shape_of = |corners: &[u32; 3]| Triangle(corners.map(|vertex| positions[vertex as usize]));
        let usable: Vec<u32> = (welded.iter().zip(0u32..))
            .filter(|(corners, _)| shape_of(corners).0.iter().all(is_finite))
            .map(|(_, index)| index)
            .collect();
        if usable.is_empty() {
            return Err(Error::NoTriangles { triangles: welded.len() });
        }
        let boxes: Vec<_> =
            usable.iter().map(|&index| Aabb::of_points(&shape_of(&welded[index as usize]).0)).collect();
        let bvh = Bvh::new(&boxes);
        drop(boxes);
        let indices: Vec<u32> = bvh.order.iter().map(|&place| usable[place as usize]).collect();
        let corners: Vec<[u32; 3]> = indices.iter().map(|&index| welded[index as usize]).collect();
        let triangles: Vec<_> = corners.iter().map(shape_of).collect();
        let edges = EdgeMap::of(&corners);
        let normals = PseudoNormals::new(&triangles, &corners, positions.len());
        Ok(Self {
            bvh,
            normals,
            topology: edges.topology,
            neighbours: edges.neighbours,
            skipped: welded.len() - indices.len(),
            meeting: MEETING * BoundingBox::of(positions).map_or(0.0, |bounds| bounds.diagonal()),
            reach: triangles.iter().flat_map(|t| &t.0).map(|p| p.coords.amax()).fold(0.0, f64::max),
            triangles,
            indices,
            corners,
            places: OnceLock::new(),
            cones: OnceLock::new(),
        })
    }

    /// Whether the mesh encloses a solid, so that distances have a sign: every edge belongs to exactly two triangles
    /// with agreeing normals.
    #[must_use]
    pub const fn is_solid(&self) -> bool {
        self.topology.is_solid()
    }

    /// The edges of the triangles that take part, vertices at the same position counting as one.
    #[must_use]
    pub const fn topology(&self) -> &MeshTopology {
        &self.topology
    }

    /// Number of triangles left out because a vertex is not finite.
    #[must_use]
    pub const fn skipped(&self) -> usize {
        self.skipped
    }

    /// The closest point to `x`.
    ///
    /// # Errors
    /// [`Error::NonFinitePoint`] if a coordinate of `x` is NaN or infinite, [`Error::DistanceOverflow`] if the squared
    /// distance exceeds the largest double.
    pub fn project(&self, x: &Point3<f64>) -> Result<MeshFootpoint, Error> {
        self.project_near(x, None)
    }

    /// [`MeshProjector::project`], in less time if the closest point lies on the given triangle of the mesh or near it; which
    /// triangle is given does not change the answer.
    ///
    /// # Errors
    /// As for [`MeshProjector::project`].
    pub fn project_near(&self, x: &Point3<f64>, triangle: Option<usize>) -> Result<MeshFootpoint, Error> {
        self.project_with_slack(x, triangle, 0.0).map(|(foot, _)| foot)
    }

    /// [`MeshProjector::project_near`], and the distance over which `x` may move while its closest point stays on the same triangle: at
    /// most half of `wanted`, which is how far beyond the nearest triangle others are looked for. 0 where nothing is known.
    ///
    /// # Errors
    /// As for [`MeshProjector::project`].
    pub fn project_with_slack(
        &self,
        x: &Point3<f64>,
        triangle: Option<usize>,
        wanted: f64,
    ) -> Result<(MeshFootpoint, f64), Error> {
        if !is_finite(x) {
            return Err(Error::NonFinitePoint { x: x.x, y: x.y, z: x.z });
        }
        let guess = triangle.and_then(|triangle| self.place_of(triangle));
        let Some(Nearest { place, foot, slack }) = self.nearest(x, guess, wanted) else {
            return Err(Error::DistanceOverflow { x: x.x, y: x.y, z: x.z });
        };
        Ok((self.footpoint(x, place, foot), slack))
    }

    /// The closest point to `x` of one triangle of the mesh: that of the mesh where this triangle is known to be the nearest.
    ///
    /// `None` if the triangle takes no part, or if `x` is not finite or too far away.
    #[must_use]
    pub fn project_onto(&self, x: &Point3<f64>, triangle: usize) -> Option<MeshFootpoint> {
        let place = self.place_of(triangle)?;
        let foot = self.triangles[place].closest(x);
        (foot.distance_sq < f64::INFINITY).then(|| self.footpoint(x, place, foot))
    }

    pub(crate) fn footpoint(&self, x: &Point3<f64>, place: usize, foot: TriangleFoot) -> MeshFootpoint {
        let normal = self.pseudo_normal(place, foot.feature, &foot.point);
        let distance = foot.distance_sq.sqrt();
        let signed_distance =
            self.is_solid().then(|| if (x - foot.point).dot(&normal) < 0.0 { -distance } else { distance });
        MeshFootpoint {
            triangle: self.indices[place] as usize,
            barycentric: foot.barycentric,
            feature: foot.feature,
            point: foot.point,
            distance,
            signed_distance,
            normal: normal.try_normalize(0.0).unwrap_or_else(Vector3::zeros),
        }
    }

    /// The pseudo-normal, not of unit length, at a point of a triangle.
    pub(crate) fn pseudo_normal(&self, place: usize, feature: Feature, point: &Point3<f64>) -> Vector3<f64> {
        (self.normals.at(place, feature, &self.corners[place], &self.neighbours[place]))
            .unwrap_or_else(|| self.sum_at(point, |_| true))
    }

    /// The pseudo-normal from those triangles that pass through a point, whatever their indices say, and count.
    pub(crate) fn sum_at(&self, point: &Point3<f64>, counts: impl Fn(usize) -> bool) -> Vector3<f64> {
        let limit = self.meeting * self.meeting;
        let mut sum = Vector3::zeros();
        self.bvh.nearest(point, |place| {
            let shape = &self.triangles[place];
            let foot = shape.closest(point);
            if foot.distance_sq <= limit && counts(place) {
                sum += self.normals.share(place, shape, self.snapped(shape, &foot));
            }
            limit
        });
        sum
    }

    /// The feature of a foot, where a place within the meeting tolerance of an edge or corner is on it.
    fn snapped(&self, shape: &Triangle, foot: &TriangleFoot) -> Feature {
        let near = |point: &Point3<f64>| (point - foot.point).norm() <= self.meeting;
        if let Some(corner) = [0u8, 1, 2].into_iter().find(|&corner| near(&shape.0[usize::from(corner)])) {
            return Feature::Vertex(corner);
        }
        if foot.feature == Feature::Face {
            for edge in [0u8, 1, 2] {
                let (from, to) = (shape.0[usize::from(edge)], shape.0[usize::from(edge + 1) % 3]);
                let along = to - from;
                let height = along.cross(&(foot.point - from)).norm();
                if height <= self.meeting * along.norm() {
                    return Feature::Edge(edge);
                }
            }
        }
        foot.feature
    }
}
