//! Least squares projection of a spline onto another spline space.

use super::gauss::gauss_legendre;
use super::normal;
use super::observations::{Observations, Space};
use crate::modify::rows::ControlRows;
use crate::{Error, KnotVector, MAX_DEGREE, basis};
use std::collections::BTreeMap;

/// The spline on `target` (clamped or periodic, same domain) that is nearest to `rows` in the square
/// mean of the coefficients' space; clamped ends are kept.
pub(crate) fn project(rows: &ControlRows, target: KnotVector) -> Result<ControlRows, Error> {
    let knots = &rows.knots;
    let p = knots.degree();
    let mut row = [0.0; MAX_DEGREE + 1];
    let mut at = |span: usize, t: f64| {
        basis::values(knots, span, t, &mut row);
        let mut sum = vec![0.0; rows.width];
        for (j, weight) in row[..=p].iter().enumerate() {
            for (s, x) in sum.iter_mut().zip(rows.row(span - p + j)) {
                *s += weight * x;
            }
        }
        sum
    };
    let nodes = gauss_legendre(p + 1);
    let (mut parameters, mut weights, mut values) = (Vec::new(), Vec::new(), Vec::new());
    for span in knots.spans() {
        let interval = knots.span_interval(span);
        for &(s, weight) in &nodes {
            let t = interval.lerp(s);
            parameters.push([t, 0.0]);
            weights.push(weight * interval.length());
            values.extend(at(span, t));
        }
    }
    let mut fixed = BTreeMap::new();
    if !target.is_periodic() {
        let domain = target.domain();
        let mut end = |t: f64| at(knots.span(t), t);
        fixed.insert(0, end(domain.start()));
        fixed.insert(target.basis_count() - 1, end(domain.end()));
    }
    let space = Space { u: target, v: None };
    let data = Observations::new(&space, &parameters, &values, rows.width, Some(&weights))?;
    let coefficients = normal::solve(&space, &data, &[], &fixed)?;
    let data = space.expand(&coefficients, rows.width);
    Ok(rows.with(space.u, data))
}
