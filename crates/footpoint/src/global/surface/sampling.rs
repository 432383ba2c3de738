//! Values at which forms are sampled, and the dips that are found.

use crate::global::arithmetic::bernstein::basis_rows;
use crate::global::arithmetic::lanes::{Row, WIDTH, add_scaled, zero_row};
use crate::global::arithmetic::products::part_of_row;

/// Values of the Bernstein polynomials at the places where forms are sampled.
#[derive(Clone, Debug)]
pub(crate) struct Sampling<const K: usize> {
    /// By the degree of the form in `u`, for degrees that occur: polynomial by polynomial, for each of the lines.
    across: Vec<Vec<f64>>,
    /// Row `j`: what coefficient `j` contributes to the `8 K` samples of a line.
    along: Vec<Row<K>>,
}

impl<const K: usize> Sampling<K> {
    /// Prepares forms of `degree` in `u`: `degree + 3` lines.
    pub(in crate::global) fn prepare(&mut self, degree: usize) {
        if self.across.len() <= degree {
            self.across.resize(degree + 1, Vec::new());
        }
        if self.across[degree].is_empty() {
            let lines = degree + 3;
            self.across[degree] = (0..lines)
                .flat_map(|i| {
                    let [values, ..] = basis_rows::<K>(degree, i as f64 / (lines - 1) as f64);
                    (0..=degree).map(move |j| values[j / WIDTH].0[j % WIDTH])
                })
                .collect();
        }
    }

    /// The samples of a form, line by line; its degree must have been prepared.
    #[inline(always)]
    pub(super) fn sample(&self, rows: &[Row<K>], grid: &mut Vec<Row<K>>) {
        grid.clear();
        for shares in self.across[rows.len() - 1].chunks(rows.len()) {
            let mut line = zero_row::<K>();
            for (row, share) in rows.iter().zip(shares) {
                add_scaled(&mut line, row, *share);
            }
            grid.push(part_of_row(&line, &self.along));
        }
    }

    /// The samples of a form of one variable.
    #[inline(always)]
    pub(super) fn sample_row(&self, row: &Row<K>) -> Row<K> {
        part_of_row(row, &self.along)
    }
}

impl<const K: usize> Default for Sampling<K> {
    fn default() -> Self {
        let n = WIDTH * K - 1;
        let mut along = vec![zero_row::<K>(); n + 1];
        for l in 0..=n {
            let [values, ..] = basis_rows::<K>(n, l as f64 / n as f64);
            for (j, row) in along.iter_mut().enumerate() {
                row[l / WIDTH].0[l % WIDTH] = values[j / WIDTH].0[j % WIDTH];
            }
        }
        Self { across: Vec::new(), along }
    }
}

/// A start of a local iteration.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Dip {
    /// Estimate of the squared distance that may be found.
    pub(super) floor_sq: f64,
    pub(super) patch: usize,
    pub(super) place: [f64; 2],
}
