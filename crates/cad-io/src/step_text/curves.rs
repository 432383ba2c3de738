//! Curves of edges and free curves.

use super::instances::{Instances, Reference, list, real, reals, string};
use crate::write::shape;
use brep_core::description::EdgeCurve;
use nurbs_core::{BsplineCurve, Error, KnotVector, ParametricCurve};
use std::f64::consts::TAU;

/// Multiplicities and values of the distinct knots, each as a list in parentheses.
pub(super) fn knots(knots: &KnotVector) -> [String; 2] {
    let distinct = knots.distinct_knots();
    let multiplicities: Vec<String> = distinct.iter().map(|(_, count)| count.to_string()).collect();
    let values: Vec<f64> = distinct.iter().map(|(value, _)| *value).collect();
    [format!("({})", multiplicities.join(",")), reals(&values)]
}

/// `.T.` or `.F.`.
pub(super) const fn flag(value: bool) -> &'static str {
    if value { ".T." } else { ".F." }
}

/// The whole curve.
pub(super) fn curve(out: &mut Instances, name: &str, curve: &EdgeCurve) -> Result<Reference, Error> {
    let name = string(name);
    Ok(match curve {
        EdgeCurve::Line { origin, direction } => {
            let length = direction.norm();
            if !(length > 0.0 && length.is_finite()) {
                return Err(Error::Argument { what: format!("a line has a direction of length {length}") });
            }
            let point = out.point(origin);
            // Scaled before the length is divided by: subnormal components would lose their direction.
            let direction = out.direction(&(direction / direction.amax()).normalize());
            let vector = out.add(&format!("VECTOR('',{direction},{})", real(length)));
            out.add(&format!("LINE({name},{point},{vector})"))
        }
        EdgeCurve::Circle { frame, radius } => {
            let place = out.placement(frame);
            out.add(&format!("CIRCLE({name},{place},{})", real(*radius)))
        }
        EdgeCurve::Ellipse { frame, semi_axes: [a, b] } => {
            let place = out.placement(frame);
            out.add(&format!("ELLIPSE({name},{place},{},{})", real(*a), real(*b)))
        }
        EdgeCurve::Nurbs(curve) => spline(out, &name, &*shape::clamped_curve(curve)?),
    })
}

fn spline(out: &mut Instances, name: &str, curve: &BsplineCurve<3>) -> Reference {
    let points: Vec<Reference> = curve.control_points().iter().map(|point| out.point(point)).collect();
    let [multiplicities, values] = knots(curve.knots());
    let domain = curve.domain();
    let closed = flag(curve.point(domain.start()) == curve.point(domain.end()));
    let form = format!("{},{},.UNSPECIFIED.,{closed},.F.", curve.degree(), list(&points));
    let knots = format!("{multiplicities},{values},.UNSPECIFIED.");
    match curve.weights() {
        None => out.add(&format!("B_SPLINE_CURVE_WITH_KNOTS({name},{form},{knots})")),
        Some(weights) => out.add(&format!(
            "(BOUNDED_CURVE()B_SPLINE_CURVE({form})B_SPLINE_CURVE_WITH_KNOTS({knots})CURVE()\
             GEOMETRIC_REPRESENTATION_ITEM()RATIONAL_B_SPLINE_CURVE({})REPRESENTATION_ITEM({name}))",
            reals(weights)
        )),
    }
}

/// The piece of a curve over a range: a polynomial B-spline or a whole circle or ellipse as it is, others trimmed by
/// parameters. Not all readers take a rational B-spline by itself.
pub(super) fn bounded(
    out: &mut Instances,
    name: &str,
    whole: &EdgeCurve,
    range: [f64; 2],
) -> Result<Reference, Error> {
    let name = string(name);
    let is_closed = |length: f64| length >= TAU;
    let basis = match whole {
        EdgeCurve::Nurbs(_) => {
            let piece = crate::edges::nurbs(whole, range)?;
            let piece = shape::clamped_curve(&piece)?;
            if piece.weights().is_none() {
                return Ok(spline(out, &name, &piece));
            }
            spline(out, "''", &piece)
        }
        EdgeCurve::Circle { .. } | EdgeCurve::Ellipse { .. } if is_closed(range[1] - range[0]) => {
            return curve(out, "", whole);
        }
        EdgeCurve::Circle { .. } | EdgeCurve::Ellipse { .. } | EdgeCurve::Line { .. } => {
            curve(out, "", whole)?
        }
    };
    let [start, end] = range.map(|t| format!("(PARAMETER_VALUE({}))", real(t)));
    Ok(out.add(&format!("TRIMMED_CURVE({name},{basis},{start},{end},.T.,.PARAMETER.)")))
}
