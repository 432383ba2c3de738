//! Directions in which coefficients may move.

use nalgebra::{SMatrix, SVector};

/// The coefficients of a shape that stay, or stay in a plane; all others are free.
///
/// Both are built into the matrix of a step: the rows and columns of what is held are those of the unit matrix.
#[derive(Clone, Debug, Default)]
pub(crate) struct Freedom<const D: usize> {
    /// Whether each coefficient stays where it is; empty if none does.
    fixed: Vec<bool>,
    /// Unit normal of the plane of each coefficient that has one; empty if none has.
    planes: Vec<Option<SVector<f64, D>>>,
}

impl<const D: usize> Freedom<D> {
    /// Everything may move.
    pub(crate) fn full() -> Self {
        Self { fixed: Vec::new(), planes: Vec::new() }
    }

    pub(crate) fn fix(&mut self, coefficient: usize) {
        if self.fixed.len() <= coefficient {
            self.fixed.resize(coefficient + 1, false);
        }
        self.fixed[coefficient] = true;
    }

    /// Keeps a coefficient in its plane with the unit normal; `false` if it is held already.
    pub(crate) fn keep_in_plane(&mut self, coefficient: usize, normal: SVector<f64, D>) -> bool {
        if self.is_held(coefficient) {
            return false;
        }
        if self.planes.len() <= coefficient {
            self.planes.resize(coefficient + 1, None);
        }
        self.planes[coefficient] = Some(normal);
        true
    }

    /// Whether everything may move.
    pub(crate) fn is_full(&self) -> bool {
        self.fixed.is_empty() && self.planes.is_empty()
    }

    pub(crate) fn is_fixed(&self, coefficient: usize) -> bool {
        self.fixed.get(coefficient).copied().unwrap_or(false)
    }

    fn plane(&self, coefficient: usize) -> Option<&SVector<f64, D>> {
        self.planes.get(coefficient)?.as_ref()
    }

    /// Whether a coefficient stays in any direction.
    fn is_held(&self, coefficient: usize) -> bool {
        self.is_fixed(coefficient) || self.plane(coefficient).is_some()
    }

    /// The part of a displacement that is allowed.
    #[inline]
    pub(crate) fn allowed(&self, coefficient: usize, v: &SVector<f64, D>) -> SVector<f64, D> {
        if self.is_fixed(coefficient) {
            return SVector::zeros();
        }
        match self.plane(coefficient) {
            Some(normal) => v - normal * normal.dot(v),
            None => *v,
        }
    }

    /// The block of a matrix between two coefficients with what is held taken out; on the diagonal, 1 takes its place.
    pub(crate) fn restricted(
        &self,
        row: usize,
        column: usize,
        block: SMatrix<f64, D, D>,
    ) -> SMatrix<f64, D, D> {
        if !self.is_held(row) && !self.is_held(column) {
            return block;
        }
        let mut out = block;
        for c in 0..D {
            let image = self.allowed(row, &out.column(c).into_owned());
            out.set_column(c, &image);
        }
        for r in 0..D {
            let image = self.allowed(column, &out.row(r).transpose());
            out.set_row(r, &image.transpose());
        }
        if row == column {
            for c in 0..D {
                let axis = SVector::from_fn(|i, _| if i == c { 1.0 } else { 0.0 });
                let held = axis - self.allowed(row, &axis);
                for r in 0..D {
                    out[(r, c)] += held[r];
                }
            }
        }
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Matrix3, Vector3};

    #[test]
    fn planes_are_kept() {
        let mut freedom = Freedom::<3>::full();
        assert!(freedom.is_full());
        let normal = Vector3::new(1.0, 2.0, 2.0) / 3.0;
        assert!(freedom.keep_in_plane(2, normal) && !freedom.keep_in_plane(2, Vector3::x()));
        freedom.fix(0);
        let step = Vector3::new(0.3, -1.0, 2.0);
        assert!(freedom.allowed(2, &step).dot(&normal).abs() < 1e-15);
        assert_eq!((freedom.allowed(0, &step), freedom.allowed(1, &step)), (Vector3::zeros(), step));
        // A positive definite block stays so, and leads no force along the normal into the plane.
        let block = Matrix3::new(4.0, 1.0, 0.5, 1.0, 3.0, 0.2, 0.5, 0.2, 2.0);
        let restricted = freedom.restricted(2, 2, block);
        assert!((restricted * normal - normal).norm() < 1e-15);
        assert!(restricted.cholesky().is_some());
        assert_eq!(freedom.restricted(0, 0, block), Matrix3::identity());
        assert_eq!(freedom.restricted(1, 1, block), block);
    }
}
