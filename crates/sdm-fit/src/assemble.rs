//! Sums over the samples as dense blocks of cells.

use crate::layout::{Blocks, Layout, triangle};
use crate::parallel;
use crate::shape::{ActiveShape, combine};
use crate::simd::vectorized;
use crate::target::{Feet, Samples};
use distance_field::ErrorTerm;
use nalgebra::SVector;
use std::ops::Range;

/// Samples per task, and tasks whose sums are held at once.
const CHUNK: usize = 512;
const WAVE: usize = 512;

/// The normal equations of one step: `matrix · c = vector` minimises the mean of the quadratic models in the displacements
/// `c` of the coefficients.
#[derive(Clone, Debug)]
pub(crate) struct Normal<const D: usize> {
    pub(crate) matrix: Blocks,
    /// Half the negative gradient.
    pub(crate) vector: Vec<SVector<f64, D>>,
    /// The value of the models before the step.
    pub(crate) value: f64,
}

/// The sums of some samples on one cell.
struct Sums<const D: usize> {
    cell: usize,
    pairs: Vec<f64>,
    vector: Vec<SVector<f64, D>>,
    value: f64,
}

/// Sums the models of all samples with their weights (which sum to 1).
///
/// The point model needs no blocks, the coordinates being apart. Linear in the samples; the same bits for any number of
/// threads, since cells are cut in fixed chunks whose sums are added in their order.
pub(crate) fn assemble<const D: usize, S: ActiveShape<D>>(
    layout: &Layout,
    shape: &S,
    samples: &Samples<'_, D>,
    feet: &Feet<D>,
    weights: &[f64],
    term: ErrorTerm,
) -> Normal<D> {
    let components = if term == ErrorTerm::Point { 1 } else { triangle(D) };
    let order = Order::new(shape, samples, feet, weights);
    let mut matrix = layout.zeros(components);
    let mut vector = vec![SVector::zeros(); layout.size()];
    let mut value = 0.0;
    for wave in order.chunks.chunks(WAVE) {
        let sums = parallel::tasks(wave.len(), |k| {
            let (cell, range) = &wave[k];
            sum(shape, samples, feet, weights, term, components, *cell, &order.sorted[range.clone()])
        });
        for part in sums {
            layout.scatter(shape.cells(), part.cell, &part.pairs, &mut matrix);
            for (&column, v) in shape.cells().columns(part.cell).iter().zip(&part.vector) {
                vector[column] += v;
            }
            value += part.value;
        }
    }
    Normal { matrix, vector, value }
}

/// The samples by cells.
struct Order {
    sorted: Vec<u32>,
    chunks: Vec<(usize, Range<usize>)>,
}

impl Order {
    fn new<const D: usize, S: ActiveShape<D>>(
        shape: &S,
        samples: &Samples<'_, D>,
        feet: &Feet<D>,
        weights: &[f64],
    ) -> Self {
        const UNUSED: u32 = u32::MAX;
        let cells = parallel::map(samples.len(), |i| {
            if weights[i] > 0.0 {
                u32::try_from(shape.cell(samples.parameter(feet, i))).unwrap_or(UNUSED)
            } else {
                UNUSED
            }
        });
        let mut counts = vec![0usize; shape.cells().len() + 1];
        cells.iter().filter(|&&c| c != UNUSED).for_each(|&c| counts[c as usize + 1] += 1);
        for cell in 1..counts.len() {
            counts[cell] += counts[cell - 1];
        }
        let mut sorted = vec![0; counts[counts.len() - 1]];
        let mut next = counts.clone();
        for (index, &cell) in (0u32..).zip(&cells) {
            if cell != UNUSED {
                sorted[next[cell as usize]] = index;
                next[cell as usize] += 1;
            }
        }
        let mut chunks = Vec::new();
        for cell in 0..shape.cells().len() {
            let mut start = counts[cell];
            while start < counts[cell + 1] {
                let end = (start + CHUNK).min(counts[cell + 1]);
                chunks.push((cell, start..end));
                start = end;
            }
        }
        Self { sorted, chunks }
    }
}

#[expect(clippy::too_many_arguments, reason = "the state of one step, passed on")]
fn sum<const D: usize, S: ActiveShape<D>>(
    shape: &S,
    samples: &Samples<'_, D>,
    feet: &Feet<D>,
    weights: &[f64],
    term: ErrorTerm,
    components: usize,
    cell: usize,
    indices: &[u32],
) -> Sums<D> {
    let columns = shape.cells().columns(cell);
    let count = triangle(columns.len());
    let mut out = Sums {
        cell,
        pairs: vec![0.0; count * components],
        vector: vec![SVector::zeros(); columns.len()],
        value: 0.0,
    };
    let mut basis = vec![0.0; columns.len()];
    let mut products = vec![0.0; count];
    let mut factors = vec![0.0; components];
    for &index in indices {
        let (index, weight) = (index as usize, weights[index as usize]);
        let observation = samples.observation(shape, feet, index, term);
        shape.basis(observation.parameter, cell, &mut basis);
        let residual = observation.place - combine(columns, &basis, shape.coefficients());
        let force = observation.matrix * residual * weight;
        out.value += force.dot(&residual);
        for (v, b) in out.vector.iter_mut().zip(&basis) {
            *v += force * *b;
        }
        let lower = (0..D).flat_map(|row| (0..=row).map(move |column| (row, column)));
        for (factor, place) in factors.iter_mut().zip(lower) {
            *factor = observation.matrix[place] * weight;
        }
        vectorized(
            #[inline(always)]
            || add_products(&basis, &factors, &mut products, &mut out.pairs),
        );
    }
    out
}

/// Adds `factorₛ · bᵢ bⱼ` to the sums of each component `s`; `products` is room for the `bᵢ bⱼ`, `j ≤ i`.
#[inline(always)]
pub(crate) fn add_products(basis: &[f64], factors: &[f64], products: &mut [f64], pairs: &mut [f64]) {
    let mut rest = &mut *products;
    for (i, b) in basis.iter().enumerate() {
        let (row, after) = std::mem::take(&mut rest).split_at_mut(i + 1);
        row.iter_mut().zip(basis).for_each(|(product, other)| *product = b * other);
        rest = after;
    }
    for (factor, sums) in factors.iter().zip(pairs.chunks_exact_mut(products.len())) {
        sums.iter_mut().zip(&*products).for_each(|(sum, product)| *sum += factor * product);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn products_of_the_lower_triangle() {
        let mut products = [0.0; 3];
        let mut pairs = [1.0; 6];
        add_products(&[1.0, 2.0], &[1.0, 3.0], &mut products, &mut pairs);
        assert_eq!(pairs, [2.0, 3.0, 5.0, 4.0, 7.0, 13.0]);
    }
}
