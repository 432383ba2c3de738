//! What the minimisation asks of a shape.

use super::Elements;
use super::random::Random;
use nalgebra::{Rotation3, SVector, Vector3};

/// Most unknowns of a shape (those of the torus).
pub(super) const MAX_UNKNOWNS: usize = 7;

/// Changes of the unknowns; those beyond the shape's own are not looked at.
pub(super) type Step = [f64; MAX_UNKNOWNS];

/// One component of the shortest vector between a point and a shape, with its derivatives by the unknowns.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Row {
    pub(super) residual: f64,
    pub(super) slopes: Step,
}

/// A shape in a position of its own, with unknowns that are displacements from where it is.
///
/// The unknowns are rigid motions about a point of the shape near the data, and changes of size that keep this point and the
/// tangent plane there (of radii, the curvature is the unknown). Columns of the Jacobian then stay well apart for the
/// smallest arcs, where centre and radius nearly tell the same.
pub(super) trait Model<const D: usize>: Clone + Send + Sync {
    /// Number of unknowns.
    const UNKNOWNS: usize;
    /// Number of components: the codimension of the shape.
    const ROWS: usize;
    /// Whether sums of squares have several minima as a rule.
    const SEVERAL: bool;
    /// Random starts where there are few minima.
    const RANDOM_STARTS: usize = 0;

    /// Starts that the points suggest, good ones for points near a shape; none if they leave it open.
    fn starts(points: &[SVector<f64, D>]) -> Vec<Self>;

    /// Up to about `count` shapes near as many points as there are unknowns.
    fn from_few(points: &[SVector<f64, D>], random: &mut Random, count: usize) -> Vec<Self>;

    /// Components of the shortest vector from the shape to `x`, of square sum `d²`. Those beyond [`Self::ROWS`] are 0.
    fn residuals(&self, x: &SVector<f64, D>) -> [f64; 2];

    /// The same with derivatives.
    fn rows(&self, x: &SVector<f64, D>) -> [Row; 2];

    /// The shape after a step; `None` if there is none.
    fn moved(&self, step: &Step) -> Option<Self>;

    /// Location, direction and sizes, the location as near to `centre` as the shape leaves it open.
    fn elements(&self, centre: &SVector<f64, D>) -> Elements<D>;

    /// Whether it is a shape of the kind asked for; the search may pass through others.
    fn is_proper(&self) -> bool {
        true
    }

    /// A shape of the kind asked for near this one.
    fn made_proper(self) -> Option<Self> {
        self.is_proper().then_some(self)
    }

    /// 1 if residuals of shapes with two sides are positive outside (above, on the left), else −1.
    fn outside(&self) -> f64 {
        1.0
    }

    /// `d²`.
    fn distance_sq(&self, x: &SVector<f64, D>) -> f64 {
        let [a, b] = self.residuals(x);
        a * a + b * b
    }
}

/// A point with an axis, and the direction from the axis towards the data.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pose {
    /// A point of the axis.
    pub(super) point: Vector3<f64>,
    /// Unit vector along the axis.
    pub(super) z: Vector3<f64>,
    /// Unit vector normal to the axis.
    pub(super) e: Vector3<f64>,
}

impl Pose {
    /// The axis through a point; its own point is the one nearest to the origin, where the data are, and so is `e`.
    pub(super) fn towards_origin(point: Vector3<f64>, direction: Vector3<f64>, radius: f64) -> Self {
        let z = direction.normalize();
        let foot = point - z * point.dot(&z);
        let off = foot.norm();
        let e = if off > 0.1 * radius && off > 0.0 { -foot / off } else { normal_to(&z) };
        Self { point: foot, z, e: orthonormal(&z, &e) }
    }

    /// Third axis.
    pub(super) fn t(&self) -> Vector3<f64> {
        self.z.cross(&self.e)
    }

    /// Cylinder coordinates of a point: outward unit vector, distance from the axis, height.
    pub(super) fn cylindrical(&self, x: &Vector3<f64>) -> (Vector3<f64>, f64, f64) {
        let d = x - self.point;
        let height = d.dot(&self.z);
        let out = d - self.z * height;
        let distance = out.norm();
        if distance > 0.0 { (out / distance, distance, height) } else { (self.e, 0.0, height) }
    }

    /// The pose turned by a rotation vector about a pivot and then displaced.
    pub(super) fn moved(&self, rotation: Vector3<f64>, pivot: &Vector3<f64>, shift: Vector3<f64>) -> Self {
        let turn = Rotation3::from_scaled_axis(rotation);
        let z = (turn * self.z).normalize();
        Self { point: pivot + turn * (self.point - pivot) + shift, z, e: orthonormal(&z, &(turn * self.e)) }
    }

    /// Whether all numbers are finite.
    pub(super) fn is_finite(&self) -> bool {
        [self.point, self.z, self.e].iter().all(|v| v.iter().all(|c| c.is_finite()))
    }

    /// The point of the axis nearest to another one.
    pub(super) fn nearest(&self, x: &Vector3<f64>) -> Vector3<f64> {
        self.point + self.z * (x - self.point).dot(&self.z)
    }
}

/// Derivative of a component along the unit vector `n` at `x` when the shape turns about `axis` through `pivot`.
pub(super) fn turning(n: &Vector3<f64>, x: &Vector3<f64>, pivot: &Vector3<f64>, axis: &Vector3<f64>) -> f64 {
    -axis.dot(&(x - pivot).cross(n))
}

/// A unit vector normal to a unit vector.
pub(crate) fn normal_to(z: &Vector3<f64>) -> Vector3<f64> {
    let mut reference = Vector3::zeros();
    reference[z.iamin()] = 1.0;
    orthonormal(z, &reference)
}

/// The direction of the part of `v` that is normal to the unit vector `z`.
pub(super) fn orthonormal<const D: usize>(z: &SVector<f64, D>, v: &SVector<f64, D>) -> SVector<f64, D> {
    (v - z * v.dot(z)).normalize()
}
