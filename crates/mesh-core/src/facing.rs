//! Closest points and crossings among the triangles that face a direction.

use crate::bounds::is_finite;
use crate::line_hit::LineHit;
use crate::normal_cone::NormalCone;
use crate::triangle::{Feature, TriangleFoot};
use crate::{Error, MeshFootpoint, MeshProjector};
use nalgebra::{Point3, Vector3};

/// The closest point on those triangles of a mesh that face a direction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FacingFootpoint {
    /// The point.
    pub foot: MeshFootpoint,
    /// Whether it is the closest one of the whole mesh.
    pub is_nearest: bool,
}

impl MeshProjector {
    /// The closest point to `x` on the triangles whose normals are within `max_angle` (radians) of `direction`, a vector
    /// of length 1; `None` if there is no such triangle.
    ///
    /// A normal is within the angle when the cosine of the angle between the two is at least `max_angle.cos()`: at a right
    /// angle, a triangle that stands upright does not count. Triangles without area never count.
    ///
    /// If a triangle that counts passes through the closest point of the whole mesh, then the answer is that of
    /// [`project`](Self::project). Otherwise the normal, and the sign of the distance where the mesh is a solid, are those of
    /// the triangles that count, weighted by their angles.
    ///
    /// ```
    /// use mesh_core::{MeshProjector, TriangleMesh, nalgebra::{Point3, Vector3}};
    ///
    /// // The top of a plate faces upwards, its bottom, half a unit below, downwards.
    /// let at = |z: f64| [[0.0, 0.0, z], [4.0, 0.0, z], [0.0, 4.0, z]].map(Point3::from);
    /// let plate = TriangleMesh::new([at(0.0), at(-0.5)].concat(), vec![[0, 1, 2], [3, 5, 4]])?;
    /// let plate = MeshProjector::new(&plate)?;
    /// let x = Point3::new(1.0, 1.0, -0.4);
    /// assert_eq!(plate.project(&x)?.triangle, 1);
    /// let found = plate.project_facing(&x, &Vector3::z(), 1.0)?.ok_or("no triangle faces up")?;
    /// assert_eq!((found.foot.triangle, found.foot.distance, found.is_nearest), (0, 0.4, false));
    /// assert_eq!(plate.project_facing(&x, &Vector3::x(), 1.0)?, None);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// As [`project`](Self::project).
    pub fn project_facing(
        &self,
        x: &Point3<f64>,
        direction: &Vector3<f64>,
        max_angle: f64,
    ) -> Result<Option<FacingFootpoint>, Error> {
        let nearest = self.project(x)?;
        let facing = Facing { direction, max_angle, cosine: max_angle.cos() };
        let place = self.place_of(nearest.triangle);
        let own = place.is_some_and(|place| facing.agrees(self.normals.face(place)));
        if own || nearest.feature != Feature::Face && self.any_faces(&nearest.point, &facing) {
            return Ok(Some(FacingFootpoint { foot: nearest, is_nearest: true }));
        }
        let Some((place, foot)) = self.nearest_facing(x, &facing) else { return Ok(None) };
        let normal = match foot.feature {
            Feature::Face => *self.normals.face(place),
            _ => self.facing_normal(&foot.point, direction, max_angle),
        };
        let distance = foot.distance_sq.sqrt();
        let signed = || if (x - foot.point).dot(&normal) < 0.0 { -distance } else { distance };
        let foot = MeshFootpoint {
            triangle: self.indices[place] as usize,
            barycentric: foot.barycentric,
            feature: foot.feature,
            point: foot.point,
            distance,
            signed_distance: self.is_solid().then(signed),
            normal,
        };
        Ok(Some(FacingFootpoint { foot, is_nearest: false }))
    }

    /// The point nearest to `origin` in which the line through it along `line` meets a triangle whose normal is within
    /// `max_angle` of `direction`, a vector of length 1. See [`nearest_on_line`](Self::nearest_on_line) and
    /// [`project_facing`](Self::project_facing).
    ///
    /// # Errors
    /// As [`nearest_on_line`](Self::nearest_on_line).
    pub fn nearest_on_line_facing(
        &self,
        origin: &Point3<f64>,
        line: &Vector3<f64>,
        direction: &Vector3<f64>,
        max_angle: f64,
    ) -> Result<Option<LineHit>, Error> {
        let facing = Facing { direction, max_angle, cosine: max_angle.cos() };
        let cones = self.cones();
        self.nearest_on_line_where(
            origin,
            line,
            |node| cones[node].may_face(direction, max_angle),
            |place| facing.agrees(self.normals.face(place)),
        )
    }

    /// The unit normal, weighted by their angles, of the triangles at a point of the mesh whose normals are within `max_angle`
    /// of `direction`; zero if there is none.
    #[must_use]
    pub fn facing_normal(
        &self,
        point: &Point3<f64>,
        direction: &Vector3<f64>,
        max_angle: f64,
    ) -> Vector3<f64> {
        let facing = Facing { direction, max_angle, cosine: max_angle.cos() };
        let sum = self.sum_at(point, |place| facing.agrees(self.normals.face(place)));
        sum.try_normalize(0.0).unwrap_or_else(Vector3::zeros)
    }

    /// The unit normal that [`project`](Self::project) gives for a foot, from where that is; zero for a triangle that does
    /// not take part.
    #[must_use]
    pub fn normal_at(&self, triangle: usize, feature: Feature, point: &Point3<f64>) -> Vector3<f64> {
        self.place_of(triangle).map_or_else(Vector3::zeros, |place| {
            self.pseudo_normal(place, feature, point).try_normalize(0.0).unwrap_or_else(Vector3::zeros)
        })
    }

    /// The unit normal of a triangle; zero if it has no area, or does not take part.
    #[must_use]
    pub fn face_normal(&self, triangle: usize) -> Vector3<f64> {
        self.place_of(triangle).map_or_else(Vector3::zeros, |place| *self.normals.face(place))
    }

    /// Where a triangle of the mesh stands in the hierarchy.
    pub(crate) fn place_of(&self, triangle: usize) -> Option<usize> {
        let places = self.places.get_or_init(|| {
            let count = self.indices.iter().max().map_or(0, |&last| last as usize + 1);
            let mut places = vec![u32::MAX; count];
            for (&index, place) in self.indices.iter().zip(0u32..) {
                places[index as usize] = place;
            }
            places
        });
        places.get(triangle).filter(|&&place| place != u32::MAX).map(|&place| place as usize)
    }

    /// The normals under each node of the hierarchy, prepared when they are first needed.
    fn cones(&self) -> &[NormalCone] {
        self.cones.get_or_init(|| {
            let of = |place: usize| NormalCone::of(self.normals.face(place));
            self.bvh.gathered(
                &NormalCone::EMPTY,
                |places| places.fold(NormalCone::EMPTY, |cone, place| cone.merged(&of(place))),
                NormalCone::merged,
            )
        })
    }

    /// Whether a triangle at a point of the mesh faces the direction.
    fn any_faces(&self, point: &Point3<f64>, facing: &Facing<'_>) -> bool {
        let limit = self.meeting * self.meeting;
        let mut found = false;
        self.bvh.nearest(point, |place| {
            found |= facing.agrees(self.normals.face(place))
                && self.triangles[place].closest(point).distance_sq <= limit;
            limit
        });
        found
    }

    fn nearest_facing(&self, x: &Point3<f64>, facing: &Facing<'_>) -> Option<(usize, TriangleFoot)> {
        if !is_finite(x) {
            return None;
        }
        let cones = self.cones();
        let keeps = |node: usize| cones[node].may_face(facing.direction, facing.max_angle);
        let mut best: Option<(usize, TriangleFoot)> = None;
        let mut limit = f64::INFINITY;
        self.bvh.nearest_where(x, f64::INFINITY, keeps, |place| {
            if facing.agrees(self.normals.face(place)) {
                let foot = self.triangles[place].closest(x);
                let tied = foot.distance_sq == limit
                    && best.is_some_and(|(best, _)| self.indices[place] < self.indices[best]);
                if foot.distance_sq < limit || tied {
                    limit = foot.distance_sq;
                    best = Some((place, foot));
                }
            }
            limit
        });
        best
    }
}

/// Which normals count.
struct Facing<'a> {
    direction: &'a Vector3<f64>,
    max_angle: f64,
    cosine: f64,
}

impl Facing<'_> {
    fn agrees(&self, normal: &Vector3<f64>) -> bool {
        *normal != Vector3::zeros() && normal.dot(self.direction) >= self.cosine
    }
}
