//! Directions of an axis that the normals of a cloud give.

use mesh_core::{NormalOptions, Orientation, estimate_normals};
use nalgebra::{Matrix3, Point3, SymmetricEigen, Vector3};

/// Normals of a sample of a cloud.
#[derive(Debug)]
pub(super) struct Sample {
    pub(super) points: Vec<Vector3<f64>>,
    pub(super) normals: Vec<Vector3<f64>>,
}

impl Sample {
    /// Every `n`-th finite point, `most` at most, with normals of either sign.
    pub(super) fn new(points: &[Vector3<f64>], most: usize) -> Result<Self, crate::Error> {
        let finite: Vec<Vector3<f64>> =
            points.iter().filter(|p| p.iter().all(|c| c.is_finite())).copied().collect();
        let step = finite.len().div_ceil(most).max(1);
        let points: Vec<Vector3<f64>> = finite.into_iter().step_by(step).collect();
        let positions: Vec<Point3<f64>> = points.iter().map(|&p| p.into()).collect();
        let options = NormalOptions::default().with_neighbours(12).with_orientation(Orientation::Any);
        let normals = estimate_normals(&positions, &options)?.normals;
        Ok(Self { points, normals })
    }

    /// The axis about which the cloud is as nearly a surface of revolution as can be: the normals of such a surface meet its
    /// axis, so they belong to a linear complex ([PW01, sec. 4.2]). `centre` and `size` make coordinates comparable.
    pub(super) fn rotation_axis(&self, centre: &Vector3<f64>, size: f64) -> Option<Vector3<f64>> {
        let (mut a, mut b, mut c) = (Matrix3::zeros(), Matrix3::zeros(), Matrix3::zeros());
        for (p, l) in self.points.iter().zip(&self.normals) {
            let moment = ((p - centre) / size).cross(l);
            a += moment * moment.transpose();
            b += l * l.transpose();
            c += moment * l.transpose();
        }
        // Σ ⟨c, moment⟩ + ⟨c̄, l⟩ squared, c̄ eliminated.
        let count = self.points.len().max(1) as f64;
        let inverse = (b / count + Matrix3::identity() * 1e-9).try_inverse()?;
        let schur = a / count - (c / count) * inverse * (c.transpose() / count);
        least(schur)
    }

    /// The direction that is most nearly perpendicular to all normals.
    pub(super) fn cylinder_axis(&self) -> Option<Vector3<f64>> {
        least(self.normals.iter().map(|n| n * n.transpose()).sum())
    }

    /// Mean square of the cosine of the angle between normals and a direction.
    pub(super) fn along(&self, direction: &Vector3<f64>) -> f64 {
        self.normals.iter().map(|n| n.dot(direction).powi(2)).sum::<f64>() / self.normals.len().max(1) as f64
    }
}

/// Eigenvector of the least eigenvalue.
pub(super) fn least(matrix: Matrix3<f64>) -> Option<Vector3<f64>> {
    let symmetric = (matrix + matrix.transpose()) / 2.0;
    if !symmetric.iter().all(|v| v.is_finite()) {
        return None;
    }
    let eigen = SymmetricEigen::new(symmetric);
    eigen.eigenvectors.column(eigen.eigenvalues.imin()).into_owned().try_normalize(0.0)
}
