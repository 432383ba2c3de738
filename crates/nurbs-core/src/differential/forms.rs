//! First and second fundamental form, unit normal, Gauss and mean curvature.

use crate::SurfaceJet;
use nalgebra::{Vector2, Vector3};

/// Sine of the angle between `∂s/∂u` and `∂s/∂v` below which a surface point counts as singular.
const PARALLEL: f64 = 1e-12;

/// Part of a unit of the parameter at which a partial derivative that grows from zero counts as zero.
const COLLAPSED: f64 = 1e-14;

/// First fundamental form `I(a, b) = E a² + 2 F ab + G b²`: squared lengths of tangent vectors
/// `a ∂s/∂u + b ∂s/∂v`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FirstForm {
    /// `E = ⟨s_u, s_u⟩`.
    pub e: f64,
    /// `F = ⟨s_u, s_v⟩`.
    pub f: f64,
    /// `G = ⟨s_v, s_v⟩`.
    pub g: f64,
}

/// Second fundamental form `II(a, b) = L a² + 2 M ab + N b²` with respect to the unit normal
/// `n = s_u × s_v / |s_u × s_v|`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SecondForm {
    /// `L = ⟨s_uu, n⟩`.
    pub l: f64,
    /// `M = ⟨s_uv, n⟩`.
    pub m: f64,
    /// `N = ⟨s_vv, n⟩`.
    pub n: f64,
}

impl FirstForm {
    /// The value of the form at `direction`.
    #[must_use]
    pub fn at(&self, direction: &Vector2<f64>) -> f64 {
        let (a, b) = (direction.x, direction.y);
        self.e * a * a + 2.0 * self.f * a * b + self.g * b * b
    }

    /// `EG − F²`, the square of the area element.
    #[must_use]
    pub fn determinant(&self) -> f64 {
        self.e * self.g - self.f * self.f
    }
}

impl SecondForm {
    /// The value of the form at `direction`.
    #[must_use]
    pub fn at(&self, direction: &Vector2<f64>) -> f64 {
        let (a, b) = (direction.x, direction.y);
        self.l * a * a + 2.0 * self.m * a * b + self.n * b * b
    }

    /// `LN − M²`.
    #[must_use]
    pub fn determinant(&self) -> f64 {
        self.l * self.n - self.m * self.m
    }
}

impl SurfaceJet {
    /// Unit normal `s_u × s_v / |s_u × s_v|`.
    ///
    /// `None` where the surface is not regular: a partial derivative vanishes (a pole, a collapsed
    /// edge), the two are parallel within `1e-12`, or a number is not finite. A partial derivative
    /// counts as vanished when it is below `1e-14` of its own derivatives, so a parameter that far
    /// from a pole is taken for the pole.
    #[must_use]
    pub fn unit_normal(&self) -> Option<Vector3<f64>> {
        let (a, b) = (self.du.norm(), self.dv.norm());
        let finite = a.is_finite() && b.is_finite();
        let collapsed = a <= COLLAPSED * (self.duu.norm() + self.duv.norm())
            || b <= COLLAPSED * (self.duv.norm() + self.dvv.norm());
        if !finite || collapsed || a == 0.0 || b == 0.0 {
            return None;
        }
        // Unit vectors first: lengths of very different scale would underflow in the product.
        let cross = (self.du / a).cross(&(self.dv / b));
        let sine = cross.norm();
        (sine > PARALLEL).then(|| cross / sine)
    }

    /// First fundamental form.
    #[must_use]
    pub fn first_form(&self) -> FirstForm {
        FirstForm { e: self.du.norm_squared(), f: self.du.dot(&self.dv), g: self.dv.norm_squared() }
    }

    /// Second fundamental form; `None` where there is no normal.
    #[must_use]
    pub fn second_form(&self) -> Option<SecondForm> {
        let normal = self.unit_normal()?;
        Some(SecondForm { l: self.duu.dot(&normal), m: self.duv.dot(&normal), n: self.dvv.dot(&normal) })
    }

    /// Normal curvature `II / I` in the direction `(a, b)` of the parameter plane, one over a length.
    ///
    /// Positive where the surface bends towards its normal. `None` where the surface is not regular
    /// and for the zero direction.
    #[must_use]
    pub fn normal_curvature(&self, direction: &Vector2<f64>) -> Option<f64> {
        let curvature = self.second_form()?.at(direction) / self.first_form().at(direction);
        curvature.is_finite().then_some(curvature)
    }

    /// Gauss curvature `K = κ₁ κ₂`; `None` where the surface is not regular.
    #[must_use]
    pub fn gauss_curvature(&self) -> Option<f64> {
        self.shape_operator().map(|ShapeOperator { form: [a, b, c], .. }| a * c - b * b)
    }

    /// Mean curvature `H = (κ₁ + κ₂) / 2` with respect to the normal; `None` where the surface is not
    /// regular. A sphere of radius `r` whose normal points outwards has `H = −1/r`.
    #[must_use]
    pub fn mean_curvature(&self) -> Option<f64> {
        self.shape_operator().map(|ShapeOperator { form: [a, _, c], .. }| 0.5 * (a + c))
    }

    /// The second fundamental form in an orthonormal basis of the tangent plane.
    #[inline]
    pub(super) fn shape_operator(&self) -> Option<ShapeOperator> {
        let normal = self.unit_normal()?;
        // s_v = p t₁ + q t₂, s_u = r t₁; the form is transformed by the inverse of this triangle.
        let r = self.du.norm();
        let first = self.du / r;
        let second = normal.cross(&first);
        let (p, q) = (self.dv.dot(&first), self.dv.dot(&second));
        let (l, m, n) = (self.duu.dot(&normal), self.duv.dot(&normal), self.dvv.dot(&normal));
        let a = l / r / r;
        let b = (m / r - a * p) / q;
        let c = (n / q - (2.0 * b * p + a * p * p / q)) / q;
        let operator =
            ShapeOperator { normal, tangents: [first, second], form: [a, b, c], parameters: [r, p, q] };
        (a.is_finite() && b.is_finite() && c.is_finite()).then_some(operator)
    }
}

/// The second fundamental form of a regular point in orthonormal coordinates.
#[derive(Clone, Copy, Debug)]
pub(super) struct ShapeOperator {
    /// Unit normal `n`.
    pub(super) normal: Vector3<f64>,
    /// Orthonormal tangent vectors `t₁ ∥ s_u`, `t₂` with `t₁ × t₂ = n`.
    pub(super) tangents: [Vector3<f64>; 2],
    /// The entries `a, b, c` of the symmetric matrix `[a b; b c]` of the form in this basis.
    pub(super) form: [f64; 3],
    /// `r, p, q` with `s_u = r t₁`, `s_v = p t₁ + q t₂`.
    pub(super) parameters: [f64; 3],
}
