//! What the loop asks of a shape: points that depend linearly on the unknowns.

use crate::Error;
use distance_field::{ErrorTerm, PrincipalFrame, Search};
use nalgebra::{SMatrix, SVector};

/// The cells of a shape (spans of a curve, patches of a surface, triangles of a subdivision surface), each with the
/// coefficients that act on it.
///
/// The cells decide which entries of the normal equations do not vanish.
#[derive(Clone, Debug, PartialEq)]
pub struct CellTable {
    starts: Vec<usize>,
    columns: Vec<usize>,
    widest: usize,
}

impl CellTable {
    /// A table from the coefficients of each cell, in the order in which [`ActiveShape::basis`] gives the values of their
    /// functions.
    #[must_use]
    pub fn new<C: AsRef<[usize]>>(cells: impl IntoIterator<Item = C>) -> Self {
        let mut out = Self { starts: vec![0], columns: Vec::new(), widest: 0 };
        for cell in cells {
            out.columns.extend_from_slice(cell.as_ref());
            out.starts.push(out.columns.len());
            out.widest = out.widest.max(cell.as_ref().len());
        }
        out
    }

    /// Number of cells.
    #[must_use]
    pub fn len(&self) -> usize {
        self.starts.len() - 1
    }

    /// Whether there is no cell.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The coefficients that act on a cell. One may occur twice, where a short period meets itself.
    #[must_use]
    pub fn columns(&self, cell: usize) -> &[usize] {
        &self.columns[self.starts[cell]..self.starts[cell + 1]]
    }

    /// The largest number of coefficients of a cell.
    #[must_use]
    pub fn widest(&self) -> usize {
        self.widest
    }
}

/// A quadratic form on the coefficients of one cell, the same for every coordinate.
#[derive(Clone, Debug, PartialEq)]
pub struct CellGram {
    /// The cell.
    pub cell: usize,
    /// Symmetric matrix, row after row, of as many rows as the cell has coefficients.
    pub gram: Vec<f64>,
}

/// Something that a shape is to fulfil besides being near the target, as a residual whose square is added to the cost.
#[derive(Clone, Debug, PartialEq)]
pub struct Penalty<const D: usize> {
    /// The cell on whose coefficients it depends.
    pub cell: usize,
    /// The residual.
    pub value: f64,
    /// Its derivatives by the coefficients of the cell.
    pub gradient: Vec<SVector<f64, D>>,
}

/// A shape in `R^D` whose points are linear in its unknowns, the coefficients `dᵢ`: `s(u, v) = Σ Bᵢ(u, v) dᵢ`
/// (\[P05, eq. (6)\]).
///
/// Curves use the first parameter only. An implementation says where its basis functions live, what they are worth, and
/// where the nearest points of given points lie; the loop ([`fit`](crate::fit())) does the rest.
pub trait ActiveShape<const D: usize>: Clone + Send + Sync {
    /// The unknowns: control points that are not repetitions of others.
    fn coefficients(&self) -> &[SVector<f64, D>];

    /// Replaces the unknowns.
    ///
    /// # Errors
    /// [`Error::Shape`] when their number is wrong or one is not finite.
    fn set_coefficients(&mut self, coefficients: &[SVector<f64, D>]) -> Result<(), Error>;

    /// The cells.
    fn cells(&self) -> &CellTable;

    /// The cell of a parameter of the domain.
    fn cell(&self, parameter: [f64; 2]) -> usize;

    /// The values at a parameter of the functions of its cell; `values` has one place for each of
    /// [`CellTable::columns`].
    fn basis(&self, parameter: [f64; 2], cell: usize, values: &mut [f64]);

    /// The energy `F_s = Σ_k weights[k − 1] · ∫ |∂ᵏs|²`, `k = 1, 2, 3`, divided by the measure of the domain, where
    /// parameters are scaled so that a span has the length 1 on average: it does not depend on the parameterisation of the
    /// file, and is comparable with a mean squared distance.
    ///
    /// For surfaces the squares are those of all partial derivatives of the order, mixed ones counted as often as they
    /// occur (`|s_uu|² + 2 |s_uv|² + |s_vv|²`, the thin plate, for the second).
    fn energy(&self, weights: [f64; 3]) -> Vec<CellGram>;

    /// A unit normal for each cell, across which the fairing of the parameterisation does not act, and how much the cell
    /// counts in it, at least 1 ([`FitOptions::fairing`](crate::FitOptions::fairing)); empty for shapes without fairing.
    fn tangent_planes(&self) -> Vec<(SVector<f64, D>, f64)> {
        Vec::new()
    }

    /// Called after each step that is taken with fairing: a shape may note where it went wrong, for [`Self::tangent_planes`]. By
    /// default it notes nothing.
    fn step_taken(&mut self) {}

    /// What the present shape is to fulfil besides being near the target; nothing by default.
    ///
    /// Each step takes the residuals as linear (Gauss and Newton's method).
    fn penalties(&self) -> Vec<Penalty<D>> {
        Vec::new()
    }

    /// The frames of points at their footpoints on this shape, with the parameter in
    /// [`hint.parameter`](distance_field::Hint::parameter).
    ///
    /// `previous` are frames of the same points on a shape that was a little different, or nothing at all.
    ///
    /// # Errors
    /// [`Error::Field`] when the shape cannot be projected onto.
    fn frames(
        &self,
        points: &[SVector<f64, D>],
        search: Search,
        previous: &[PrincipalFrame<D>],
    ) -> Result<Vec<PrincipalFrame<D>>, Error>;

    /// The matrix of the quadratic model that an error term takes for a data point `x` with this frame.
    ///
    /// Shapes with ends override it, to say what a data point beyond an end is worth.
    fn model(&self, x: &SVector<f64, D>, frame: &PrincipalFrame<D>, term: ErrorTerm) -> SMatrix<f64, D, D> {
        let _ = x;
        term.model(frame).matrix()
    }

    /// Parameters of sensor points, `per_cell` in each direction of every cell, evenly spread inside it.
    fn sensors(&self, per_cell: usize) -> Vec<[f64; 2]>;

    /// The point at a parameter.
    fn point(&self, parameter: [f64; 2]) -> SVector<f64, D> {
        let cell = self.cell(parameter);
        let columns = self.cells().columns(cell);
        let mut values = vec![0.0; columns.len()];
        self.basis(parameter, cell, &mut values);
        combine(columns, &values, self.coefficients())
    }
}

/// `Σ bⱼ dⱼ`.
#[inline]
pub(crate) fn combine<const D: usize>(
    columns: &[usize],
    values: &[f64],
    coefficients: &[SVector<f64, D>],
) -> SVector<f64, D> {
    let mut sum = SVector::zeros();
    for (&column, value) in columns.iter().zip(values) {
        sum += coefficients[column] * *value;
    }
    sum
}
