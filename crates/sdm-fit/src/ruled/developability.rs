//! How far a ruled surface is from being developable.

use crate::Error;
use nalgebra::{Matrix3, Vector3};
use nurbs_core::{BsplineSurface, Interval};

/// Rulings per span at which angles are measured.
const PER_SPAN: usize = 8;

/// Angles between the normals at the two ends of a ruling: 0 along all of them on developable surfaces, which unroll into the
/// plane without stretching, and along which a cylindrical cutter of any radius touches exactly.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Developability {
    /// Largest angle in radians.
    pub max_angle: f64,
    /// Root mean square of the angles in radians.
    pub rms_angle: f64,
    /// Rulings with a normal at both ends.
    pub rulings: usize,
}

impl Developability {
    /// Of a surface of degree 1 in v, with or without weights, in all its layers.
    ///
    /// # Errors
    /// [`Error::NotRuled`] for another degree.
    pub fn of(surface: &BsplineSurface) -> Result<Self, Error> {
        if surface.degree_v() != 1 {
            return Err(Error::NotRuled { degree: surface.degree_v() });
        }
        let (knots_u, knots_v) = (surface.knots_u(), surface.knots_v());
        let (mut square, mut max_angle, mut rulings) = (0.0, 0.0f64, 0);
        for span_u in knots_u.spans() {
            let interval = knots_u.span_interval(span_u);
            for k in 0..PER_SPAN {
                let u = interval.lerp((k as f64 + 0.5) / PER_SPAN as f64);
                for span_v in knots_v.spans() {
                    let ends: Interval = knots_v.span_interval(span_v);
                    let normal = |v: f64| {
                        let jet = surface.jet_in_span(span_u, span_v, u, v);
                        jet.du.cross(&jet.dv).try_normalize(0.0)
                    };
                    let (Some(a), Some(b)) = (normal(ends.start()), normal(ends.end())) else { continue };
                    let angle = a.cross(&b).norm().atan2(a.dot(&b));
                    square += angle * angle;
                    max_angle = max_angle.max(angle);
                    rulings += 1;
                }
            }
        }
        Ok(Self {
            max_angle,
            rms_angle: (square / f64::from(rulings.max(1))).sqrt(),
            rulings: rulings as usize,
        })
    }
}

impl std::fmt::Display for Developability {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let (rms, max) = (self.rms_angle.to_degrees(), self.max_angle.to_degrees());
        write!(f, "normals turn by {rms:.3}° (rms), {max:.3}° (max) along {} rulings", self.rulings)
    }
}

/// The difference of the unit normals at the ends of a ruling `r = q − p`, `p' × r` and `q' × r` made unit vectors, and its
/// derivatives by `p'`, `q'` and `r`; `None` where a normal vanishes.
///
/// Its length is twice the sine of half the angle between them: unlike `det(p', q', r)`, it does not vanish on rulings that are
/// twisted by half a turn.
pub(super) fn twist(
    p: &Vector3<f64>,
    q: &Vector3<f64>,
    r: &Vector3<f64>,
) -> Option<(Vector3<f64>, [Matrix3<f64>; 3])> {
    let unit = |end: &Vector3<f64>| {
        let normal = end.cross(r);
        let length = normal.norm();
        let unit = normal / length;
        let change = (Matrix3::identity() - unit * unit.transpose()) / length;
        (length > 0.0 && change.iter().all(|c| c.is_finite())).then_some((unit, change))
    };
    let ((a, by_a), (b, by_b)) = (unit(p)?, unit(q)?);
    let turn = r.cross_matrix();
    Some((a - b, [-by_a * turn, by_b * turn, by_a * p.cross_matrix() - by_b * q.cross_matrix()]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn derivatives_of_the_twist_agree_with_differences() {
        let at = [Vector3::new(1.0, 0.2, -0.3), Vector3::new(0.7, 1.1, 0.4), Vector3::new(0.1, -0.2, 2.0)];
        let (value, gradient) = twist(&at[0], &at[1], &at[2]).unwrap();
        let angle = at[0].cross(&at[2]).angle(&at[1].cross(&at[2]));
        assert!((value.norm() - 2.0 * (0.5 * angle).sin()).abs() < 1e-14);
        for k in 0..3 {
            for c in 0..3 {
                let shifted = |h: f64| {
                    let mut moved = at;
                    moved[k][c] += h;
                    twist(&moved[0], &moved[1], &moved[2]).unwrap().0
                };
                let difference = (shifted(1e-6) - shifted(-1e-6)) / 2e-6;
                assert!((difference - gradient[k].column(c)).norm() < 1e-9, "{k} {c}");
            }
        }
        assert!(twist(&at[0], &at[1], &Vector3::zeros()).is_none());
        assert!(twist(&at[2], &at[1], &at[2]).is_none());
    }
}
