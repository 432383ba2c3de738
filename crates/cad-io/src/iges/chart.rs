//! Surfaces by the parameters that the file gives them, which curves on surfaces are written in.

use super::motion::Motion;
use brep_core::description::EdgeCurve;
use nalgebra::{Rotation3, Unit, Vector3};
use nurbs_core::{
    BsplineCurve, BsplineSurface, CurveJet, Error, KnotVector, ParametricCurve, ParametricSurface,
};
use std::sync::Arc;

/// Largest distance of a lifted curve from the surface, as a share of the size of the curve.
const LIFTED: f64 = 1e-9;
/// Most cubic pieces of a lifted curve.
const MOST_PIECES: usize = 4096;

/// A surface by the parameters of the file.
#[derive(Clone, Debug)]
pub(crate) enum Chart {
    /// Those of the B-spline.
    Nurbs(Arc<BsplineSurface>),
    /// Both run from 0 to 1 over the domain of the B-spline.
    Unit(Arc<BsplineSurface>),
    /// The parameter of a curve, and the angle about an axis.
    Revolution {
        /// The curve at angle 0.
        curve: EdgeCurve,
        /// A point of the axis.
        origin: Vector3<f64>,
        /// Direction of the axis.
        axis: Unit<Vector3<f64>>,
    },
    /// Another one, moved.
    Moved(Box<Self>, Motion),
    /// The surface has none that curves are written in.
    None,
}

impl Chart {
    /// This one moved.
    pub(crate) fn moved(self, motion: Motion) -> Self {
        match self {
            Self::None => Self::None,
            other => Self::Moved(Box::new(other), motion),
        }
    }

    /// Whether the parameters are those of a B-spline carrier.
    pub(crate) fn is_carrier(&self) -> bool {
        match self {
            Self::Nurbs(_) => true,
            Self::Moved(inner, _) => inner.is_carrier(),
            Self::Unit(_) | Self::Revolution { .. } | Self::None => false,
        }
    }

    /// Point and partial derivatives.
    fn jet(&self, u: f64, v: f64) -> Option<[Vector3<f64>; 3]> {
        Some(match self {
            Self::Nurbs(surface) => {
                let jet = surface.jet(u, v);
                [jet.point, jet.du, jet.dv]
            }
            Self::Unit(surface) => {
                let [domain_u, domain_v] = surface.domain();
                let jet = surface.jet(domain_u.lerp(u), domain_v.lerp(v));
                [jet.point, jet.du * domain_u.length(), jet.dv * domain_v.length()]
            }
            Self::Revolution { curve, origin, axis } => {
                let CurveJet { point, d1: derivative, .. } = curve.jet(u);
                let turn = Rotation3::from_axis_angle(axis, v);
                let arm = turn * (point - origin);
                [origin + arm, turn * derivative, axis.cross(&arm)]
            }
            Self::Moved(inner, motion) => {
                let [point, du, dv] = inner.jet(u, v)?;
                [motion.point(&point), motion.vector(&du), motion.vector(&dv)]
            }
            Self::None => return None,
        })
    }

    /// The curve in space that a curve in the parameters describes, as cubics with its end points and tangents, refined
    /// until it is that curve within a billionth of its size. `None` where the surface has no parameters.
    pub(crate) fn lift(&self, curve: &BsplineCurve<2>) -> Option<Result<BsplineCurve<3>, Error>> {
        let at = |t: f64| {
            let jet = curve.jet(t);
            let [point, du, dv] = self.jet(jet.point.x, jet.point.y)?;
            Some([point, du * jet.d1.x + dv * jet.d1.y])
        };
        let domain = curve.domain();
        let mut breaks = vec![domain.start()];
        breaks.extend(curve.breaks());
        breaks.push(domain.end());
        let mut waiting: Vec<[f64; 2]> = breaks.windows(2).rev().map(|pair| [pair[0], pair[1]]).collect();
        let size = {
            let points: Option<Vec<_>> = breaks.iter().map(|&t| Some(at(t)?[0])).collect();
            let middle = at(domain.midpoint())?[0];
            points?.iter().map(|p| (p - middle).norm()).fold(0.0, f64::max)
        };
        let (mut knots, mut points) = (vec![domain.start(); 4], Vec::new());
        while let Some([start, end]) = waiting.pop() {
            let h = end - start;
            // Tangents at breaks are those of this piece: evaluated just inside, where the curve may have a corner.
            let inside = 1e-9 * h;
            let ([p, _], [q, _]) = (at(start)?, at(end)?);
            let ([_, a], [_, b]) = (at(start + inside)?, at(end - inside)?);
            let net = [p, p + a * (h / 3.0), q - b * (h / 3.0), q];
            let middle = 0.5 * (start + end);
            let error = [0.25, 0.5, 0.75].into_iter().try_fold(0.0, |largest: f64, s: f64| {
                let r = 1.0 - s;
                let weights = [r * r * r, 3.0 * r * r * s, 3.0 * r * s * s, s * s * s];
                let cubic = net.iter().zip(weights).fold(Vector3::zeros(), |sum, (p, w)| sum + p * w);
                Some(largest.max((cubic - at(start + s * h)?[0]).norm()))
            })?;
            let refine = error > LIFTED * size && start < middle && middle < end;
            if refine && points.len() + waiting.len() < 3 * MOST_PIECES {
                waiting.push([middle, end]);
                waiting.push([start, middle]);
                continue;
            }
            if !points.is_empty() {
                points.pop();
            }
            points.extend(net);
            knots.extend([end; 3]);
        }
        knots.push(domain.end());
        Some(KnotVector::new(3, knots).and_then(|knots| BsplineCurve::new(knots, points, None)))
    }
}
