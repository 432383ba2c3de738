//! Bounds on the second derivatives of Bézier patches.

use crate::BezierPatch;
use crate::bernstein::Net;
use nalgebra::Vector1;

/// Parts per direction into which rational patches are cut: the bound divides by the third power of
/// the smallest weight, which hardly differs from the others on a small part.
const PARTS: usize = 4;

/// Upper bounds of `|s_uu|`, `|s_uv|`, `|s_vv|` on a patch whose parameters run over the unit square.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct SecondBounds {
    pub(super) uu: f64,
    pub(super) uv: f64,
    pub(super) vv: f64,
}

impl SecondBounds {
    /// Bound on the distance of a patch from its triangles when it is cut into `n × m` cells
    /// (\[FMM86\]).
    pub(super) fn deviation(&self, n: f64, m: f64) -> f64 {
        (self.uu / (n * n) + 2.0 * self.uv / (n * m) + self.vv / (m * m)) / 8.0
    }

    pub(super) fn of(patch: &BezierPatch) -> Self {
        let Some(weights) = &patch.weights else {
            let s = Net::new(patch.degrees, patch.control_points.clone());
            let (su, sv) = (s.du(), s.dv());
            return Self {
                uu: su.du().largest_norm(),
                uv: su.dv().largest_norm(),
                vv: sv.dv().largest_norm(),
            };
        };
        // About one of the points, so that coordinates far from the origin lose nothing.
        let centre = patch.control_points[0];
        let values = patch.control_points.iter().zip(weights).map(|(p, w)| (p - centre) * *w).collect();
        let a = Net::<3>::new(patch.degrees, values);
        let w = Net::new(patch.degrees, weights.iter().map(|w| Vector1::new(*w)).collect());
        let scale = (PARTS * PARTS) as f64;
        let mut worst = Self::default();
        for (a, w) in a.cut(true, PARTS).into_iter().zip(w.cut(true, PARTS)) {
            for (a, w) in a.cut(false, PARTS).into_iter().zip(w.cut(false, PARTS)) {
                let part = Self::rational(&a, &w);
                worst.uu = worst.uu.max(part.uu * scale);
                worst.uv = worst.uv.max(part.uv * scale);
                worst.vv = worst.vv.max(part.vv * scale);
            }
        }
        worst
    }

    /// From `s_u = n / w²` with `n = a_u w − a w_u` and `s_uu = (n_u w − 2 n w_u) / w³`, `s_uv` likewise:
    /// numerators are exact polynomials, so nothing is lost to cancellation.
    fn rational(a: &Net<3>, w: &Net<1>) -> Self {
        let cube = w.smallest_norm().powi(3);
        let (wu, wv) = (w.du(), w.dv());
        let along_u: Net<3> = a.du().times(w).minus(1.0, &a.times(&wu));
        let along_v: Net<3> = a.dv().times(w).minus(1.0, &a.times(&wv));
        let second = |derivative: Net<3>, n: &Net<3>, slope: &Net<1>| {
            derivative.times(w).minus(2.0, &n.times(slope)).largest_norm() / cube
        };
        Self {
            uu: second(along_u.du(), &along_u, &wu),
            uv: second(along_u.dv(), &along_u, &wv),
            vv: second(along_v.dv(), &along_v, &wv),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Cylinder, Frame, Interval, ParametricSurface};

    #[test]
    fn close_to_the_true_maximum_on_a_cylinder() {
        let cylinder = Cylinder::new(Frame::WORLD, 2.0, Interval::UNIT).unwrap().to_nurbs().unwrap();
        let bounds = SecondBounds::of(&cylinder.bezier_patches()[0]);
        let quarter = std::f64::consts::FRAC_PI_2;
        let sampled = (0..=1000).map(|i| cylinder.jet(quarter * f64::from(i) / 1000.0, 0.5).duu.norm());
        let largest = sampled.fold(0.0, f64::max) * quarter * quarter;
        assert!(bounds.uu >= largest && bounds.uu <= 1.3 * largest, "{bounds:?} {largest}");
        assert!(bounds.uv < 1e-13 && bounds.vv < 1e-13, "{bounds:?}");
    }
}
