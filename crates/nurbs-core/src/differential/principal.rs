//! Principal curvatures and directions.

use crate::SurfaceJet;
use nalgebra::{Vector2, Vector3};

/// Normal, principal curvatures and principal directions of a surface at a regular point.
///
/// `directions[0] × directions[1] = normal`. At an umbilic (`κ₁ = κ₂`, planes and spheres included)
/// every tangent direction is principal; then the first one is that of `∂s/∂u`, always the same for
/// the same jet.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PrincipalFrame {
    /// Unit normal.
    pub normal: Vector3<f64>,
    /// Principal curvatures `κ₁ ≥ κ₂`, one over a length, positive where the surface bends towards the
    /// normal.
    pub curvatures: [f64; 2],
    /// Unit tangent vectors of the principal directions.
    pub directions: [Vector3<f64>; 2],
    /// The same vectors in parameters: `directions[i] = x ∂s/∂u + y ∂s/∂v`.
    pub parameter_directions: [Vector2<f64>; 2],
}

impl SurfaceJet {
    /// Principal curvatures and directions; `None` where the surface is not regular
    /// (see [`unit_normal`](Self::unit_normal)).
    ///
    /// They are the eigenvalues and eigenvectors of the second fundamental form in an orthonormal
    /// basis of the tangent plane, found by one Jacobi rotation.
    #[must_use]
    pub fn principal_frame(&self) -> Option<PrincipalFrame> {
        let operator = self.shape_operator()?;
        let ([t1, t2], [a, b, c], [r, p, q]) = (operator.tangents, operator.form, operator.parameters);
        let half = 0.5 * (a - c);
        let radius = (half * half + b * b).sqrt();
        let mean = 0.5 * (a + c);
        // Rounding alone tears umbilics apart by a few units in the last place.
        let umbilic = radius <= 16.0 * f64::EPSILON * (a.abs() + c.abs());
        let (cosine, sine) = if umbilic {
            (1.0, 0.0)
        } else {
            // The direction of κ₁ makes the angle φ with t₁, where (cos 2φ, sin 2φ) = (half, b) / radius; the larger of
            // its two components comes from the half angle, the other from the double one.
            let larger = (0.5 + 0.5 * half.abs() / radius).sqrt();
            let smaller = 0.5 * b.abs() / (radius * larger);
            if half >= 0.0 { (larger, smaller.copysign(b)) } else { (smaller, larger.copysign(b)) }
        };
        let directions = [t1 * cosine + t2 * sine, t2 * cosine - t1 * sine];
        let to_parameters = |x: f64, y: f64| {
            let v = y / q;
            Vector2::new((x - v * p) / r, v)
        };
        Some(PrincipalFrame {
            normal: operator.normal,
            curvatures: [mean + radius, mean - radius],
            directions,
            parameter_directions: [to_parameters(cosine, sine), to_parameters(-sine, cosine)],
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Monge patch `z = (a x² + 2 b xy + c y²) / 2` at the origin, sheared in the parameters.
    fn monge(a: f64, b: f64, c: f64, shear: f64) -> SurfaceJet {
        let form = |p: Vector2<f64>, q: Vector2<f64>| {
            Vector3::new(0.0, 0.0, a * p.x * q.x + b * (p.x * q.y + p.y * q.x) + c * p.y * q.y)
        };
        let (u, v) = (Vector2::new(2.0, 0.0), Vector2::new(shear, 0.5));
        SurfaceJet {
            point: Vector3::zeros(),
            du: Vector3::new(u.x, u.y, 0.0),
            dv: Vector3::new(v.x, v.y, 0.0),
            duu: form(u, u),
            duv: form(u, v),
            dvv: form(v, v),
        }
    }

    #[test]
    fn known_principal_curvatures() {
        let jet = monge(3.0, 0.0, -1.0, 0.7);
        let frame = jet.principal_frame().unwrap();
        assert!((frame.curvatures[0] - 3.0).abs() < 1e-14 && (frame.curvatures[1] + 1.0).abs() < 1e-14);
        assert!((frame.directions[0].x.abs() - 1.0).abs() < 1e-14);
        assert!((jet.gauss_curvature().unwrap() + 3.0).abs() < 1e-13);
        assert!((jet.mean_curvature().unwrap() - 1.0).abs() < 1e-14);
        for i in 0..2 {
            let d = frame.parameter_directions[i];
            assert!((jet.du * d.x + jet.dv * d.y - frame.directions[i]).norm() < 1e-14);
            assert!((jet.normal_curvature(&d).unwrap() - frame.curvatures[i]).abs() < 1e-13);
        }
        assert!((frame.directions[0].cross(&frame.directions[1]) - frame.normal).norm() < 1e-14);
    }

    #[test]
    fn umbilics_and_singular_points() {
        let frame = monge(2.0, 0.0, 2.0, 0.0).principal_frame().unwrap();
        assert_eq!(frame.directions[0], Vector3::x());
        let pole = SurfaceJet { du: Vector3::zeros(), ..monge(1.0, 0.0, 1.0, 0.0) };
        assert!(pole.principal_frame().is_none());
        let fold = SurfaceJet { dv: Vector3::x() * 7.0, ..monge(1.0, 0.0, 1.0, 0.0) };
        assert!(fold.unit_normal().is_none() && fold.gauss_curvature().is_none());
    }
}
