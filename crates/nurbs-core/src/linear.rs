//! Sparse symmetric positive definite systems, for fits of all kinds: the only file that knows the linear algebra
//! library.
//!
//! A [`Pattern`] is analysed once; a matrix with new values on the same pattern is then only factored
//! ([`Pattern::factor`]). Everything runs sequentially, so that the same input gives the same bits.
//!
//! ```
//! use nurbs_core::linear::{Pattern, Sparse};
//!
//! let mut lower = Sparse::with_pattern(vec![vec![0, 1], vec![1]]);
//! lower.add(0, 0, 2.0);
//! lower.add(1, 0, 1.0);
//! lower.add(1, 1, 2.0);
//! let pattern = Pattern::new(&lower).ok_or("too large")?;
//! let mut x = [3.0, 3.0];
//! assert!(pattern.factor(&lower).ok_or("indefinite")?.solve(&mut x));
//! assert!((x[0] - 1.0).abs() < 1e-15 && (x[1] - 1.0).abs() < 1e-15);
//! # Ok::<(), &str>(())
//! ```

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::sparse::linalg::cholesky::{self, LltRef, SymbolicCholesky, SymmetricOrdering};
use faer::sparse::linalg::lu::{self, NumericLu};
use faer::sparse::{SparseColMatRef, SymbolicSparseColMatRef};
use faer::{Conj, MatMut, Par, Side};
use std::sync::Arc;

/// A square sparse matrix, columns compressed; a symmetric one holds its lower triangle only.
#[derive(Clone, Debug)]
pub struct Sparse {
    /// Number of rows and of columns.
    pub(crate) size: usize,
    /// Where each column starts; one more entry than columns.
    pub(crate) starts: Vec<usize>,
    /// Row of each entry, increasing in each column.
    pub(crate) rows: Vec<usize>,
    /// Value of each entry.
    pub(crate) values: Vec<f64>,
}

impl Sparse {
    /// A matrix of zeros with the given rows in each column (any order, repetitions allowed).
    #[must_use]
    pub fn with_pattern(columns: Vec<Vec<usize>>) -> Self {
        let size = columns.len();
        let mut starts = Vec::with_capacity(size + 1);
        let mut rows = Vec::new();
        starts.push(0);
        for mut column in columns {
            column.sort_unstable();
            column.dedup();
            rows.extend_from_slice(&column);
            starts.push(rows.len());
        }
        let values = vec![0.0; rows.len()];
        Self { size, starts, rows, values }
    }

    /// Number of rows and of columns.
    #[must_use]
    pub fn size(&self) -> usize {
        self.size
    }

    /// The values of all entries, column after column, in each by increasing row.
    #[must_use]
    pub fn values(&self) -> &[f64] {
        &self.values
    }

    /// The same, for writing.
    pub fn values_mut(&mut self) -> &mut [f64] {
        &mut self.values
    }

    /// The rows of the entries of a column, increasing.
    #[must_use]
    pub fn rows(&self, column: usize) -> &[usize] {
        &self.rows[self.starts[column]..self.starts[column + 1]]
    }

    /// Where among all [`values`](Self::values) an entry stands, if it belongs to the pattern.
    #[must_use]
    pub fn place(&self, row: usize, column: usize) -> Option<usize> {
        self.rows(column).binary_search(&row).ok().map(|k| self.starts[column] + k)
    }

    /// Adds to an entry of the pattern; an entry outside it is ignored.
    pub fn add(&mut self, row: usize, column: usize, value: f64) {
        let range = self.starts[column]..self.starts[column + 1];
        if let Ok(k) = self.rows[range.clone()].binary_search(&row) {
            self.values[range.start + k] += value;
        }
    }

    fn view(&self) -> SparseColMatRef<'_, usize, f64> {
        let symbolic =
            SymbolicSparseColMatRef::new_checked(self.size, self.size, &self.starts, None, &self.rows);
        SparseColMatRef::new(symbolic, &self.values)
    }
}

/// The places of the entries of a symmetric matrix, analysed: an order of elimination that keeps factors sparse, and the
/// places of the entries of the factors.
#[derive(Clone, Debug)]
pub struct Pattern {
    symbolic: Arc<SymbolicCholesky<usize>>,
}

impl Pattern {
    /// Analyses the places of the entries of a matrix, of which only the lower triangle is given.
    ///
    /// `None` when it is too large for the memory.
    #[must_use]
    pub fn new(lower: &Sparse) -> Option<Self> {
        let symbolic = cholesky::factorize_symbolic_cholesky(
            lower.view().symbolic(),
            Side::Lower,
            SymmetricOrdering::Amd,
            Default::default(),
        )
        .ok()?;
        Some(Self { symbolic: Arc::new(symbolic) })
    }

    /// Number of entries of a factor.
    #[must_use]
    pub fn factor_len(&self) -> usize {
        self.symbolic.len_val()
    }

    /// `A = L Lᵀ` of a matrix with entries in these places.
    ///
    /// `None` when it is not positive definite, has another size, or memory is short.
    #[must_use]
    pub fn factor(&self, lower: &Sparse) -> Option<Cholesky> {
        let symbolic = &self.symbolic;
        if lower.size != symbolic.nrows() {
            return None;
        }
        let mut values = vec![0.0; symbolic.len_val()];
        let scratch = symbolic.factorize_numeric_llt_scratch::<f64>(Par::Seq, Default::default());
        let mut buffer = MemBuffer::try_new(scratch).ok()?;
        let outcome = symbolic.factorize_numeric_llt(
            &mut values,
            lower.view(),
            Side::Lower,
            Default::default(),
            Par::Seq,
            MemStack::new(&mut buffer),
            Default::default(),
        );
        outcome.ok()?;
        Some(Cholesky { symbolic: Arc::clone(symbolic), values })
    }
}

/// `A = L Lᵀ` of a positive definite matrix.
#[derive(Clone, Debug)]
pub struct Cholesky {
    symbolic: Arc<SymbolicCholesky<usize>>,
    values: Vec<f64>,
}

impl Cholesky {
    /// Analyses and factors a matrix, of which only the lower triangle is given.
    ///
    /// `None` when it is not positive definite (or too large for the memory).
    #[must_use]
    pub fn new(lower: &Sparse) -> Option<Self> {
        Pattern::new(lower)?.factor(lower)
    }

    /// Solves for all columns of `rhs` (column after column) in place; `false` without memory.
    #[must_use]
    pub fn solve(&self, rhs: &mut [f64]) -> bool {
        let n = self.symbolic.nrows();
        let columns = rhs.len().checked_div(n).unwrap_or(0);
        let scratch = self.symbolic.solve_in_place_scratch::<f64>(columns, Par::Seq);
        let Ok(mut buffer) = MemBuffer::try_new(scratch) else { return false };
        LltRef::new(&self.symbolic, &self.values).solve_in_place_with_conj(
            Conj::No,
            MatMut::from_column_major_slice_mut(rhs, n, columns),
            Par::Seq,
            MemStack::new(&mut buffer),
        );
        true
    }
}

/// Solves `A X = rhs` (column after column) in place by LU with pivoting; `false` when `A` is
/// structurally singular or memory is short. A numerically singular matrix shows in the result.
#[must_use]
pub fn solve_general(a: &Sparse, rhs: &mut [f64]) -> bool {
    let (n, columns) = (a.size, rhs.len().checked_div(a.size).unwrap_or(0));
    let Ok(symbolic) = lu::factorize_symbolic_lu(a.view().symbolic(), Default::default()) else {
        return false;
    };
    let mut numeric = NumericLu::new();
    let scratch = symbolic.factorize_numeric_lu_scratch::<f64>(Par::Seq, Default::default());
    let Ok(mut buffer) = MemBuffer::try_new(scratch) else { return false };
    let factored = symbolic.factorize_numeric_lu(
        &mut numeric,
        a.view(),
        Par::Seq,
        MemStack::new(&mut buffer),
        Default::default(),
    );
    let Ok(factored) = factored else { return false };
    let Ok(mut buffer) = MemBuffer::try_new(symbolic.solve_in_place_scratch::<f64>(columns, Par::Seq)) else {
        return false;
    };
    factored.solve_in_place_with_conj(
        Conj::No,
        MatMut::from_column_major_slice_mut(rhs, n, columns),
        Par::Seq,
        MemStack::new(&mut buffer),
    );
    true
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn solves_a_laplacian_both_ways() {
        let n = 30;
        let mut lower = Sparse::with_pattern((0..n).map(|j| vec![(j + 1).min(n - 1), j]).collect());
        let mut full =
            Sparse::with_pattern((0..n).map(|j| vec![j.saturating_sub(1), j, (j + 1).min(n - 1)]).collect());
        for j in 0..n {
            lower.add(j, j, 2.0);
            full.add(j, j, 2.0);
            if j + 1 < n {
                lower.add(j + 1, j, -1.0);
                full.add(j + 1, j, -1.0);
                full.add(j, j + 1, -1.0);
            }
        }
        // The second difference of a parabola is constant.
        let exact = |i: usize| ((i + 1) * (n - i)) as f64 * 0.5;
        let mut x = vec![1.0; n];
        assert!(Cholesky::new(&lower).unwrap().solve(&mut x));
        let mut y = vec![1.0; n];
        assert!(solve_general(&full, &mut y));
        for i in 0..n {
            assert!((x[i] - exact(i)).abs() < 1e-11 && (y[i] - exact(i)).abs() < 1e-11);
        }
    }

    #[test]
    fn refuses_an_indefinite_matrix() {
        let mut lower = Sparse::with_pattern(vec![vec![0, 1], vec![1]]);
        lower.add(0, 0, 1.0);
        lower.add(1, 0, 2.0);
        lower.add(1, 1, 1.0);
        assert!(Cholesky::new(&lower).is_none());
    }
}
