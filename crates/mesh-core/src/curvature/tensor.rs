//! The second fundamental form at a point, as frame and as tensor.

use nalgebra::{Matrix3, Vector3};

use crate::normals::unit;

/// Normal, principal curvatures and directions at a point of a surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CurvatureFrame {
    /// Unit normal.
    pub normal: Vector3<f64>,
    /// Principal curvatures `κ₁ ≥ κ₂`, one over a length, positive where the surface bends towards the normal.
    pub curvatures: [f64; 2],
    /// Unit tangent vectors of the principal directions; with the normal as third a right-handed frame.
    pub directions: [Vector3<f64>; 2],
}

impl CurvatureFrame {
    /// The frame of a symmetric tensor, of which the part in the tangent plane counts. The normal is a unit vector.
    pub(crate) fn of_tensor(tensor: &Matrix3<f64>, normal: &Vector3<f64>) -> Option<Self> {
        let [x, y] = tangents(normal)?;
        let (tx, ty) = (tensor * x, tensor * y);
        Self::of_form([x.dot(&tx), x.dot(&ty), y.dot(&ty)], [x, y], normal)
    }

    /// The frame of a form `(a, b, c)`: `a ξ² + 2 b ξ η + c η²` on orthonormal tangent vectors.
    pub(crate) fn of_form(
        [a, b, c]: [f64; 3],
        [x, y]: [Vector3<f64>; 2],
        normal: &Vector3<f64>,
    ) -> Option<Self> {
        if ![a, b, c].iter().all(|value| value.is_finite()) {
            return None;
        }
        let (mean, half) = (0.5 * a + 0.5 * c, 0.5 * a - 0.5 * c);
        let radius = half.hypot(b);
        // Twice the angle of the first direction; anything where the curvatures are equal.
        let angle = 0.5 * b.atan2(half);
        let first = x * angle.cos() + y * angle.sin();
        Some(Self {
            normal: *normal,
            curvatures: [mean + radius, mean - radius],
            directions: [first, normal.cross(&first)],
        })
    }

    /// Mean curvature `(κ₁ + κ₂) / 2`.
    #[must_use]
    pub fn mean(&self) -> f64 {
        0.5 * (self.curvatures[0] + self.curvatures[1])
    }

    /// Gaussian curvature `κ₁ κ₂`.
    #[must_use]
    pub fn gaussian(&self) -> f64 {
        self.curvatures[0] * self.curvatures[1]
    }

    /// `κ₁ d₁ d₁ᵀ + κ₂ d₂ d₂ᵀ`: the second fundamental form, extended by zero along the normal.
    ///
    /// Unlike frames, tensors of neighbouring points can be averaged.
    #[must_use]
    pub fn tensor(&self) -> Matrix3<f64> {
        let [first, second] = self.directions;
        first * first.transpose() * self.curvatures[0] + second * second.transpose() * self.curvatures[1]
    }

    /// The same surface seen from its other side.
    #[must_use]
    pub fn flipped(&self) -> Self {
        let [first, second] = self.directions;
        Self {
            normal: -self.normal,
            curvatures: [-self.curvatures[1], -self.curvatures[0]],
            directions: [second, first],
        }
    }
}

/// Two unit vectors that form a right-handed frame with a unit normal; `None` for a zero vector.
pub(crate) fn tangents(normal: &Vector3<f64>) -> Option<[Vector3<f64>; 2]> {
    let axis = Vector3::ith(normal.iamin(), 1.0);
    let first = unit(&normal.cross(&axis))?;
    Some([first, normal.cross(&first)])
}

/// A tensor tangential to `from`, turned with the rotation of least angle that takes `from` to `to` (unit vectors).
pub(crate) fn transported(tensor: &Matrix3<f64>, from: &Vector3<f64>, to: &Vector3<f64>) -> Matrix3<f64> {
    let cosine = from.dot(to);
    if cosine < -0.999 {
        // Turned over: the axis is undetermined, the tangent plane the same.
        return *tensor;
    }
    let axis = from.cross(to);
    let cross = axis.cross_matrix();
    let rotation = Matrix3::identity() + cross + cross * cross / (1.0 + cosine);
    rotation * tensor * rotation.transpose()
}
