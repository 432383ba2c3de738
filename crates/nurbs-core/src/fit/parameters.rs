//! Parameters for data points that come in order.

use crate::Error;
use nalgebra::{SVector, Vector3};

/// How parameters are spaced along ordered data points ([PT97, sec. 9.2.1]).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ParameterMethod {
    /// Equal steps; for data that are spaced evenly. Accepts points that coincide.
    Uniform,
    /// Steps in proportion to the distances of the points: close to the arc length.
    #[default]
    ChordLength,
    /// Steps in proportion to the square roots of the distances: tamer at sharp turns
    /// ([PT97, eq. (9.6)]).
    Centripetal,
}

impl ParameterMethod {
    fn step(self, distance: f64) -> f64 {
        match self {
            Self::Uniform => 1.0,
            Self::ChordLength => distance,
            Self::Centripetal => distance.sqrt(),
        }
    }
}

/// Parameters from 0 to 1 for the points of an open curve.
///
/// # Errors
/// With fewer than two points, a coordinate that is not finite, or neighbours that coincide (unless
/// the method is uniform).
pub fn parameters<const D: usize>(
    points: &[SVector<f64, D>],
    method: ParameterMethod,
) -> Result<Vec<f64>, Error> {
    let (mut out, length) = accumulate(points, points.len().saturating_sub(1), method)?;
    out.iter_mut().for_each(|t| *t /= length);
    if let Some(last) = out.last_mut() {
        *last = 1.0;
    }
    check_increasing(&out, method)?;
    Ok(out)
}

/// Parameters in `[0, 1)` for the points of a closed curve with period 1; the first point is not
/// repeated at the end.
///
/// # Errors
/// As [`parameters`]; the last and the first point are neighbours too.
pub fn closed_parameters<const D: usize>(
    points: &[SVector<f64, D>],
    method: ParameterMethod,
) -> Result<Vec<f64>, Error> {
    let (mut out, length) = accumulate(points, points.len(), method)?;
    out.iter_mut().for_each(|t| *t /= length);
    check_increasing(&out, method)?;
    out.pop();
    Ok(out)
}

/// Sums of the first `steps` steps, starting with 0, and their total.
fn accumulate<const D: usize>(
    points: &[SVector<f64, D>],
    steps: usize,
    method: ParameterMethod,
) -> Result<(Vec<f64>, f64), Error> {
    if points.len() < 2 {
        return Err(Error::argument(format!(
            "{} data points are too few; at least 2 are needed",
            points.len()
        )));
    }
    let mut out = vec![0.0];
    let mut sum = 0.0;
    for i in 0..steps {
        let next = (i + 1) % points.len();
        let distance = (points[next] - points[i]).norm();
        if !distance.is_finite() {
            return Err(Error::argument(format!(
                "data point {i} or {next} has a coordinate that is not finite"
            )));
        }
        if distance == 0.0 && method != ParameterMethod::Uniform {
            return Err(coincide(i, next));
        }
        sum += method.step(distance);
        out.push(sum);
    }
    Ok((out, sum))
}

fn coincide(i: usize, next: usize) -> Error {
    Error::argument(format!(
        "data points {i} and {next} coincide; remove one of them, or use uniform parameters{}",
        if next == 0 { " (the first point of a closed curve is not repeated at its end)" } else { "" }
    ))
}

fn check_increasing(parameters: &[f64], method: ParameterMethod) -> Result<(), Error> {
    match parameters.windows(2).position(|w| w[0].is_nan() || w[1].is_nan() || w[0] >= w[1]) {
        Some(i) if method == ParameterMethod::Uniform => {
            Err(Error::argument(format!("{i} data points are too many for distinct parameters")))
        }
        Some(i) => Err(coincide(i, i + 1)),
        None => Ok(()),
    }
}

/// Parameters in `u` and `v` for a grid of `size[0] × size[1]` points (row-major, `u` outer): the means
/// over all rows or columns ([PT97, A9.3]).
///
/// Rows that shrink to a point, as at a pole, are left out of the mean. In closed directions the
/// period is 1 and the first row is not repeated.
///
/// # Errors
/// When the count does not fit the size, every row is a point, or neighbours coincide in all rows.
pub fn grid_parameters(
    points: &[Vector3<f64>],
    size: [usize; 2],
    closed: [bool; 2],
    method: ParameterMethod,
) -> Result<[Vec<f64>; 2], Error> {
    let [n_u, n_v] = size;
    if n_u.checked_mul(n_v) != Some(points.len()) || points.is_empty() {
        return Err(Error::argument(format!("{} points do not form a grid of {n_u} x {n_v}", points.len())));
    }
    let in_u = (0..n_v).map(|j| (0..n_u).map(|i| points[i * n_v + j]).collect()).collect();
    let in_v = points.chunks_exact(n_v).map(<[Vector3<f64>]>::to_vec).collect();
    Ok([mean(in_u, closed[0], method, "u")?, mean(in_v, closed[1], method, "v")?])
}

fn mean(
    lines: Vec<Vec<Vector3<f64>>>,
    closed: bool,
    method: ParameterMethod,
    name: &str,
) -> Result<Vec<f64>, Error> {
    let count = lines[0].len();
    if count < 2 {
        return Err(Error::argument(format!("a grid needs at least 2 points in {name}, there is {count}")));
    }
    let steps = if closed { count } else { count - 1 };
    let (mut sum, mut used) = (vec![0.0; steps], 0.0);
    for line in &lines {
        let distance = |i: usize| (line[(i + 1) % count] - line[i]).norm();
        let step: Vec<f64> = (0..steps).map(|i| method.step(distance(i))).collect();
        let total: f64 = step.iter().sum();
        if !total.is_finite() {
            return Err(Error::argument("a point of the grid has a coordinate that is not finite"));
        }
        if total > 0.0 {
            used += 1.0;
            sum.iter_mut().zip(step).for_each(|(s, x)| *s += x / total);
        }
    }
    if used == 0.0 {
        return Err(Error::argument(format!("all lines of the grid that run in {name} shrink to points")));
    }
    let mut out = vec![0.0];
    let mut at = 0.0;
    for (i, step) in sum.iter().enumerate() {
        let next = at + step / used;
        if next <= at {
            return Err(Error::argument(format!(
                "lines {i} and {} of the grid, counted in {name}, coincide; remove one",
                (i + 1) % count
            )));
        }
        out.push(next);
        at = next;
    }
    if closed {
        out.pop();
    } else if let Some(last) = out.last_mut() {
        *last = 1.0;
    }
    Ok(out)
}
