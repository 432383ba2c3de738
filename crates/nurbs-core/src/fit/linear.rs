//! Sparse factorizations: the only file that knows the linear algebra library.
//!
//! Everything runs sequentially, so that the same input gives the same bits.

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::sparse::linalg::cholesky::{self, LltRef, SymbolicCholesky, SymmetricOrdering};
use faer::sparse::linalg::lu::{self, NumericLu};
use faer::sparse::{SparseColMatRef, SymbolicSparseColMatRef};
use faer::{Conj, MatMut, Par, Side};

/// A square sparse matrix, columns compressed; a symmetric one holds its lower triangle only.
#[derive(Clone, Debug)]
pub(crate) struct Sparse {
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
    pub(crate) fn with_pattern(columns: Vec<Vec<usize>>) -> Self {
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

    /// Adds to an entry of the pattern; an entry outside it is ignored.
    pub(crate) fn add(&mut self, row: usize, column: usize, value: f64) {
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

/// `A = L Lᵀ` of a positive definite matrix.
#[derive(Debug)]
pub(crate) struct Cholesky {
    symbolic: SymbolicCholesky<usize>,
    values: Vec<f64>,
}

impl Cholesky {
    /// `None` when the matrix is not positive definite (or too large for the memory).
    pub(crate) fn new(lower: &Sparse) -> Option<Self> {
        let a = lower.view();
        let symbolic = cholesky::factorize_symbolic_cholesky(
            a.symbolic(),
            Side::Lower,
            SymmetricOrdering::Amd,
            Default::default(),
        )
        .ok()?;
        let mut values = vec![0.0; symbolic.len_val()];
        let scratch = symbolic.factorize_numeric_llt_scratch::<f64>(Par::Seq, Default::default());
        let mut buffer = MemBuffer::try_new(scratch).ok()?;
        let outcome = symbolic.factorize_numeric_llt(
            &mut values,
            a,
            Side::Lower,
            Default::default(),
            Par::Seq,
            MemStack::new(&mut buffer),
            Default::default(),
        );
        outcome.ok()?;
        Some(Self { symbolic, values })
    }

    /// Solves for all columns of `rhs` (column after column) in place; `false` without memory.
    pub(crate) fn solve(&self, rhs: &mut [f64]) -> bool {
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
pub(crate) fn solve_general(a: &Sparse, rhs: &mut [f64]) -> bool {
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
