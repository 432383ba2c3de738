//! Knots from parameters.

use crate::modify::periodic::Cycle;
use crate::{Error, Interval, KnotVector, MAX_DEGREE};

impl KnotVector {
    /// Clamped knots for interpolation at `params` where the derivative at the start, the end, or both
    /// is given too ([PT97, eq. (9.20)]).
    ///
    /// There is one more basis function for each derivative.
    ///
    /// # Errors
    /// As [`averaged`](Self::averaged).
    pub fn averaged_with_derivatives(
        degree: usize,
        params: &[f64],
        start: bool,
        end: bool,
    ) -> Result<Self, Error> {
        check_degree(degree)?;
        let n = params.len() + usize::from(start) + usize::from(end);
        let (Some(&first), Some(&last)) = (params.first(), params.last()) else {
            return Err(Error::TooFewKnots { found: degree + 1, degree, needed: 2 * (degree + 1) });
        };
        if n < degree + 1 {
            return Err(Error::TooFewKnots { found: n + degree + 1, degree, needed: 2 * (degree + 1) });
        }
        // A derivative counts as a second parameter at its end.
        let mut all = Vec::with_capacity(n);
        all.extend(start.then_some(first));
        all.extend_from_slice(params);
        all.extend(end.then_some(last));
        let inner = (1..n - degree).map(|j| all[j..j + degree].iter().sum::<f64>() / degree as f64);
        let ends = |t| std::iter::repeat_n(t, degree + 1);
        Self::new(degree, ends(first).chain(inner).chain(ends(last)).collect())
    }

    /// Periodic knots for interpolation at the increasing parameters `params`, less than one period long.
    ///
    /// Every knot is the mean of `degree` parameters that follow each other, as in the clamped case; the
    /// domain starts at the knot that belongs to the first parameter. There are as many distinct
    /// control points as parameters.
    ///
    /// # Errors
    /// With fewer than `degree + 1` parameters, or when they do not increase strictly within a period.
    pub fn averaged_periodic(degree: usize, params: &[f64], period: f64) -> Result<Self, Error> {
        let m = params.len();
        check_degree(degree)?;
        if m < degree + 1 {
            return Err(Error::argument(format!(
                "a closed curve of degree {degree} needs at least {} parameters, there are {m}",
                degree + 1
            )));
        }
        let within = params[m - 1] - params[0] < period && period.is_finite();
        if !within || params.windows(2).any(|w| w[0].is_nan() || w[1].is_nan() || w[0] >= w[1]) {
            return Err(Error::argument(format!(
                "parameters of a closed curve must increase strictly and span less than the period {period}"
            )));
        }
        let at = |k: isize| {
            let (turn, i) = (k.div_euclid(m.cast_signed()), k.rem_euclid(m.cast_signed()));
            params[i.cast_unsigned()] + turn as f64 * period
        };
        let p = degree.cast_signed();
        let mean = |j: isize| (j - p / 2..j - p / 2 + p).map(at).sum::<f64>() / p as f64;
        let values: Vec<f64> = (0..m.cast_signed()).map(mean).collect();
        let domain = Interval::new(values[0], values[0] + period)?;
        Cycle { values, seam: 0, domain }.vector(degree)
    }

    /// Clamped knots with `count` basis functions for least squares at `params` (in any order), so that
    /// every span holds data ([PT97, eqs. (9.68) and (9.69)]).
    ///
    /// # Errors
    /// When `count` is below `degree + 1` or not below the number of distinct parameters plus one, or a
    /// parameter is not finite.
    pub fn for_approximation(degree: usize, params: &[f64], count: usize) -> Result<Self, Error> {
        check_degree(degree)?;
        let sorted = distinct(params)?;
        if count < degree + 1 {
            return Err(Error::TooFewKnots { found: count + degree + 1, degree, needed: 2 * (degree + 1) });
        }
        if sorted.len() < count {
            return Err(too_many(count, sorted.len()));
        }
        let spans = count - degree;
        let inner = quantiles(&sorted, spans, 1.0);
        let ends = |t| std::iter::repeat_n(t, degree + 1);
        let (first, last) = (sorted[0], sorted[sorted.len() - 1]);
        Self::new(degree, ends(first).chain(inner).chain(ends(last)).collect())
    }

    /// Periodic knots on `domain` with `count` distinct basis functions for least squares at `params`
    /// (in any order, any period).
    ///
    /// # Errors
    /// As [`for_approximation`](Self::for_approximation).
    pub fn for_periodic_approximation(
        degree: usize,
        params: &[f64],
        domain: Interval,
        count: usize,
    ) -> Result<Self, Error> {
        check_degree(degree)?;
        let wrapped: Vec<f64> = params.iter().map(|&t| domain.wrap(t)).collect();
        if params.iter().any(|t| !t.is_finite()) {
            return Err(Error::argument("a parameter is not finite"));
        }
        let sorted = distinct(&wrapped)?;
        if sorted.len() < count {
            return Err(too_many(count, sorted.len()));
        }
        let mut values = vec![domain.start()];
        values.extend(quantiles(&sorted, count, 0.5));
        Cycle { values, seam: 0, domain }.vector(degree)
    }
}

pub(super) fn check_degree(degree: usize) -> Result<(), Error> {
    if degree == 0 || degree > MAX_DEGREE { Err(Error::Degree { degree }) } else { Ok(()) }
}

fn too_many(count: usize, data: usize) -> Error {
    Error::argument(format!(
        "{count} control points cannot be determined by {data} distinct parameters; ask for fewer"
    ))
}

/// The distinct finite values in order.
fn distinct(params: &[f64]) -> Result<Vec<f64>, Error> {
    if let Some(i) = params.iter().position(|t| !t.is_finite()) {
        return Err(Error::argument(format!("parameter {i} is {}; parameters must be finite", params[i])));
    }
    let mut sorted = params.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted.dedup();
    if sorted.is_empty() {
        return Err(Error::argument("there are no parameters"));
    }
    Ok(sorted)
}

/// The inner knots of `spans` spans with about equally many of the sorted parameters each: knot `j`
/// stands at the place `j d − back` in the list, `d` being the number of parameters in a span.
///
/// Places in between are interpolated. As `d ≥ 1` no span lacks a parameter.
fn quantiles(sorted: &[f64], spans: usize, back: f64) -> Vec<f64> {
    let d = sorted.len() as f64 / spans as f64;
    (1..spans)
        .map(|j| {
            let at = (j as f64 * d - back).clamp(0.0, (sorted.len() - 1) as f64);
            #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "0 ≤ at < len")]
            let i = at as usize;
            let alpha = at - i as f64;
            let next = sorted[(i + 1).min(sorted.len() - 1)];
            (1.0 - alpha) * sorted[i] + alpha * next
        })
        .collect()
}
