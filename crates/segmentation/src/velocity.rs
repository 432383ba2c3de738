//! Velocity fields tangential to a region: the generalised null space problem.
//!
//! A field `v(x) = c̄ + c × x` is tangential where `n·v = 0`. `M z = λ B z` with `M = Σ (n·v)²/σₙ²` and `B = Σ |v|²`, `z = (c̄, c)`,
//! makes `λ` free of origin, scale and size of the region; a true field has `λ ≈ 1` ([P05, sec. 6]).

use nalgebra::{Matrix3, Point3, SMatrix, SVector, SymmetricEigen, Vector3};

use crate::jets::PointNormal;
use crate::least_squares::mean;

type Matrix6 = SMatrix<f64, 6, 6>;
type Vector6 = SVector<f64, 6>;

/// The fields of a region, the most tangential first (`λ` ascending), in coordinates about `origin` in units of `scale`.
#[derive(Clone, Debug)]
pub(crate) struct Fields {
    pub(crate) origin: Point3<f64>,
    pub(crate) scale: f64,
    /// `(c̄, c)` of each.
    fields: [Vector6; 6],
    /// Eigenvalues and eigenvectors of `Σ n nᵀ/σₙ²` over the sum of weights, ascending.
    pub(crate) translations: [(f64, Vector3<f64>); 3],
}

/// A helical motion: rotation about an axis through `point` with an advance of `pitch` per radian.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Helical {
    pub(crate) point: Point3<f64>,
    pub(crate) axis: Vector3<f64>,
    /// Advance per radian; infinite for a translation along the axis.
    pub(crate) pitch: f64,
}

impl Fields {
    /// Solves the problem; `None` if no normal is known.
    pub(crate) fn new(points: &[Point3<f64>], normals: &[PointNormal]) -> Option<Self> {
        let known: Vec<(&Point3<f64>, &PointNormal)> =
            points.iter().zip(normals).filter(|(_, n)| n.deviation.is_finite()).collect();
        let rest = known.len();
        if rest < 6 {
            return None;
        }
        let origin = mean(points);
        let sum: f64 = points.iter().map(|p| (p - origin).norm_squared()).sum();
        let scale = (sum / points.len() as f64).sqrt();
        if scale.is_nan() || scale <= 0.0 {
            return None;
        }
        let (mut m, mut b, mut total) = (Matrix6::zeros(), Matrix6::zeros(), 0.0);
        for (p, n) in known {
            let x = (*p - origin) / scale;
            let weight = n.deviation.max(LEAST_DEVIATION).powi(-2);
            let c = x.cross(&n.normal);
            let row = Vector6::new(n.normal.x, n.normal.y, n.normal.z, c.x, c.y, c.z);
            m += row * row.transpose() * weight;
            total += weight;
            let skew = -x.cross_matrix();
            let mut g = SMatrix::<f64, 3, 6>::zeros();
            g.fixed_columns_mut::<3>(0).copy_from(&Matrix3::identity());
            g.fixed_columns_mut::<3>(3).copy_from(&skew);
            b += g.transpose() * g;
        }
        let count = rest as f64;
        let (m, b) = (m / count, b / count + Matrix6::identity() * 1e-12);
        let lower = b.cholesky()?.l();
        let inverse = lower.try_inverse()?;
        let eigen = SymmetricEigen::new(inverse * m * inverse.transpose());
        let mut order = [0, 1, 2, 3, 4, 5];
        order.sort_by(|&i, &j| eigen.eigenvalues[i].total_cmp(&eigen.eigenvalues[j]).then(i.cmp(&j)));
        let fields = order.map(|k| inverse.transpose() * eigen.eigenvectors.column(k));
        let three = SymmetricEigen::new(m.fixed_view::<3, 3>(0, 0).into_owned() * (count / total));
        let mut order = [0, 1, 2];
        order.sort_by(|&i, &j| three.eigenvalues[i].total_cmp(&three.eigenvalues[j]).then(i.cmp(&j)));
        let translations = order.map(|k| (three.eigenvalues[k], three.eigenvectors.column(k).into()));
        Some(Self { origin, scale, fields, translations })
    }

    /// The motion of one of the fields in the coordinates of the cloud; `None` for a translation.
    pub(crate) fn motion(&self, k: usize) -> Option<Helical> {
        let (bar, c): (Vector3<f64>, Vector3<f64>) =
            (self.fields[k].fixed_rows::<3>(0).into(), self.fields[k].fixed_rows::<3>(3).into());
        let square = c.norm_squared();
        if square.is_nan() || square <= 1e-10 * bar.norm_squared() {
            return None;
        }
        let point = self.origin + c.cross(&bar) / square * self.scale;
        Some(Helical { point, axis: c / square.sqrt(), pitch: c.dot(&bar) / square * self.scale })
    }
}

/// Deviation of a normal in radians below which weights grow no more.
const LEAST_DEVIATION: f64 = 1e-4;
