//! Normal equations: least squares with fixed coefficients and a quadratic energy.

use super::observations::{Observations, Space};
use crate::Error;
use crate::linear::{Cholesky, Sparse};
use std::collections::BTreeMap;

/// Below this smallest eigenvalue of the matrix with unit diagonal the data do not determine the shape.
const SINGULAR: f64 = 1e-14;

/// Names of control points given in an error message.
const NAMES: usize = 8;

/// A quadratic form on the coefficients of a cell.
#[derive(Clone, Debug)]
pub(crate) struct Block {
    pub(crate) columns: Vec<usize>,
    /// Symmetric, row after row.
    pub(crate) gram: Vec<f64>,
}

/// The coefficients (all, `width` numbers each) that minimise `Σ w_k |s(t_k) − x_k|² + energy`, where
/// those in `fixed` have their values.
pub(crate) fn solve(
    space: &Space,
    data: &Observations,
    energy: &[Block],
    fixed: &BTreeMap<usize, Vec<f64>>,
) -> Result<Vec<f64>, Error> {
    let (count, w) = (space.len(), data.width);
    let mut unknown = vec![None; count];
    let mut free = Vec::new();
    for (i, slot) in unknown.iter_mut().enumerate().filter(|(i, _)| !fixed.contains_key(i)) {
        *slot = Some(free.len());
        free.push(i);
    }
    // Starting from the mean, coordinates far from the origin cost no digits.
    let mut coefficients = mean(data).repeat(count);
    for (&i, value) in fixed {
        coefficients[i * w..(i + 1) * w].copy_from_slice(value);
    }
    if free.is_empty() {
        return Ok(coefficients);
    }
    let mut blocks = grams(data);
    blocks.extend_from_slice(energy);
    let mut matrix = assemble(&blocks, &unknown, free.len());
    let scale = equilibrate(&mut matrix, space, &free)?;
    let factor = factor(&matrix, space, &free)?;

    let n = free.len();
    for _ in 0..4 {
        let gradient = gradient(data, energy, &coefficients);
        let mut step = vec![0.0; n * w];
        for (k, &i) in free.iter().enumerate() {
            for c in 0..w {
                step[c * n + k] = gradient[i * w + c] * scale[k];
            }
        }
        if !factor.solve(&mut step) {
            return Err(Error::Singular { what: "not enough memory to solve it".into() });
        }
        let (mut change, mut size) = (0.0_f64, 0.0_f64);
        for (k, &i) in free.iter().enumerate() {
            for c in 0..w {
                let delta = step[c * n + k] * scale[k];
                coefficients[i * w + c] += delta;
                change = change.max(delta.abs());
                size = size.max(coefficients[i * w + c].abs());
            }
        }
        // A further pass mends what squaring the condition number has cost.
        if change <= 4.0 * f64::EPSILON * size {
            break;
        }
    }
    Ok(coefficients)
}

fn mean(data: &Observations) -> Vec<f64> {
    let mut mean = vec![0.0; data.width];
    for (point, weight) in data.values.chunks_exact(data.width).zip(&data.weights) {
        for (m, x) in mean.iter_mut().zip(point) {
            *m += weight * x;
        }
    }
    mean
}

/// `Σ w b bᵀ` of every cell.
fn grams(data: &Observations) -> Vec<Block> {
    let block = |cell: &super::observations::Cell| {
        let k = cell.columns.len();
        let mut gram = vec![0.0; k * k];
        for slot in cell.points.clone() {
            let b = &data.basis[slot * k..(slot + 1) * k];
            for (i, x) in b.iter().enumerate() {
                let x = x * data.weights[slot];
                for (g, y) in gram[i * k..=i * k + i].iter_mut().zip(b) {
                    *g += x * y;
                }
            }
        }
        for i in 0..k {
            for j in 0..i {
                gram[j * k + i] = gram[i * k + j];
            }
        }
        Block { columns: cell.columns.clone(), gram }
    };
    data.cells.iter().map(block).collect()
}

fn assemble(blocks: &[Block], unknown: &[Option<usize>], n: usize) -> Sparse {
    let mut pattern: Vec<Vec<usize>> = (0..n).map(|j| vec![j]).collect();
    let pairs = |block: &Block, f: &mut dyn FnMut(usize, usize, f64)| {
        let k = block.columns.len();
        for (a, &row) in block.columns.iter().enumerate() {
            let Some(row) = unknown[row] else { continue };
            for (b, &column) in block.columns.iter().enumerate() {
                if let Some(column) = unknown[column].filter(|&column| column <= row) {
                    f(row, column, block.gram[a * k + b]);
                }
            }
        }
    };
    for block in blocks {
        pairs(block, &mut |row, column, _| pattern[column].push(row));
    }
    let mut matrix = Sparse::with_pattern(pattern);
    for block in blocks {
        pairs(block, &mut |row, column, value| matrix.add(row, column, value));
    }
    matrix
}

/// Scales the matrix to a unit diagonal; returns the factors `1/√a_ii`.
fn equilibrate(matrix: &mut Sparse, space: &Space, free: &[usize]) -> Result<Vec<f64>, Error> {
    let diagonal = |j: usize| matrix.values[matrix.starts[j]];
    let largest = (0..matrix.size).map(diagonal).fold(0.0, f64::max);
    let empty: Vec<usize> = (0..matrix.size).filter(|&j| diagonal(j) <= 1e-30 * largest).collect();
    if !empty.is_empty() {
        return Err(singular(space, empty.into_iter().map(|j| free[j])));
    }
    let scale: Vec<f64> = (0..matrix.size).map(|j| 1.0 / diagonal(j).sqrt()).collect();
    for j in 0..matrix.size {
        for k in matrix.starts[j]..matrix.starts[j + 1] {
            matrix.values[k] *= scale[j] * scale[matrix.rows[k]];
        }
    }
    Ok(scale)
}

/// Factors the scaled matrix, or names the control points that the data leave undetermined.
fn factor(matrix: &Sparse, space: &Space, free: &[usize]) -> Result<Cholesky, Error> {
    if let Some(factor) = Cholesky::new(matrix) {
        let (least, vector) = weakest(&factor, matrix.size);
        return if least > SINGULAR { Ok(factor) } else { Err(undetermined(space, free, &vector)) };
    }
    let mut shifted = matrix.clone();
    for j in 0..matrix.size {
        shifted.values[matrix.starts[j]] += 1e-10;
    }
    match Cholesky::new(&shifted) {
        Some(factor) => Err(undetermined(space, free, &weakest(&factor, matrix.size).1)),
        None => Err(Error::Singular { what: "the sums of the data are not finite".into() }),
    }
}

/// Estimate of the least eigenvalue and its vector by inverse iteration.
fn weakest(factor: &Cholesky, n: usize) -> (f64, Vec<f64>) {
    // Any start with a part in every direction; the golden ratio gives one without a period.
    let mut x: Vec<f64> = (0..n).map(|i| (i as f64 * 0.618_033_988_749_894_9).fract() - 0.5).collect();
    let mut least = f64::INFINITY;
    for _ in 0..4 {
        let norm = x.iter().map(|v| v * v).sum::<f64>().sqrt();
        if norm.is_nan() || norm == 0.0 || norm.is_infinite() {
            return (0.0, x);
        }
        x.iter_mut().for_each(|v| *v /= norm);
        let before = x.clone();
        if !factor.solve(&mut x) {
            return (0.0, before);
        }
        least = 1.0 / x.iter().map(|v| v * v).sum::<f64>().sqrt();
    }
    (least, x)
}

fn undetermined(space: &Space, free: &[usize], vector: &[f64]) -> Error {
    let largest = vector.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
    let concerned = (0..vector.len()).filter(|&k| vector[k].abs() >= 0.1 * largest);
    singular(space, concerned.map(|k| free[k]))
}

fn singular(space: &Space, concerned: impl Iterator<Item = usize>) -> Error {
    let all: Vec<usize> = concerned.collect();
    let mut names: Vec<String> = all.iter().take(NAMES).map(|&i| space.name(i)).collect();
    if all.len() > NAMES {
        names.push(format!("and {} more", all.len() - NAMES));
    }
    Error::Singular {
        what: format!(
            "too few data points determine the control points {}; use fewer knots there, more data, \
             or a small regularization",
            names.join(", ")
        ),
    }
}

/// Half the negative gradient of the objective with respect to every coefficient.
fn gradient(data: &Observations, energy: &[Block], coefficients: &[f64]) -> Vec<f64> {
    let (w, mut out) = (data.width, vec![0.0; coefficients.len()]);
    data.for_residuals(coefficients, |cell, slot, residual| {
        let k = cell.columns.len();
        for (&column, b) in cell.columns.iter().zip(&data.basis[slot * k..(slot + 1) * k]) {
            let b = b * data.weights[slot];
            for (g, r) in out[column * w..(column + 1) * w].iter_mut().zip(residual) {
                *g += b * r;
            }
        }
    });
    for block in energy {
        let k = block.columns.len();
        for (&row, line) in block.columns.iter().zip(block.gram.chunks_exact(k)) {
            for (&column, e) in block.columns.iter().zip(line) {
                for c in 0..w {
                    out[row * w + c] -= e * coefficients[column * w + c];
                }
            }
        }
    }
    out
}
