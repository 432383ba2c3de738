//! Curves with a common degree and common knots.

use crate::{BsplineCurve, Error, KnotVector};

/// Part of the domain within which knots of different curves count as equal: they agree up to the
/// rounding of whoever computed them.
const SAME_KNOT: f64 = 1e-12;

/// The same curves on the domain of the first one, with common degree and knots ([PT97, sec. 10.3]).
///
/// Clamped, unless all curves are periodic.
pub(super) fn compatible(curves: &[BsplineCurve<3>]) -> Result<Vec<BsplineCurve<3>>, Error> {
    let Some(first) = curves.first() else { return Ok(Vec::new()) };
    let domain = first.knots().domain();
    let degree = curves.iter().map(BsplineCurve::degree).max().unwrap_or_default();
    let periodic = curves.iter().all(|c| c.knots().is_periodic());
    let mut out = Vec::with_capacity(curves.len());
    for curve in curves {
        let curve = if periodic { curve.clone() } else { curve.clamped()? };
        out.push(curve.elevated(degree - curve.degree())?.reparameterized(domain)?);
    }
    let mut common = out[0].knots().clone();
    for curve in &mut out {
        *curve = snapped(curve, &common)?;
        common = common.merged(curve.knots())?;
    }
    out.iter().map(|curve| curve.refine(&curve.knots().missing(&common))).collect()
}

/// The curve with knots that agree with one of `knots` up to rounding moved onto it.
pub(super) fn snapped(curve: &BsplineCurve<3>, knots: &KnotVector) -> Result<BsplineCurve<3>, Error> {
    let knots = snapped_knots(curve.knots(), knots)?;
    BsplineCurve::new(knots, curve.control_points().to_vec(), curve.weights().map(<[f64]>::to_vec))
}

/// Knots, of which those that agree with one of others up to rounding are moved onto it.
pub(super) fn snapped_knots(knots: &KnotVector, onto: &KnotVector) -> Result<KnotVector, Error> {
    let slack = SAME_KNOT * onto.domain().length();
    let targets = onto.as_slice();
    let snap = |t: f64| {
        let k = targets.partition_point(|&x| x < t - slack);
        targets.get(k).copied().filter(|x| (x - t).abs() <= slack).unwrap_or(t)
    };
    let moved: Vec<f64> = knots.as_slice().iter().map(|&t| snap(t)).collect();
    if knots.is_periodic() {
        KnotVector::periodic(knots.degree(), moved)
    } else {
        KnotVector::new(knots.degree(), moved)
    }
}
