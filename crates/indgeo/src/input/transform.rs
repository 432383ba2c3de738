//! Motions of points, as they come in JSON files.

use crate::error::Error;
use crate::files;
use industrial_geometry::mesh::nalgebra::{Matrix3, Matrix4, Point3, Vector3};
use industrial_geometry::register::Pose;
use std::path::Path;

const ADVICE: &str =
    "give {\"matrix\": [[r, r, r, t], [r, r, r, t], [r, r, r, t], [0, 0, 0, 1]]}, row by row";

/// How far the stretch of a matrix may be from that of a rigid motion: what 6 decimals leave.
const ROUNDING: f64 = 1e-5;
/// Below this a matrix is taken as it is, above the nearest rotation stands for it.
const EXACT: f64 = 1e-12;

/// A rigid motion, or one with a scale: `x ↦ linear · x + translation`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Transform {
    linear: Matrix3<f64>,
    translation: Vector3<f64>,
}

impl Transform {
    /// Reads a file with a matrix of four rows, alone or as the value of `matrix`.
    pub(crate) fn read(path: &Path) -> Result<Self, Error> {
        let bytes = files::read_bytes(path)?;
        let document: serde_json::Value = serde_json::from_slice(&bytes)
            .map_err(|error| Error::content(path, format!("line {}: {error}", error.line()), ADVICE))?;
        // As `register --scale` writes it; without it a scale is a mistake, such as of units.
        let scale = document.get("scale").and_then(serde_json::Value::as_f64).unwrap_or(1.0);
        let matrix = document.get("matrix").cloned().unwrap_or(document);
        let rows: [[f64; 4]; 4] = serde_json::from_value(matrix)
            .map_err(|_| Error::content(path, "there is no matrix of 4 × 4 numbers", ADVICE))?;
        Self::of_rows(&rows, scale).map_err(|what| Error::content(path, what, ADVICE))
    }

    /// A motion that a registration found.
    pub(crate) fn of_pose(pose: &Pose<3>) -> Self {
        Self { linear: pose.rotation * pose.scale, translation: pose.translation() }
    }

    /// The motion with exactly these rows, as [`Transform::rows`] gave them.
    pub(crate) fn of_exact_rows(rows: &[[f64; 4]; 4]) -> Self {
        Self {
            linear: Matrix3::from_fn(|row, column| rows[row][column]),
            translation: Vector3::from_fn(|row, _| rows[row][3]),
        }
    }

    fn of_rows(rows: &[[f64; 4]; 4], scale: f64) -> Result<Self, String> {
        let matrix = Matrix4::from_fn(|row, column| rows[row][column]);
        if !matrix.iter().all(|value| value.is_finite()) {
            return Err("the matrix has a number that is not finite".to_owned());
        }
        if rows[3] != [0.0, 0.0, 0.0, 1.0] {
            return Err(format!("the last row of the matrix is {:?}, it must be [0, 0, 0, 1]", rows[3]));
        }
        let linear: Matrix3<f64> = matrix.fixed_view::<3, 3>(0, 0).into_owned();
        let determinant = linear.determinant();
        if determinant <= 1e-12 * linear.norm().powi(3) {
            return Err(format!("the matrix is singular or a reflection (determinant {determinant})"));
        }
        let linear = rigid(&linear, scale)?;
        Ok(Self { linear, translation: matrix.fixed_view::<3, 1>(0, 3).into_owned() })
    }

    /// The matrix by rows.
    pub(crate) fn rows(&self) -> [[f64; 4]; 4] {
        let row = |row: usize| {
            [self.linear[(row, 0)], self.linear[(row, 1)], self.linear[(row, 2)], self.translation[row]]
        };
        [row(0), row(1), row(2), [0.0, 0.0, 0.0, 1.0]]
    }

    /// Moves positions and normals.
    pub(crate) fn apply_to(&self, positions: &mut [Point3<f64>], normals: Option<&mut [Vector3<f64>]>) {
        for point in positions {
            *point = Point3::from(self.linear * point.coords + self.translation);
        }
        // Normals of a plane move with the inverse transpose; for rotations that is the rotation.
        let across = self.linear.try_inverse().map_or(self.linear, |inverse| inverse.transpose());
        for normal in normals.into_iter().flatten() {
            *normal = across * *normal;
        }
    }
}

/// The matrix if it is a rotation times `scale`, without what the rounding of the file adds; otherwise what it does instead.
fn rigid(linear: &Matrix3<f64>, scale: f64) -> Result<Matrix3<f64>, String> {
    let svd = linear.svd(true, true);
    let (most, least) = (svd.singular_values.max(), svd.singular_values.min());
    if most > least * (1.0 + ROUNDING) {
        let columns = [linear.column(0), linear.column(1), linear.column(2)];
        let [x, y, z] = columns.map(|column| column.norm());
        let angle = |i: usize, j: usize| columns[i].angle(&columns[j]).to_degrees();
        return Err(format!(
            "the matrix is not a rigid motion: it stretches by {most:.6} in one direction and by {least:.6} in another (the images of \
             the axes have the lengths {x:.6}, {y:.6}, {z:.6} and the angles xy {:.4}°, yz {:.4}°, xz {:.4}°)",
            angle(0, 1),
            angle(1, 2),
            angle(0, 2)
        ));
    }
    if most > scale * (1.0 + ROUNDING) || least < scale * (1.0 - ROUNDING) {
        let given = if scale == 1.0 { String::new() } else { format!(", but `scale` is {scale}") };
        return Err(format!(
            "the matrix is not a rigid motion: it scales by {most:.6}{given} (a file with `scale`, as `indgeo register --scale` writes \
             it, may scale)"
        ));
    }
    let exact = (most - scale).abs().max((least - scale).abs()) <= EXACT * scale;
    Ok(match (svd.u, svd.v_t) {
        (Some(u), Some(v_t)) if !exact => u * v_t * scale,
        _ => *linear,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_rigid_motions_are_taken() {
        let mut rows =
            [[0.0, -1.0, 0.0, 5.0], [1.0, 0.0, 0.0, 6.0], [0.0, 0.0, 1.0, 7.0], [0.0, 0.0, 0.0, 1.0]];
        assert_eq!(Transform::of_rows(&rows, 1.0).unwrap().rows(), rows);
        rows[2][2] = -1.0;
        assert!(Transform::of_rows(&rows, 1.0).unwrap_err().contains("reflection"));
        rows[3][0] = 1.0;
        assert!(Transform::of_rows(&rows, 1.0).unwrap_err().contains("last row"));
        rows[0][0] = f64::NAN;
        assert!(Transform::of_rows(&rows, 1.0).unwrap_err().contains("not finite"));
    }

    #[test]
    fn shear_and_scale_are_named_with_their_numbers() {
        let mut rows =
            [[1.0, 0.1, 0.0, 5.0], [0.0, 1.0, 0.0, 6.0], [0.0, 0.0, 1.0, 7.0], [0.0, 0.0, 0.0, 1.0]];
        let error = Transform::of_rows(&rows, 1.0).unwrap_err();
        assert!(error.contains("stretches by 1.051249 in one direction and by 0.951249"), "{error}");
        assert!(error.contains("xy 84.2894°"), "{error}");
        rows[0][1] = 0.0;
        rows[2][2] = 1.2;
        let error = Transform::of_rows(&rows, 1.0).unwrap_err();
        assert!(error.contains("the lengths 1.000000, 1.000000, 1.200000"), "{error}");
        for row in 0..3 {
            rows[row][row] = 2.0;
        }
        let error = Transform::of_rows(&rows, 1.0).unwrap_err();
        assert!(error.contains("it scales by 2.000000 (a file with `scale`"), "{error}");
        assert!(Transform::of_rows(&rows, 3.0).unwrap_err().contains("but `scale` is 3"));
        assert_eq!(Transform::of_rows(&rows, 2.0).unwrap().rows(), rows);
    }

    #[test]
    fn rounding_of_the_file_is_no_shear() {
        let (sin, cos) = 0.3f64.sin_cos();
        let round = |x: f64| (x * 1e6).round() / 1e6;
        let rows = [
            [round(cos), round(-sin), 0.0, 5.0],
            [round(sin), round(cos), 0.0, 6.0],
            [0.0, 0.0, 1.0, 7.0],
            [0.0, 0.0, 0.0, 1.0],
        ];
        let linear = Transform::of_rows(&rows, 1.0).unwrap().linear;
        assert!((linear.transpose() * linear - Matrix3::identity()).norm() < 1e-14);
        assert!((linear[(0, 0)] - cos).abs() < 1e-6);
    }
}
