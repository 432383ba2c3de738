//! Where the parameter of a curve cannot move freely: its ends and its kinks.

use crate::local_geometry::{LocalGeometry, of_curve, of_point};
use nalgebra::SVector;
use nurbs_core::{CurveJet, Interval, ParametricCurve};

/// Share of the domain within which a parameter is at its end or at a kink.
const AT_END: f64 = 1e-12;
/// Share of the size within which points are the same.
const SAME_POINT: f64 = 1e-9;
/// Sine of the angle between residual and normal above which a kink holds the foot.
const HELD: f64 = 1e-6;
/// Share of the domain by which the other side of a kink is looked at.
const BESIDE: f64 = 1e-7;

/// What is known about the domain of one curve.
#[derive(Clone, Debug)]
pub(crate) struct CurveEnds {
    domain: Interval,
    closed: bool,
    kinks: Vec<f64>,
    size: f64,
}

impl CurveEnds {
    /// Examines a curve of about the given size.
    pub(crate) fn new<const D: usize, C: ParametricCurve<D>>(curve: &C, size: f64) -> Self {
        let domain = curve.domain();
        let gap = (curve.point(domain.start()) - curve.point(domain.end())).norm();
        let kinks = curve.derivative_breaks().into_iter().filter(|b| b.continuity == 0).map(|b| b.parameter);
        Self {
            domain,
            closed: curve.period().is_some() || gap <= SAME_POINT * size,
            kinks: kinks.collect(),
            size,
        }
    }

    /// The local geometry at a foot with the given residual, and whether the curve ends there.
    pub(crate) fn geometry<const D: usize, C: ParametricCurve<D>>(
        &self,
        curve: &C,
        parameter: f64,
        jet: &CurveJet<D>,
        residual: &SVector<f64, D>,
    ) -> (LocalGeometry<D>, bool) {
        let tolerance = AT_END * self.domain.length();
        let near = |t: f64| (parameter - t).abs() <= tolerance;
        let at_end = near(self.domain.start()) || near(self.domain.end());
        let left = left_normal(jet);
        if at_end && !self.closed {
            return (of_point(residual, left.as_ref()), true);
        }
        if (at_end || self.kinks.iter().any(|&kink| near(kink))) && !self.slides(&jet.d1, residual) {
            // The side of a kink is that of the sum of both normals.
            let side = [BESIDE, -BESIDE].into_iter().filter_map(|share| {
                left_normal(&curve.jet(self.moved(parameter, share * self.domain.length())))
            });
            let side: SVector<f64, D> = side.sum();
            return (of_point(residual, left.map(|_| side).as_ref()), false);
        }
        let geometry =
            of_curve(jet, residual, left.as_ref()).unwrap_or_else(|| of_point(residual, left.as_ref()));
        (geometry, false)
    }

    fn slides<const D: usize>(&self, tangent: &SVector<f64, D>, residual: &SVector<f64, D>) -> bool {
        let allowed = HELD * residual.norm() + AT_END * self.size;
        tangent.dot(residual).abs() <= tangent.norm() * allowed
    }

    /// A parameter moved by a step: wrapped where the curve closes, kept inside where it ends.
    pub(crate) fn moved(&self, parameter: f64, step: f64) -> f64 {
        let to = parameter + step;
        if self.closed && !self.domain.contains(to) { self.domain.wrap(to) } else { self.domain.clamp(to) }
    }
}

/// The unit normal on the left of a plane curve; `None` in space and at singular points.
fn left_normal<const D: usize>(jet: &CurveJet<D>) -> Option<SVector<f64, D>> {
    if D != 2 {
        return None;
    }
    let tangent = jet.unit_tangent()?;
    Some(SVector::from_fn(|i, _| if i == 0 { -tangent[1] } else { tangent[0] }))
}
