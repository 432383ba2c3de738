//! Interpolation conditions as a square linear system.

use crate::linear::{Sparse, solve_general};
use crate::{Error, KnotVector, MAX_DEGREE, basis};

/// Coefficients this much larger than the data mean that the system is singular up to rounding.
const GROWTH: f64 = 1e10;

/// The value (order 0) or a derivative at a parameter.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Condition {
    pub(crate) at: f64,
    pub(crate) order: usize,
}

/// The control points (repetitions included) whose spline has the given values, `width` numbers for
/// each condition.
pub(crate) fn solve(
    knots: &KnotVector,
    conditions: &[Condition],
    values: &[f64],
    width: usize,
) -> Result<Vec<f64>, Error> {
    let n = knots.distinct_count();
    if conditions.len() != n || values.len() != n * width {
        return Err(Error::argument(format!(
            "{} interpolation conditions do not fit the {n} control points of the knot vector",
            conditions.len()
        )));
    }
    if let Some(i) = values.iter().position(|x| !x.is_finite()) {
        return Err(Error::argument(format!("data point {} has a coordinate that is not finite", i / width)));
    }
    schoenberg_whitney(knots, conditions)?;
    let p = knots.degree();
    let mut rows = Vec::with_capacity(n);
    let mut pattern = vec![Vec::new(); n];
    for (k, condition) in conditions.iter().enumerate() {
        let t = knots.normalize(condition.at);
        let span = knots.span(t);
        let mut out = vec![[0.0; MAX_DEGREE + 1]; condition.order + 1];
        basis::derivatives(knots, span, t, condition.order, &mut out);
        (span - p..=span).for_each(|j| pattern[j % n].push(k));
        rows.push((span - p, out[condition.order]));
    }
    let mut matrix = Sparse::with_pattern(pattern);
    for (k, (first, row)) in rows.iter().enumerate() {
        (0..=p).for_each(|j| matrix.add(k, (first + j) % n, row[j]));
    }
    // From the mean of the data, so that coordinates far from the origin cost no digits.
    let plain = conditions.iter().filter(|c| c.order == 0).count().max(1) as f64;
    let mut mean = vec![0.0; width];
    for (point, _) in values.chunks_exact(width).zip(conditions).filter(|(_, c)| c.order == 0) {
        mean.iter_mut().zip(point).for_each(|(m, x)| *m += x / plain);
    }
    let mut coefficients = mean.repeat(n);
    let mut bound = 0.0;
    for pass in 0..2 {
        let mut rhs = vec![0.0; n * width];
        for (k, (first, row)) in rows.iter().enumerate() {
            for c in 0..width {
                let value: f64 = (0..=p).map(|j| row[j] * coefficients[(first + j) % n * width + c]).sum();
                rhs[c * n + k] = values[k * width + c] - value;
            }
        }
        if pass == 0 {
            bound = GROWTH * rhs.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
        }
        // Equal derivatives and values of very different size do not matter: pivoting works by columns.
        let solved = solve_general(&matrix, &mut rhs);
        if !solved || rhs.iter().any(|x| x.is_nan() || x.abs() > bound) {
            return Err(Error::Singular {
                what: "the parameters do not determine the interpolant on these knots; use averaged knots, \
                       another degree, or one point more or less on a closed curve"
                    .into(),
            });
        }
        for k in 0..n {
            for c in 0..width {
                coefficients[k * width + c] += rhs[c * n + k];
            }
        }
    }
    let repeated = (knots.basis_count() - n) * width;
    coefficients.extend_from_within(..repeated);
    Ok(coefficients)
}

/// Every basis function must see its own parameter ([PT97, sec. 9.2.1]; checked where it is exact:
/// values only, knots not periodic, parameters in order).
fn schoenberg_whitney(knots: &KnotVector, conditions: &[Condition]) -> Result<(), Error> {
    let domain = knots.domain();
    if let Some(k) = conditions.iter().position(|c| !c.at.is_finite()) {
        return Err(Error::argument(format!("parameter {k} is {}; it must be finite", conditions[k].at)));
    }
    if knots.is_periodic() {
        return Ok(());
    }
    for c in conditions {
        if !domain.contains(c.at) {
            return Err(Error::Parameter { value: c.at, start: domain.start(), end: domain.end() });
        }
    }
    let increasing = conditions.windows(2).all(|w| w[0].at < w[1].at);
    if !increasing || conditions.iter().any(|c| c.order > 0) {
        return Ok(());
    }
    let (all, p) = (knots.as_slice(), knots.degree());
    for (i, c) in conditions.iter().enumerate() {
        let (left, right) = (all[i], all[i + p + 1]);
        let at_an_end = (c.at == left && all[i + p] == left) || (c.at == right && all[i + 1] == right);
        if !(at_an_end || left < c.at && c.at < right) {
            return Err(Error::Singular {
                what: format!(
                    "control point {i} acts on ({left}, {right}), where parameter {i} ({}) does not lie \
                     (Schoenberg-Whitney condition)",
                    c.at
                ),
            });
        }
    }
    Ok(())
}
