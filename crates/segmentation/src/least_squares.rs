//! Least squares of orthogonal distances: steps of Gauss and Newton, damped after Levenberg and Marquardt.

use nalgebra::{DMatrix, Point3, SMatrix, Vector3};

use crate::carrier::{Carrier, Row, UNKNOWNS};

type Normal = SMatrix<f64, UNKNOWNS, UNKNOWNS>;

/// A fitted carrier.
#[derive(Clone, Debug)]
pub(crate) struct Fit {
    pub(crate) carrier: Carrier,
    /// Standard deviation of the distances: root of the sum of squares over the number of points less that of unknowns.
    pub(crate) rms: f64,
}

/// Root of the sum of squared distances over the degrees of freedom.
pub(crate) fn deviation(carrier: &Carrier, points: &[Point3<f64>]) -> f64 {
    let sum: f64 = points.iter().map(|x| carrier.at(x).0.powi(2)).sum();
    (sum / points.len().saturating_sub(carrier.unknowns()).max(1) as f64).sqrt()
}

/// Mean of some points.
pub(crate) fn mean(points: &[Point3<f64>]) -> Point3<f64> {
    let sum = points.iter().fold(Vector3::zeros(), |sum, p| sum + p.coords);
    Point3::from(sum / points.len().max(1) as f64)
}

/// Sum of squares, gradient and Gauss-Newton matrix, the unused unknowns fixed.
pub(crate) fn normal_equations(carrier: &Carrier, points: &[Point3<f64>]) -> (f64, Row, Normal) {
    match carrier.unknowns() {
        3 => sums::<3>(carrier, points),
        4 => sums::<4>(carrier, points),
        5 => sums::<5>(carrier, points),
        6 => sums::<6>(carrier, points),
        _ => sums::<UNKNOWNS>(carrier, points),
    }
}

/// The same for a carrier of `N` unknowns.
fn sums<const N: usize>(carrier: &Carrier, points: &[Point3<f64>]) -> (f64, Row, Normal) {
    let linearisation = carrier.linearisation();
    let (mut cost, mut slope, mut square) = (0.0, [0.0; N], [[0.0; N]; N]);
    for x in points {
        let (d, row) = linearisation.at(x);
        cost += d * d;
        for i in 0..N {
            slope[i] += row[i] * d;
            for j in 0..=i {
                square[i][j] += row[i] * row[j];
            }
        }
    }
    let (mut gradient, mut matrix) = (Row::zeros(), Normal::identity());
    for i in 0..N {
        gradient[i] = slope[i];
        for j in 0..=i {
            (matrix[(i, j)], matrix[(j, i)]) = (square[i][j], square[i][j]);
        }
    }
    (cost, gradient, matrix)
}

/// Least squares from a start; `None` where the start is no proper carrier for the points.
pub(crate) fn refine(start: &Carrier, points: &[Point3<f64>], max_steps: usize) -> Option<Fit> {
    refine_some(start, points, max_steps, &[true; UNKNOWNS])
}

/// The same where only some unknowns are free.
pub(crate) fn refine_some(
    start: &Carrier,
    points: &[Point3<f64>],
    max_steps: usize,
    free: &[bool; UNKNOWNS],
) -> Option<Fit> {
    let near = mean(points);
    let mut carrier = start.moved(&Row::zeros(), &near)?;
    let unknowns = (0..carrier.unknowns()).filter(|&k| free[k]).count();
    if points.len() < unknowns {
        return None;
    }
    let equations = |carrier: &Carrier| {
        let (cost, mut gradient, mut matrix) = normal_equations(carrier, points);
        for k in (0..UNKNOWNS).filter(|&k| !free[k]) {
            matrix.row_mut(k).fill(0.0);
            matrix.column_mut(k).fill(0.0);
            (gradient[k], matrix[(k, k)]) = (0.0, 1.0);
        }
        (cost, gradient, matrix)
    };
    let (mut cost, mut gradient, mut matrix) = equations(&carrier);
    if !cost.is_finite() {
        return None;
    }
    let mut damping = 1e-4;
    'steps: for _ in 0..max_steps {
        loop {
            let mut damped = matrix;
            for k in 0..carrier.unknowns() {
                damped[(k, k)] += damping * matrix[(k, k)] + 1e-30;
            }
            let trial = damped.cholesky().map(|c| -c.solve(&gradient));
            let next = trial.and_then(|step| carrier.moved(&step, &near)).map(|c| (c, equations(&c)));
            if let Some((moved, (value, slope, hessian))) = next.filter(|(_, (value, _, _))| *value <= cost) {
                let gain = cost - value;
                (carrier, gradient, matrix) = (moved, slope, hessian);
                let done = gain <= 1e-6 * cost;
                cost = value;
                damping = (damping * 0.1_f64).max(1e-12);
                if done {
                    break 'steps;
                }
                break;
            }
            damping *= 10.0;
            if damping > 1e6 {
                break 'steps;
            }
        }
    }
    let freedom = points.len().saturating_sub(unknowns).max(1) as f64;
    Some(Fit { carrier, rms: (cost / freedom).sqrt() })
}

/// Covariance of the unknowns of a fitted carrier for a noise; `None` where the points do not determine them.
pub(crate) fn covariance(carrier: &Carrier, points: &[Point3<f64>], sigma: f64) -> Option<DMatrix<f64>> {
    let (_, _, matrix) = normal_equations(carrier, points);
    let n = carrier.unknowns();
    let inverse = matrix.view((0, 0), (n, n)).clone_owned().cholesky()?.inverse() * (sigma * sigma);
    inverse.iter().all(|x| x.is_finite()).then_some(inverse)
}

/// The plane of least squares.
pub(crate) fn plane(points: &[Point3<f64>]) -> Option<Fit> {
    if points.len() < 3 {
        return None;
    }
    let (frame, _) = crate::jets::principal(points)?;
    let carrier = Carrier::Plane { point: mean(points), normal: frame.column(2).into() };
    Some(Fit { carrier, rms: deviation(&carrier, points) })
}
