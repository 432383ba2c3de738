//! Ruled surfaces as active shapes.

use super::developability::twist;
use crate::shape::{ActiveShape, CellGram, CellTable, Penalty};
use crate::{ActiveSurface, Error};
use distance_field::{ErrorTerm, PrincipalFrame, Search};
use nalgebra::{Matrix3, Vector3};
use nurbs_core::{BsplineSurface, MAX_DEGREE, basis, gauss_legendre};

/// A ruled surface, or layers of them, whose control points are unknown: a B-spline surface of degree 1 in v without weights,
/// open or closed in u (\[P05, sec. 4.5\]).
///
/// Everything but the penalty on twisted rulings is that of [`ActiveSurface`].
#[derive(Clone, Debug)]
pub struct ActiveRuled {
    surface: ActiveSurface,
    /// Length that counts like an angle of one radian between the normals at the ends of a ruling, where that is small.
    abs_twist: f64,
}

impl ActiveRuled {
    /// A surface to start from.
    ///
    /// # Errors
    /// [`Error::NotRuled`] unless its degree in v is 1; [`Error::Rational`] for a surface with weights.
    pub fn new(surface: BsplineSurface) -> Result<Self, Error> {
        if surface.degree_v() != 1 {
            return Err(Error::NotRuled { degree: surface.degree_v() });
        }
        Ok(Self { surface: ActiveSurface::new(surface)?, abs_twist: 0.0 })
    }

    /// The same with a penalty on twisted rulings: the cost, a mean squared distance, gets `abs_twist²` times the mean squared
    /// length of the difference of the unit normals at the two ends of a ruling. 0 for no penalty.
    ///
    /// Begin with a small share of the distance that is allowed and go on from the result with a larger one: a strong penalty from a
    /// poor start leads to surfaces whose edge of regression lies between the sections, where normals turn over.
    ///
    /// # Errors
    /// [`Error::Option`] unless it is a length.
    pub fn with_abs_twist(self, abs_twist: f64) -> Result<Self, Error> {
        if !(abs_twist >= 0.0 && abs_twist.is_finite()) {
            return Err(Error::Option {
                name: "abs_twist",
                value: abs_twist,
                allowed: "a length of at least 0",
            });
        }
        Ok(Self { abs_twist, ..self })
    }

    /// The surface.
    #[must_use]
    pub fn surface(&self) -> &BsplineSurface {
        self.surface.surface()
    }

    /// The surface by value.
    #[must_use]
    pub fn into_surface(self) -> BsplineSurface {
        self.surface.into_surface()
    }

    /// The coefficients of a section, the control points `p_ij` with the given `j`.
    #[must_use]
    pub fn section(&self, j: usize) -> Vec<usize> {
        let mut out: Vec<usize> =
            (0..self.surface().n_u()).filter_map(|i| self.surface.coefficient_of(i, j)).collect();
        out.sort_unstable();
        out.dedup();
        out
    }

    /// The coefficients of the first and the last ruling; none where the surface is closed in u.
    #[must_use]
    pub fn end_rulings(&self) -> Vec<usize> {
        let surface = self.surface();
        if surface.knots_u().is_periodic() {
            return Vec::new();
        }
        let ends = [0, surface.n_u() - 1];
        let both = ends.into_iter().flat_map(|i| (0..surface.n_v()).map(move |j| (i, j)));
        let mut out: Vec<usize> = both.filter_map(|(i, j)| self.surface.coefficient_of(i, j)).collect();
        out.sort_unstable();
        out.dedup();
        out
    }
}

impl ActiveShape<3> for ActiveRuled {
    fn coefficients(&self) -> &[Vector3<f64>] {
        self.surface.coefficients()
    }

    fn set_coefficients(&mut self, coefficients: &[Vector3<f64>]) -> Result<(), Error> {
        self.surface.set_coefficients(coefficients)
    }

    fn cells(&self) -> &CellTable {
        self.surface.cells()
    }

    fn cell(&self, parameter: [f64; 2]) -> usize {
        self.surface.cell(parameter)
    }

    fn basis(&self, parameter: [f64; 2], cell: usize, values: &mut [f64]) {
        self.surface.basis(parameter, cell, values);
    }

    fn energy(&self, weights: [f64; 3]) -> Vec<CellGram> {
        self.surface.energy(weights)
    }

    fn tangent_planes(&self) -> Vec<(Vector3<f64>, f64)> {
        self.surface.tangent_planes()
    }

    /// The twists of the rulings at the nodes of Gauss's quadrature in each cell.
    fn penalties(&self) -> Vec<Penalty<3>> {
        if self.abs_twist == 0.0 {
            return Vec::new();
        }
        let knots = self.surface().knots_u();
        let (p, length) = (knots.degree(), knots.domain().length());
        let layers = self.surface().knots_v().spans().count();
        let nodes = gauss_legendre(p + 1);
        let mut rows = [[0.0; MAX_DEGREE + 1]; 2];
        let mut out = Vec::new();
        for (place, span) in knots.spans().enumerate() {
            let interval = knots.span_interval(span);
            for &(share, weight) in &nodes {
                basis::derivatives(knots, span, interval.lerp(share), 1, &mut rows);
                let part = weight * interval.length() / (length * layers as f64);
                let factor = self.abs_twist * part.sqrt();
                for cell in place * layers..(place + 1) * layers {
                    // In each cell the two control points of a ruling follow each other.
                    let columns = self.cells().columns(cell);
                    let mut ends = [[Vector3::zeros(); 2]; 2];
                    for (k, &column) in columns.iter().enumerate() {
                        for order in 0..2 {
                            ends[k % 2][order] += self.coefficients()[column] * rows[order][k / 2];
                        }
                    }
                    let ruling = ends[1][0] - ends[0][0];
                    let Some((values, [by_p, by_q, by_r])) = twist(&ends[0][1], &ends[1][1], &ruling) else {
                        continue;
                    };
                    let derivatives: Vec<Matrix3<f64>> = (0..columns.len())
                        .map(|k| (rows[0][k / 2] * factor, rows[1][k / 2] * factor, k.is_multiple_of(2)))
                        .map(
                            |(n, slope, first)| {
                                if first { by_p * slope - by_r * n } else { by_q * slope + by_r * n }
                            },
                        )
                        .collect();
                    for c in 0..3 {
                        let gradient = derivatives.iter().map(|d| d.row(c).transpose()).collect();
                        out.push(Penalty { cell, value: values[c] * factor, gradient });
                    }
                }
            }
        }
        out
    }

    fn frames(
        &self,
        points: &[Vector3<f64>],
        search: Search,
        previous: &[PrincipalFrame<3>],
    ) -> Result<Vec<PrincipalFrame<3>>, Error> {
        self.surface.frames(points, search, previous)
    }

    fn model(&self, x: &Vector3<f64>, frame: &PrincipalFrame<3>, term: ErrorTerm) -> Matrix3<f64> {
        self.surface.model(x, frame, term)
    }

    fn sensors(&self, per_cell: usize) -> Vec<[f64; 2]> {
        self.surface.sensors(per_cell)
    }
}
