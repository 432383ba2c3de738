//! Fairing of the parameterisation: the energy in the tangent planes.

use crate::assemble::Normal;
use crate::layout::{Blocks, Layout, triangle};
use crate::shape::{ActiveShape, CellGram};
use nalgebra::SVector;

/// The quadratic form `factor · Σ_cells ⟨E, I − n nᵀ⟩`, its normals those of the shape at the beginning of a step.
///
/// Motions of the control points within the tangent planes hardly change distances, so that noise decides about them where
/// nothing else does; they end in folds. The energy of the shape itself would have to be so large that it costs accuracy.
#[derive(Clone, Debug)]
pub(crate) struct Fairing {
    blocks: Blocks,
}

impl Fairing {
    /// `None` where there is nothing to do: no factor, no normals.
    pub(crate) fn new<const D: usize, S: ActiveShape<D>>(
        layout: &Layout,
        shape: &S,
        grams: &[CellGram],
        factor: f64,
    ) -> Option<Self> {
        let planes = if factor > 0.0 { shape.tangent_planes() } else { Vec::new() };
        if planes.is_empty() {
            return None;
        }
        let components = triangle(D);
        let mut blocks = layout.zeros(components);
        for form in grams {
            let (normal, more) = planes.get(form.cell)?;
            let width = shape.cells().columns(form.cell).len();
            let pairs = triangle(width);
            let mut sums = vec![0.0; pairs * components];
            let mut component = 0;
            for row in 0..D {
                for column in 0..=row {
                    let unit = if row == column { 1.0 } else { 0.0 };
                    let share = factor * more * (unit - normal[row] * normal[column]);
                    let mut at = component * pairs;
                    for i in 0..width {
                        for j in 0..=i {
                            sums[at] = share * form.gram[i * width + j];
                            at += 1;
                        }
                    }
                    component += 1;
                }
            }
            layout.scatter(shape.cells(), form.cell, &sums, &mut blocks);
        }
        Some(Self { blocks })
    }

    /// The form with a smaller factor where its value is more than `most`.
    pub(crate) fn capped<const D: usize>(
        mut self,
        layout: &Layout,
        coefficients: &[SVector<f64, D>],
        most: f64,
    ) -> Self {
        let value = self.value(layout, coefficients);
        if value > most {
            self.blocks.values.iter_mut().for_each(|v| *v *= most / value);
        }
        self
    }

    /// Adds the form to normal equations with all components.
    pub(crate) fn add_to<const D: usize>(
        &self,
        layout: &Layout,
        normal: &mut Normal<D>,
        coefficients: &[SVector<f64, D>],
    ) {
        for (to, from) in normal.matrix.values.iter_mut().zip(&self.blocks.values) {
            *to += from;
        }
        let image = layout.multiply(&self.blocks, coefficients);
        normal.vector.iter_mut().zip(&image).for_each(|(v, b)| *v -= b);
    }

    /// Its value.
    pub(crate) fn value<const D: usize>(&self, layout: &Layout, coefficients: &[SVector<f64, D>]) -> f64 {
        let image = layout.multiply(&self.blocks, coefficients);
        coefficients.iter().zip(&image).map(|(a, b)| a.dot(b)).sum::<f64>().max(0.0)
    }
}
