//! Four curves around a patch.

use super::compatible::snapped_knots;
use super::{Side, coons};
use crate::{BsplineCurve, BsplineSurface, Direction, Error, KnotVector, ParametricCurve};
use nalgebra::Vector3;

/// Four curves around a patch: `v = 0` and `v = 1`, both running in `u`, and `u = 0` and `u = 1`, both running in `v`.
#[derive(Clone, Debug, PartialEq)]
pub struct BoundaryCurves {
    /// The curves `v = 0` and `v = 1`.
    pub along_u: [BsplineCurve<3>; 2],
    /// The curves `u = 0` and `u = 1`.
    pub along_v: [BsplineCurve<3>; 2],
}

impl BoundaryCurves {
    /// Of four curves in any order and direction: the first is `v = 0`, and of the others the one that begins or ends nearest to its end is `u = 1`.
    ///
    /// # Errors
    /// [`Error::Incompatible`] for closed curves, or corners where curves are more than `abs_tolerance` (a length) apart.
    pub fn of(curves: [BsplineCurve<3>; 4], abs_tolerance: f64) -> Result<Self, Error> {
        let ends =
            |curve: &BsplineCurve<3>| [curve.domain().start(), curve.domain().end()].map(|t| curve.point(t));
        if let Some(k) = curves.iter().position(|c| c.knots().is_periodic()) {
            return Err(Error::Incompatible { what: format!("boundary curve {k} (from 0) is closed") });
        }
        let mut rest = curves.to_vec();
        let lower = rest.remove(0);
        // The curve of those left that has an end nearest to a place, running away from it.
        let from = |rest: &mut Vec<BsplineCurve<3>>,
                    place: &Vector3<f64>|
         -> Result<BsplineCurve<3>, Error> {
            let apart = |curve: &BsplineCurve<3>| ends(curve).map(|end| (end - place).norm());
            let nearest = |curve: &BsplineCurve<3>| apart(curve)[0].min(apart(curve)[1]);
            let next =
                (0..rest.len()).min_by(|&a, &b| nearest(&rest[a]).total_cmp(&nearest(&rest[b]))).unwrap_or(0);
            let curve = rest.remove(next);
            let [first, last] = apart(&curve);
            if last < first { curve.reversed() } else { Ok(curve) }
        };
        let right = from(&mut rest, &ends(&lower)[1])?;
        let upper = from(&mut rest, &ends(&right)[1])?.reversed()?;
        let left = from(&mut rest, &ends(&lower)[0])?;
        let found = Self { along_u: [lower, upper], along_v: [left, right] };
        found.coons(abs_tolerance)?;
        Ok(found)
    }

    /// Their Coons patch.
    ///
    /// # Errors
    /// Those of [`coons`](coons()).
    pub fn coons(&self, abs_tolerance: f64) -> Result<BsplineSurface, Error> {
        let [a, b] = &self.along_u;
        let [c, d] = &self.along_v;
        coons([a, b], [c, d], abs_tolerance)
    }

    /// A surface over the unit square moved onto the curves, by the difference of their Coons patch from that of its own boundary: the boundary is
    /// exactly the curves, which meet exactly, and the inside changes no more than the boundary.
    ///
    /// # Errors
    /// [`Error::Incompatible`] for curves that do not meet within `abs_tolerance` (a length), and surfaces or curves with weights.
    pub fn imposed_on(&self, surface: &BsplineSurface, abs_tolerance: f64) -> Result<BsplineSurface, Error> {
        let side = |side: Side| {
            let domain = [surface.knots_u(), surface.knots_v()][side.constant().index()].domain();
            surface.iso_curve(side.constant(), if side.is_end() { domain.end() } else { domain.start() })
        };
        let own = Self {
            along_u: [side(Side::VStart)?, side(Side::VEnd)?],
            along_v: [side(Side::UStart)?, side(Side::UEnd)?],
        };
        let terms =
            [(surface.clone(), 1.0), (self.coons(abs_tolerance)?, 1.0), (own.coons(abs_tolerance)?, -1.0)];
        sum(terms)
    }
}

/// A sum of surfaces with factors, over the domain of the first.
fn sum(terms: [(BsplineSurface, f64); 3]) -> Result<BsplineSurface, Error> {
    if terms.iter().any(|(surface, _)| surface.weights().is_some()) {
        return Err(Error::Incompatible { what: "surfaces with weights cannot be added".to_owned() });
    }
    let factors = [terms[0].1, terms[1].1, terms[2].1];
    let domain = [terms[0].0.knots_u().domain(), terms[0].0.knots_v().domain()];
    let mut all = Vec::with_capacity(terms.len());
    for (surface, _) in terms {
        all.push(surface.clamped(Direction::U)?.clamped(Direction::V)?.reparameterized(domain)?);
    }
    for direction in Direction::BOTH {
        let knots =
            |surface: &BsplineSurface| [surface.knots_u(), surface.knots_v()][direction.index()].clone();
        let degree = all.iter().map(|s| knots(s).degree()).max().unwrap_or_default();
        for surface in &mut all {
            *surface = surface.elevated(direction, degree - knots(surface).degree())?;
        }
        let mut common = knots(&all[0]);
        for surface in &mut all[1..] {
            let snapped = snapped_knots(&knots(surface), &common)?;
            common = common.merged(&snapped)?;
            *surface = with_knots(surface, direction, snapped)?;
        }
        for surface in &mut all {
            *surface = surface.refine(direction, &knots(surface).missing(&common))?;
        }
    }
    let count = all[0].control_points().len();
    let net =
        (0..count).map(|k| all.iter().zip(factors).map(|(s, f)| s.control_points()[k] * f).sum()).collect();
    BsplineSurface::new(all[0].knots_u().clone(), all[0].knots_v().clone(), net, None)
}

/// The surface over other knots in a direction.
fn with_knots(
    surface: &BsplineSurface,
    direction: Direction,
    knots: KnotVector,
) -> Result<BsplineSurface, Error> {
    let (u, v, net, weights) = surface.clone().into_parts();
    match direction {
        Direction::U => BsplineSurface::new(knots, v, net, weights),
        Direction::V => BsplineSurface::new(u, knots, net, weights),
    }
}
