//! The spline space of a fit and the data observed in it.

use crate::{Error, KnotVector, MAX_DEGREE, basis};

/// The space in which a curve (one knot vector) or surface (two) is sought.
///
/// Coefficients are the control points that are not repetitions, row-major.
#[derive(Clone, Debug)]
pub(crate) struct Space {
    pub(crate) u: KnotVector,
    pub(crate) v: Option<KnotVector>,
}

impl Space {
    /// Number of coefficients.
    pub(crate) fn len(&self) -> usize {
        self.u.distinct_count() * self.v.as_ref().map_or(1, KnotVector::distinct_count)
    }

    /// Number of basis functions that do not vanish on a cell.
    pub(crate) fn per_cell(&self) -> usize {
        (self.u.degree() + 1) * self.v.as_ref().map_or(1, |v| v.degree() + 1)
    }

    /// Index of the coefficient of the control point `(i, j)`.
    pub(crate) fn index(&self, i: usize, j: usize) -> usize {
        let row = i % self.u.distinct_count();
        self.v.as_ref().map_or(row, |v| row * v.distinct_count() + j % v.distinct_count())
    }

    /// How a coefficient is named in messages.
    pub(crate) fn name(&self, index: usize) -> String {
        match &self.v {
            None => index.to_string(),
            Some(v) => format!("({}, {})", index / v.distinct_count(), index % v.distinct_count()),
        }
    }

    /// The spans of a parameter, or why it has none.
    fn locate(&self, k: usize, parameter: [f64; 2]) -> Result<([f64; 2], usize, usize), Error> {
        let place = |knots: &KnotVector, t: f64| {
            let domain = knots.domain();
            if t.is_finite() && (knots.is_periodic() || domain.contains(t)) {
                let t = knots.normalize(t);
                Ok((t, knots.span(t)))
            } else {
                Err(Error::argument(format!(
                    "parameter {t} of data point {k} lies outside the domain [{}, {}]",
                    domain.start(),
                    domain.end()
                )))
            }
        };
        let (u, span_u) = place(&self.u, parameter[0])?;
        let (v, span_v) = self.v.as_ref().map_or(Ok((0.0, 0)), |knots| place(knots, parameter[1]))?;
        Ok(([u, v], span_u, span_v))
    }

    /// The coefficients of the functions of a cell.
    pub(crate) fn columns(&self, span_u: usize, span_v: usize) -> Vec<usize> {
        let p = self.u.degree();
        let q = self.v.as_ref().map_or(0, KnotVector::degree);
        let rows = span_u - p..=span_u;
        rows.flat_map(|i| (span_v - q..=span_v).map(move |j| self.index(i, j))).collect()
    }

    /// The values of the functions of a cell.
    fn values(&self, span_u: usize, span_v: usize, at: [f64; 2], out: &mut [f64]) {
        let (mut a, mut b) = ([0.0; MAX_DEGREE + 1], [0.0; MAX_DEGREE + 1]);
        basis::values(&self.u, span_u, at[0], &mut a);
        match &self.v {
            None => out.copy_from_slice(&a[..out.len()]),
            Some(v) => {
                let q = v.degree();
                basis::values(v, span_v, at[1], &mut b);
                for (row, x) in out.chunks_exact_mut(q + 1).zip(a) {
                    for (slot, y) in row.iter_mut().zip(&b[..=q]) {
                        *slot = x * y;
                    }
                }
            }
        }
    }

    /// All control points from the coefficients: those of periodic directions repeat.
    pub(crate) fn expand(&self, coefficients: &[f64], width: usize) -> Vec<f64> {
        let columns = self.v.as_ref().map_or(1, KnotVector::basis_count);
        let mut out = Vec::with_capacity(self.u.basis_count() * columns * width);
        for i in 0..self.u.basis_count() {
            for j in 0..columns {
                let at = self.index(i, j) * width;
                out.extend_from_slice(&coefficients[at..at + width]);
            }
        }
        out
    }
}

/// Data points that share a cell of the space.
#[derive(Debug)]
pub(crate) struct Cell {
    pub(crate) columns: Vec<usize>,
    /// Range of the points in the order of [`Observations`].
    pub(crate) points: std::ops::Range<usize>,
}

/// Data points sorted by cells, with the values of the basis functions there.
#[derive(Debug)]
pub(crate) struct Observations {
    pub(crate) cells: Vec<Cell>,
    /// Original index of each point.
    pub(crate) order: Vec<usize>,
    /// Values of the basis functions, `per_cell` for each point.
    pub(crate) basis: Vec<f64>,
    /// Weights; they sum to 1.
    pub(crate) weights: Vec<f64>,
    /// What is observed, `width` numbers for each point.
    pub(crate) values: Vec<f64>,
    pub(crate) width: usize,
}

impl Observations {
    /// Sorts the points into cells.
    ///
    /// `values` holds `width` numbers for each parameter.
    pub(crate) fn new(
        space: &Space,
        parameters: &[[f64; 2]],
        values: &[f64],
        width: usize,
        weights: Option<&[f64]>,
    ) -> Result<Self, Error> {
        let count = parameters.len();
        if values.len() != count * width {
            return Err(Error::argument(format!(
                "{count} parameters were given for {} data points",
                values.len() / width
            )));
        }
        if let Some(i) = values.iter().position(|x| !x.is_finite()) {
            return Err(Error::argument(format!(
                "data point {} has a coordinate that is not finite",
                i / width
            )));
        }
        let total = total_weight(weights, count)?;
        let located: Vec<_> =
            parameters.iter().enumerate().map(|(k, &at)| space.locate(k, at)).collect::<Result<_, _>>()?;
        let mut order: Vec<usize> = (0..count).collect();
        // Stable, so that sums run in the order of the data.
        order.sort_by_key(|&k| (located[k].1, located[k].2));
        let k = space.per_cell();
        let mut basis = vec![0.0; count * k];
        let mut cells = Vec::new();
        let mut start = 0;
        for run in order.chunk_by(|&a, &b| (located[a].1, located[a].2) == (located[b].1, located[b].2)) {
            let (_, span_u, span_v) = located[run[0]];
            let points = start..start + run.len();
            for (slot, &i) in points.clone().zip(run) {
                space.values(span_u, span_v, located[i].0, &mut basis[slot * k..(slot + 1) * k]);
            }
            start = points.end;
            cells.push(Cell { columns: space.columns(span_u, span_v), points });
        }
        let weight = |i: usize| weights.map_or(1.0, |w| w[i]) / total;
        Ok(Self {
            cells,
            basis,
            weights: order.iter().map(|&i| weight(i)).collect(),
            values: order.iter().flat_map(|&i| &values[i * width..(i + 1) * width]).copied().collect(),
            order,
            width,
        })
    }

    /// Calls `f(slot, residual)` for every point: what is observed minus what the coefficients give.
    pub(crate) fn for_residuals(&self, coefficients: &[f64], mut f: impl FnMut(&Cell, usize, &[f64])) {
        let w = self.width;
        let mut residual = vec![0.0; w];
        for cell in &self.cells {
            let k = cell.columns.len();
            for slot in cell.points.clone() {
                residual.copy_from_slice(&self.values[slot * w..(slot + 1) * w]);
                for (&column, b) in cell.columns.iter().zip(&self.basis[slot * k..(slot + 1) * k]) {
                    for (r, c) in residual.iter_mut().zip(&coefficients[column * w..(column + 1) * w]) {
                        *r -= b * c;
                    }
                }
                f(cell, slot, &residual);
            }
        }
    }
}

fn total_weight(weights: Option<&[f64]>, count: usize) -> Result<f64, Error> {
    let Some(weights) = weights else { return Ok(count.max(1) as f64) };
    if weights.len() != count {
        return Err(Error::WeightCount { found: weights.len(), needed: count });
    }
    if let Some(i) = weights.iter().position(|w| !(w.is_finite() && *w >= 0.0)) {
        return Err(Error::argument(format!(
            "weight {} of data point {i} must be finite and not negative",
            weights[i]
        )));
    }
    let total: f64 = weights.iter().sum();
    if total > 0.0 && total.is_finite() {
        Ok(total)
    } else {
        Err(Error::argument("the weights of the data points must have a positive, finite sum"))
    }
}
