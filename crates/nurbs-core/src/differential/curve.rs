//! Curvature, torsion and the moving frame of curves.

use crate::CurveJet;
use nalgebra::{SVector, Vector3};

/// Unit tangent, principal normal and curvature of a curve at a point.
///
/// It exists where the curve is regular and curved: at an inflection the principal normal has no
/// direction (see [`CurveJet::unit_tangent`] for what is left there).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FrenetFrame<const D: usize> {
    /// Unit tangent `c' / |c'|`.
    pub tangent: SVector<f64, D>,
    /// Principal normal: unit vector from the point towards the centre of curvature.
    pub normal: SVector<f64, D>,
    /// Curvature `κ > 0`, one over a length.
    pub curvature: f64,
}

impl FrenetFrame<3> {
    /// Binormal, `tangent × normal`.
    #[must_use]
    pub fn binormal(&self) -> Vector3<f64> {
        self.tangent.cross(&self.normal)
    }
}

impl<const D: usize> CurveJet<D> {
    /// Speed `|c'|`, length per unit of the parameter.
    #[must_use]
    pub fn speed(&self) -> f64 {
        self.d1.norm()
    }

    /// Unit tangent; `None` at a singular point (`c' = 0` or not finite).
    #[must_use]
    pub fn unit_tangent(&self) -> Option<SVector<f64, D>> {
        let speed = self.speed();
        (speed > 0.0 && speed.is_finite()).then(|| self.d1 / speed)
    }

    /// Curvature vector `κ n = c''_⊥ / |c'|²`, where `c''_⊥` is the part of `c''` normal to the curve.
    ///
    /// `None` at a singular point. Zero at an inflection.
    #[must_use]
    pub fn curvature_vector(&self) -> Option<SVector<f64, D>> {
        let tangent = self.unit_tangent()?;
        let speed = self.speed();
        // Divided twice: the square of a tiny speed underflows.
        let bend = self.d2 / speed;
        let vector = (bend - tangent * tangent.dot(&bend)) / speed;
        vector.iter().all(|c| c.is_finite()).then_some(vector)
    }

    /// Curvature `κ ≥ 0`, one over a length; `None` at a singular point.
    #[must_use]
    pub fn curvature(&self) -> Option<f64> {
        self.curvature_vector().map(|k| k.norm())
    }

    /// Centre of the osculating circle; `None` where the curvature vanishes or at a singular point.
    #[must_use]
    pub fn centre_of_curvature(&self) -> Option<SVector<f64, D>> {
        let k = self.curvature_vector()?;
        let centre = self.point + k / k.norm_squared();
        centre.iter().all(|c| c.is_finite()).then_some(centre)
    }

    /// Tangent and principal normal; `None` at singular points and where the curvature vanishes.
    #[must_use]
    pub fn frenet_frame(&self) -> Option<FrenetFrame<D>> {
        let tangent = self.unit_tangent()?;
        let k = self.curvature_vector()?;
        let curvature = k.norm();
        // A straight piece leaves nothing but rounding error, whose direction means nothing.
        let noise = 8.0 * f64::EPSILON * self.d2.norm() / self.d1.norm_squared();
        (curvature > noise).then(|| {
            let normal = k / curvature;
            // Once more: cancellation in κ n leaves a tangential part when the acceleration is nearly tangential.
            let normal = (normal - tangent * tangent.dot(&normal)).normalize();
            FrenetFrame { tangent, normal, curvature }
        })
    }
}

impl CurveJet<2> {
    /// Signed curvature `det(c', c'') / |c'|³`, positive where the curve turns left; `None` at a singular point.
    #[must_use]
    pub fn signed_curvature(&self) -> Option<f64> {
        let speed = self.speed();
        let t = self.unit_tangent()?;
        let kappa = (t.x * self.d2.y - t.y * self.d2.x) / speed / speed;
        kappa.is_finite().then_some(kappa)
    }
}

impl CurveJet<3> {
    /// Torsion `τ = det(c', c'', c''') / |c' × c''|²` from the third derivative `d3`, one over a length.
    ///
    /// Positive for a right-handed helix. `None` at singular points and where the curvature vanishes.
    #[must_use]
    pub fn torsion(&self, d3: &Vector3<f64>) -> Option<f64> {
        let frame = self.frenet_frame()?;
        let speed = self.speed();
        // c''' · b = κ τ |c'|³, since all other parts of c''' lie in the osculating plane.
        let torsion = frame.binormal().dot(d3) / (frame.curvature * speed * speed * speed);
        torsion.is_finite().then_some(torsion)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector2;

    #[test]
    fn helix_has_constant_curvature_and_torsion() {
        let (r, h) = (2.0, 0.5);
        for i in 0..10 {
            let (s, c) = (0.7 * f64::from(i)).sin_cos();
            let jet = CurveJet {
                point: Vector3::new(r * c, r * s, h * 0.7 * f64::from(i)),
                d1: Vector3::new(-r * s, r * c, h),
                d2: Vector3::new(-r * c, -r * s, 0.0),
            };
            let d3 = Vector3::new(r * s, -r * c, 0.0);
            let frame = jet.frenet_frame().unwrap();
            assert!((frame.curvature - r / (r * r + h * h)).abs() < 1e-14);
            assert!((jet.torsion(&d3).unwrap() - h / (r * r + h * h)).abs() < 1e-14);
            assert!((frame.normal - Vector3::new(-c, -s, 0.0)).norm() < 1e-14);
        }
    }

    #[test]
    fn singular_and_straight_points_have_no_frame() {
        let cusp = CurveJet { point: Vector2::zeros(), d1: Vector2::zeros(), d2: Vector2::x() };
        assert!(cusp.unit_tangent().is_none() && cusp.curvature().is_none() && cusp.frenet_frame().is_none());
        let line =
            CurveJet { point: Vector2::zeros(), d1: Vector2::new(0.1, 0.3), d2: Vector2::new(0.7, 2.1) };
        assert!(line.curvature().unwrap() < 1e-14);
        assert!(line.frenet_frame().is_none());
        assert!(CurveJet { d1: Vector2::repeat(f64::NAN), ..line }.unit_tangent().is_none());
    }
}
