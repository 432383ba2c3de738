//! The plane through neighbours of a point.

use nalgebra::{Matrix3, Point3, SymmetricEigen, Vector3};

use super::unit;
use crate::Neighbour;

/// Ratio of the variances along the second and the first principal axis up to which neighbours lie on a line.
const COLLINEAR: f64 = 1e-12;
/// Distance of the least eigenvalue from the others, as a share of the largest, from which its closed form keeps its digits.
const APART: f64 = 1e-2;

/// The entries of a symmetric matrix.
const PAIRS: [[usize; 2]; 6] = [[0, 0], [0, 1], [0, 2], [1, 1], [1, 2], [2, 2]];

/// Unit normal and surface variation of the plane through neighbours of `x`; `None` if they do not span one.
pub(crate) fn tangent_plane(
    points: &[Point3<f64>],
    x: &Point3<f64>,
    near: &[Neighbour],
) -> Option<(Vector3<f64>, f64)> {
    let radius = near.last()?.distance();
    if radius == 0.0 || near.len() < 3 {
        return None;
    }
    // Relative to the point and its neighbourhood, so that neither a far origin nor the unit costs digits.
    let scale = 1.0 / radius;
    let (mut sum, mut products) = (Vector3::zeros(), [0.0; 6]);
    for neighbour in near {
        let d = (points[neighbour.index] - x) * scale;
        sum += d;
        for (product, [i, j]) in products.iter_mut().zip(PAIRS) {
            *product += d[i] * d[j];
        }
    }
    let mut covariance = Matrix3::zeros();
    for (product, [i, j]) in products.into_iter().zip(PAIRS) {
        let value = product - sum[i] * sum[j] / near.len() as f64;
        (covariance[(i, j)], covariance[(j, i)]) = (value, value);
    }
    let ([least, middle, most], axis) = closed_form(&covariance).or_else(|| iterated(&covariance))?;
    let [least, middle, most] = [least, middle, most].map(|value| value.max(0.0));
    (middle > COLLINEAR * most).then_some((axis, least / (least + middle + most)))
}

/// Ascending eigenvalues of a symmetric matrix, and the axis of the least one, from the trigonometric solution of the
/// characteristic equation; `None` where the least one is not set apart and the solution loses digits.
fn closed_form(matrix: &Matrix3<f64>) -> Option<([f64; 3], Vector3<f64>)> {
    let mean = matrix.trace() / 3.0;
    let shifted = matrix - Matrix3::from_diagonal_element(mean);
    let scale = (shifted.norm_squared() / 6.0).sqrt();
    let third = (0.5 * shifted.determinant() / (scale * scale * scale)).clamp(-1.0, 1.0).acos() / 3.0;
    let most = mean + 2.0 * scale * third.cos();
    let least = mean + 2.0 * scale * (third + std::f64::consts::TAU / 3.0).cos();
    let middle = 3.0 * mean - most - least;
    // Not for NaN either.
    let is_apart = middle - least > APART * most;
    if !is_apart {
        return None;
    }
    // The rows of the matrix without its least eigenvalue are normal to the axis.
    let [x, y, z] = [0, 1, 2].map(|row| {
        let mut row_of = matrix.row(row).transpose();
        row_of[row] -= least;
        row_of
    });
    let normals = [x.cross(&y), y.cross(&z), z.cross(&x)];
    let longest = normals.iter().max_by(|a, b| a.norm_squared().total_cmp(&b.norm_squared()))?;
    Some(([least, middle, most], unit(longest)?))
}

/// The same by iteration, for any matrix.
fn iterated(matrix: &Matrix3<f64>) -> Option<([f64; 3], Vector3<f64>)> {
    let eigen = SymmetricEigen::new(*matrix);
    let mut axes = [0, 1, 2];
    axes.sort_by(|&one, &other| eigen.eigenvalues[one].total_cmp(&eigen.eigenvalues[other]));
    let axis = unit(&eigen.eigenvectors.column(axes[0]).into_owned())?;
    Some((axes.map(|axis| eigen.eigenvalues[axis]), axis))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::SplitMix64;
    use nalgebra::Rotation3;

    #[test]
    fn closed_form_and_iteration_agree() {
        let mut random = SplitMix64::new(3);
        let mut compared = 0;
        for _ in 0..2000 {
            let mut draw = || random.unit();
            let turn = Rotation3::from_euler_angles(6.3 * draw(), 6.3 * draw(), 6.3 * draw());
            let values = [draw() * 10f64.powf(-17.0 * draw()), draw(), draw()];
            let matrix = turn * Matrix3::from_diagonal(&Vector3::from(values)) * turn.inverse().matrix();
            let matrix = (matrix + matrix.transpose()) * 0.5;
            let (values, axis) = iterated(&matrix).unwrap();
            let Some((found, normal)) = closed_form(&matrix) else {
                assert!(values[1] - values[0] < 1.01 * APART * values[2]);
                continue;
            };
            compared += 1;
            assert!(found.iter().zip(values).all(|(a, b)| (a - b).abs() < 1e-7 * values[2]), "{values:?}");
            assert!((found[0] - values[0]).abs() < 1e-14 * values[2] / APART, "{found:?} {values:?}");
            assert!(normal.cross(&axis).norm() < 1e-12, "{values:?}");
        }
        assert!(compared > 1500, "{compared}");
    }
}
