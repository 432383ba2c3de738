//! Motions of points, as they come in JSON files.

use crate::error::Error;
use crate::points::Points;
use industrial_geometry::mesh::nalgebra::{Matrix3, Matrix4, Point3, Vector3};
use std::path::Path;

const ADVICE: &str =
    "give {\"matrix\": [[r, r, r, t], [r, r, r, t], [r, r, r, t], [0, 0, 0, 1]]}, row by row";

/// An affine map: `x ↦ linear · x + translation`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Transform {
    linear: Matrix3<f64>,
    translation: Vector3<f64>,
}

impl Transform {
    /// Reads a file with a matrix of four rows, alone or as the value of `matrix`.
    pub(crate) fn read(path: &Path) -> Result<Self, Error> {
        let bytes = std::fs::read(path).map_err(|source| Error::File {
            source: industrial_geometry::io::Error::Io { path: path.to_path_buf(), action: "read", source },
        })?;
        let document: serde_json::Value = serde_json::from_slice(&bytes)
            .map_err(|error| Error::content(path, format!("line {}: {error}", error.line()), ADVICE))?;
        let matrix = document.get("matrix").cloned().unwrap_or(document);
        let rows: [[f64; 4]; 4] = serde_json::from_value(matrix)
            .map_err(|_| Error::content(path, "there is no matrix of 4 × 4 numbers", ADVICE))?;
        Self::of_rows(&rows).map_err(|what| Error::content(path, what, ADVICE))
    }

    fn of_rows(rows: &[[f64; 4]; 4]) -> Result<Self, String> {
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
        Ok(Self { linear, translation: matrix.fixed_view::<3, 1>(0, 3).into_owned() })
    }

    /// The matrix by rows.
    pub(crate) fn rows(&self) -> [[f64; 4]; 4] {
        let row = |row: usize| {
            [self.linear[(row, 0)], self.linear[(row, 1)], self.linear[(row, 2)], self.translation[row]]
        };
        [row(0), row(1), row(2), [0.0, 0.0, 0.0, 1.0]]
    }

    /// Moves points and their normals.
    pub(crate) fn apply(&self, points: &mut Points) {
        for point in &mut points.positions {
            *point = Point3::from(self.linear * point.coords + self.translation);
        }
        // Normals of a plane move with the inverse transpose; for rotations that is the rotation.
        let across = self.linear.try_inverse().map_or(self.linear, |inverse| inverse.transpose());
        for normal in points.normals.iter_mut().flatten() {
            *normal = across * *normal;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_proper_motions_are_taken() {
        let mut rows =
            [[0.0, -1.0, 0.0, 5.0], [1.0, 0.0, 0.0, 6.0], [0.0, 0.0, 1.0, 7.0], [0.0, 0.0, 0.0, 1.0]];
        assert_eq!(Transform::of_rows(&rows).unwrap().rows(), rows);
        rows[2][2] = -1.0;
        assert!(Transform::of_rows(&rows).unwrap_err().contains("reflection"));
        rows[3][0] = 1.0;
        assert!(Transform::of_rows(&rows).unwrap_err().contains("last row"));
        rows[0][0] = f64::NAN;
        assert!(Transform::of_rows(&rows).unwrap_err().contains("not finite"));
    }
}
