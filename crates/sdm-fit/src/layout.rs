//! The normal equations: where their entries stand, decided once for a shape.

use crate::freedom::Freedom;
use crate::shape::{CellGram, CellTable};
use nalgebra::{SMatrix, SVector};
use nurbs_core::linear::{Cholesky, Pattern, Sparse};

/// Places of the entries between coefficients, and from each cell to them.
///
/// An entry stands for a block `D × D`, which is symmetric, and a multiple of the unit matrix where the coordinates do not
/// influence each other.
#[derive(Clone, Debug)]
pub(crate) struct Layout {
    /// Lower triangle of the matrix between coefficients.
    lower: Sparse,
    /// For each cell the places of the pairs `(i, j ≤ i)` of its functions.
    places: Vec<usize>,
    starts: Vec<usize>,
    /// Analysed on first use: of the scalar matrix and of that with all coordinates.
    scalar: Option<Pattern>,
    coupled: Option<(Sparse, Pattern)>,
}

/// A symmetric matrix between coefficients: for each entry one number (a multiple of the unit matrix), the lower triangle of a
/// symmetric block, or all of a block, row after row.
#[derive(Clone, Debug)]
pub(crate) struct Blocks {
    pub(crate) components: usize,
    pub(crate) values: Vec<f64>,
}

/// Number of entries of the lower triangle of a symmetric matrix of the size `n`.
pub(crate) const fn triangle(n: usize) -> usize {
    n * (n + 1) / 2
}

impl Layout {
    pub(crate) fn new(cells: &CellTable, coefficients: usize) -> Self {
        let mut pattern: Vec<Vec<usize>> = (0..coefficients).map(|j| vec![j]).collect();
        for cell in 0..cells.len() {
            for_pairs(cells.columns(cell), |_, low, high| pattern[low].push(high));
            // Repetitions are dropped as they come, or their number would grow with that of the cells.
            for &column in cells.columns(cell) {
                if pattern[column].len() > 256 {
                    pattern[column].sort_unstable();
                    pattern[column].dedup();
                }
            }
        }
        let lower = Sparse::with_pattern(pattern);
        let (mut places, mut starts) = (Vec::new(), vec![0]);
        for cell in 0..cells.len() {
            for_pairs(cells.columns(cell), |_, low, high| {
                // Every pair is in the pattern, which was made of them.
                places.push(lower.place(high, low).unwrap_or(0));
            });
            starts.push(places.len());
        }
        Self { lower, places, starts, scalar: None, coupled: None }
    }

    /// Number of coefficients.
    pub(crate) fn size(&self) -> usize {
        self.lower.size()
    }

    pub(crate) fn zeros(&self, components: usize) -> Blocks {
        Blocks { components, values: vec![0.0; self.lower.values().len() * components] }
    }

    /// Adds the sums of a cell: for each component the pairs `(i, j ≤ i)`.
    pub(crate) fn scatter(&self, cells: &CellTable, cell: usize, sums: &[f64], to: &mut Blocks) {
        let places = &self.places[self.starts[cell]..self.starts[cell + 1]];
        let (count, width) = (places.len(), to.components);
        for_pairs(cells.columns(cell), |pair, low, high| {
            let twice = low == high && !is_diagonal(pair);
            let factor = if twice { 2.0 } else { 1.0 };
            let at = places[pair] * width;
            for (s, value) in to.values[at..at + width].iter_mut().enumerate() {
                *value += factor * sums[s * count + pair];
            }
        });
    }

    /// Adds the square of a linear form of the coefficients of a cell to a matrix of whole blocks.
    pub(crate) fn add_square<const D: usize>(
        &self,
        cells: &CellTable,
        cell: usize,
        form: &[SVector<f64, D>],
        to: &mut Blocks,
    ) {
        let (places, columns) = (&self.places[self.starts[cell]..self.starts[cell + 1]], cells.columns(cell));
        let mut pair = 0;
        for (i, &a) in columns.iter().enumerate() {
            for (j, &b) in columns[..=i].iter().enumerate() {
                // The row belongs to the higher coefficient.
                let (high, low) = if a >= b { (&form[i], &form[j]) } else { (&form[j], &form[i]) };
                let mut block = high * low.transpose();
                if a == b && i != j {
                    block += block.transpose();
                }
                let at = places[pair] * D * D;
                for r in 0..D {
                    for c in 0..D {
                        to.values[at + r * D + c] += block[(r, c)];
                    }
                }
                pair += 1;
            }
        }
    }

    /// The same matrix with whole blocks.
    pub(crate) fn with_whole_blocks<const D: usize>(&self, blocks: &Blocks) -> Blocks {
        let mut out = self.zeros(D * D);
        for place in 0..self.lower.values().len() {
            for r in 0..D {
                for c in 0..D {
                    out.values[(place * D + r) * D + c] = blocks.entry::<D>(place, r, c);
                }
            }
        }
        out
    }

    /// The sum of quadratic forms on cells as one matrix of numbers.
    pub(crate) fn gram(&self, cells: &CellTable, grams: &[CellGram]) -> Blocks {
        let mut out = self.zeros(1);
        for form in grams {
            let k = cells.columns(form.cell).len();
            let mut sums = Vec::with_capacity(triangle(k));
            for i in 0..k {
                sums.extend_from_slice(&form.gram[i * k..=i * k + i]);
            }
            self.scatter(cells, form.cell, &sums, &mut out);
        }
        out
    }

    /// The product of a matrix with a vector of coefficients.
    pub(crate) fn multiply<const D: usize>(
        &self,
        blocks: &Blocks,
        x: &[SVector<f64, D>],
    ) -> Vec<SVector<f64, D>> {
        let mut out = vec![SVector::zeros(); x.len()];
        self.for_entries(|row, column, place| {
            let block = blocks.block::<D>(place);
            out[row] += block * x[column];
            if row != column {
                out[column] += block.tr_mul(&x[row]);
            }
        });
        out
    }

    fn for_entries(&self, mut f: impl FnMut(usize, usize, usize)) {
        let mut place = 0;
        for column in 0..self.lower.size() {
            for &row in self.lower.rows(column) {
                f(row, column, place);
                place += 1;
            }
        }
    }

    /// The mean of the diagonal.
    pub(crate) fn mean_diagonal<const D: usize>(&self, blocks: &Blocks) -> f64 {
        let mut sum = 0.0;
        self.for_entries(|row, column, place| {
            if row == column {
                sum += blocks.diagonal::<D>(place);
            }
        });
        sum / self.size() as f64
    }

    /// Factors `matrix + λ · energy + damping · I`, without what is not free.
    ///
    /// `None` when this is not positive definite.
    pub(crate) fn factor<const D: usize>(
        &mut self,
        matrix: &Blocks,
        (lambda, energy): (f64, &Blocks),
        damping: f64,
        freedom: &Freedom<D>,
    ) -> Option<Factor> {
        if matrix.components == 1 && freedom.is_full() {
            let mut lower = self.lower.clone();
            let values = lower.values_mut();
            for (place, value) in values.iter_mut().enumerate() {
                *value = matrix.values[place] + lambda * energy.values[place];
            }
            self.for_entries(|row, column, place| {
                if row == column {
                    values[place] += damping;
                }
            });
            if self.scalar.is_none() {
                self.scalar = Some(Pattern::new(&lower)?);
            }
            return Some(Factor { scalar: true, cholesky: self.scalar.as_ref()?.factor(&lower)? });
        }
        if self.coupled.is_none() {
            let big = self.expanded_pattern(D);
            let pattern = Pattern::new(&big)?;
            self.coupled = Some((big, pattern));
        }
        let (mut big, pattern) = self.coupled.take()?;
        self.fill::<D>(&mut big, matrix, (lambda, energy), damping, freedom);
        let cholesky = pattern.factor(&big);
        self.coupled = Some((big, pattern));
        Some(Factor { scalar: false, cholesky: cholesky? })
    }

    fn expanded_pattern(&self, dimension: usize) -> Sparse {
        let mut columns = Vec::with_capacity(self.size() * dimension);
        for column in 0..self.size() {
            for c in 0..dimension {
                let first = column * dimension + c;
                let rows = self.lower.rows(column).iter();
                let all = rows.flat_map(|&row| row * dimension..(row + 1) * dimension);
                columns.push(all.filter(|&row| row >= first).collect());
            }
        }
        Sparse::with_pattern(columns)
    }

    fn fill<const D: usize>(
        &self,
        big: &mut Sparse,
        matrix: &Blocks,
        (lambda, energy): (f64, &Blocks),
        damping: f64,
        freedom: &Freedom<D>,
    ) {
        let values = big.values_mut();
        let (mut at, mut start) = (0, 0);
        let mut blocks: Vec<SMatrix<f64, D, D>> = Vec::new();
        for column in 0..self.size() {
            let rows = self.lower.rows(column);
            blocks.clear();
            for (k, &row) in rows.iter().enumerate() {
                let place = start + k;
                let mut block = matrix.block::<D>(place);
                let more = lambda * energy.values[place] + if row == column { damping } else { 0.0 };
                (0..D).for_each(|c| block[(c, c)] += more);
                blocks.push(if freedom.is_full() { block } else { freedom.restricted(row, column, block) });
            }
            for c in 0..D {
                for (block, &row) in blocks.iter().zip(rows) {
                    for r in if row == column { c } else { 0 }..D {
                        values[at] = block[(r, c)];
                        at += 1;
                    }
                }
            }
            start += rows.len();
        }
    }
}

impl Blocks {
    /// An entry of a block.
    #[inline]
    fn entry<const D: usize>(&self, place: usize, r: usize, c: usize) -> f64 {
        match self.components {
            1 if r == c => self.values[place],
            1 => 0.0,
            whole if whole == D * D => self.values[(place * D + r) * D + c],
            _ => {
                let (high, low) = if r >= c { (r, c) } else { (c, r) };
                self.values[place * self.components + triangle(high) + low]
            }
        }
    }

    #[inline]
    fn block<const D: usize>(&self, place: usize) -> SMatrix<f64, D, D> {
        SMatrix::from_fn(|r, c| self.entry::<D>(place, r, c))
    }

    fn diagonal<const D: usize>(&self, place: usize) -> f64 {
        (0..D).map(|c| self.entry::<D>(place, c, c)).sum::<f64>() / D as f64
    }
}

/// A factored matrix between coefficients.
#[derive(Clone, Debug)]
pub(crate) struct Factor {
    /// One matrix for all coordinates.
    scalar: bool,
    cholesky: Cholesky,
}

impl Factor {
    /// Solves for one vector of coefficients; `None` when memory is short or the result is not finite.
    pub(crate) fn solve<const D: usize>(&self, rhs: &[SVector<f64, D>]) -> Option<Vec<SVector<f64, D>>> {
        let n = rhs.len();
        let index = |i: usize, c: usize| if self.scalar { c * n + i } else { i * D + c };
        let mut flat = vec![0.0; n * D];
        for (i, v) in rhs.iter().enumerate() {
            (0..D).for_each(|c| flat[index(i, c)] = v[c]);
        }
        let solved = self.cholesky.solve(&mut flat) && flat.iter().all(|x| x.is_finite());
        solved.then(|| (0..n).map(|i| SVector::from_fn(|c, _| flat[index(i, c)])).collect())
    }
}

/// Calls `f(pair, lower coefficient, higher coefficient)` for the pairs `(i, j ≤ i)` of a cell.
fn for_pairs(columns: &[usize], mut f: impl FnMut(usize, usize, usize)) {
    let mut pair = 0;
    for (i, &a) in columns.iter().enumerate() {
        for &b in &columns[..=i] {
            f(pair, a.min(b), a.max(b));
            pair += 1;
        }
    }
}

/// Whether a pair `(i, j ≤ i)` has `i = j`: the last of its row.
fn is_diagonal(pair: usize) -> bool {
    let mut last = 0;
    let mut step = 2;
    while last < pair {
        last += step;
        step += 1;
    }
    last == pair
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector2;

    #[test]
    fn squares_of_linear_forms_agree_with_a_dense_matrix() {
        let cells = CellTable::new([vec![2, 0, 1], vec![1, 3, 1]]);
        let layout = Layout::new(&cells, 4);
        let mut blocks = layout.zeros(4);
        let mut dense = nalgebra::DMatrix::<f64>::zeros(8, 8);
        for cell in 0..2 {
            let form = [0.5, -1.0, 2.0].map(|a| Vector2::new(a, 0.3 - a * a + cell as f64));
            let mut row = nalgebra::DVector::<f64>::zeros(8);
            for (g, &i) in form.iter().zip(cells.columns(cell)) {
                (0..2).for_each(|c| row[2 * i + c] += g[c]);
            }
            dense += &row * row.transpose();
            layout.add_square(&cells, cell, &form, &mut blocks);
        }
        let x: Vec<_> = (0..4).map(|i| Vector2::new(1.0 + i as f64, 0.5 - (i * i) as f64)).collect();
        let flat = nalgebra::DVector::from_iterator(8, x.iter().flat_map(|v| [v.x, v.y]));
        let (product, expected) = (layout.multiply(&blocks, &x), dense * flat);
        for i in 0..4 {
            assert!((product[i] - Vector2::new(expected[2 * i], expected[2 * i + 1])).norm() < 1e-12);
        }
    }

    #[test]
    fn blocks_agree_with_a_dense_matrix() {
        // Three functions on each of three cells of a ring of four coefficients; one cell meets a coefficient twice.
        let cells = CellTable::new([vec![0, 1, 2], vec![2, 3, 0], vec![3, 1, 3]]);
        let mut layout = Layout::new(&cells, 4);
        let mut blocks = layout.zeros(3);
        let mut dense = nalgebra::DMatrix::<f64>::zeros(8, 8);
        for cell in 0..3 {
            // Q = A Aᵀ of a point with basis values b.
            let b = [0.2 + 0.1 * cell as f64, 0.5, 0.3 - 0.1 * cell as f64];
            for (k, q) in [[2.0, 0.3, 1.0], [1.0, -0.4, 3.0]].into_iter().enumerate() {
                let mut sums = vec![0.0; 18];
                for s in 0..3 {
                    let mut pair = 0;
                    for i in 0..3 {
                        for j in 0..=i {
                            sums[s * 6 + pair] += q[s] * (b[i] + k as f64) * (b[j] + k as f64);
                            pair += 1;
                        }
                    }
                }
                layout.scatter(&cells, cell, &sums, &mut blocks);
                for (i, &ci) in cells.columns(cell).iter().enumerate() {
                    for (j, &cj) in cells.columns(cell).iter().enumerate() {
                        for r in 0..2 {
                            for c in 0..2 {
                                let entry = q[if r == c { 2 * r } else { 1 }];
                                dense[(2 * ci + r, 2 * cj + c)] +=
                                    entry * (b[i] + k as f64) * (b[j] + k as f64);
                            }
                        }
                    }
                }
            }
        }
        let x: Vec<_> = (0..4).map(|i| Vector2::new(i as f64, 1.5 - i as f64 * i as f64)).collect();
        let flat = nalgebra::DVector::from_iterator(8, x.iter().flat_map(|v| [v.x, v.y]));
        let product = layout.multiply(&blocks, &x);
        let expected = &dense * &flat;
        for i in 0..4 {
            assert!((product[i] - Vector2::new(expected[2 * i], expected[2 * i + 1])).norm() < 1e-12);
        }
        let energy = layout.zeros(1);
        let mut freedom = Freedom::full();
        let factor = layout.factor::<2>(&blocks, (0.0, &energy), 1e-3, &freedom).unwrap();
        let back = factor.solve(&x).unwrap();
        let expected = (&dense + nalgebra::DMatrix::identity(8, 8) * 1e-3).lu().solve(&flat).unwrap();
        for i in 0..4 {
            let expected = Vector2::new(expected[2 * i], expected[2 * i + 1]);
            assert!((back[i] - expected).norm() < 1e-9 * expected.norm().max(1.0));
        }
        freedom.fix(1);
        let factor = layout.factor::<2>(&blocks, (0.0, &energy), 1e-3, &freedom).unwrap();
        let mut forces = [Vector2::x(); 4];
        forces[1] = Vector2::zeros();
        assert_eq!(factor.solve(&forces).unwrap()[1], Vector2::zeros());
    }
}
