//! Tensor product B-spline surfaces as active shapes.

use super::edge::edge_model;
use super::folds::Folds;
use crate::Error;
use crate::shape::{ActiveShape, CellGram, CellTable};
use distance_field::{DistanceField, ErrorTerm, Hint, PrincipalFrame, Search, SurfaceField};
use nalgebra::{Matrix3, Vector3};
use nurbs_core::{
    BsplineSurface, KnotVector, MAX_DEGREE, ParametricSurface, SurfaceJet, basis, gauss_legendre,
};

/// Share of the size of the net within which the control points of an edge count as one point.
const ONE_POINT: f64 = 1e-12;

/// Share of its first area below which a cell is kept from becoming narrower, and the least one that is told apart.
const NARROW: f64 = 0.3;
const COLLAPSED: f64 = 0.01;
/// Where a cell folds, it and its neighbours count this much more in the fairing after each step, up to the most; of what they count
/// more this share is left after a step without folds.
const STIFFER: f64 = 10.0;
const STIFFEST: f64 = 1e6;
const KEPT: f64 = 0.8;
/// Places per direction at which the area of a cell is measured.
const PLACES: usize = 4;

/// A polynomial B-spline surface whose control points are unknown, open or closed (periodic knots) in each direction
/// (\[P05, sec. 4.2\]).
///
/// Closed directions need no side conditions: rows that repeat are the same unknowns. An edge that is one point to begin
/// with, the pole of a sphere, stays one point.
#[derive(Clone, Debug)]
pub struct ActiveSurface {
    surface: BsplineSurface,
    coefficients: Vec<Vector3<f64>>,
    /// The coefficient of each control point.
    unknowns: Vec<usize>,
    cells: CellTable,
    spans: [Vec<usize>; 2],
    /// Index of each knot span among those that are not empty.
    place_of_span: [Vec<usize>; 2],
    /// Least area (by the unit of the parameters) in each cell at the start.
    references: Vec<f64>,
    /// How much more each cell counts in the fairing, besides what its narrowness does.
    stiffness: Vec<f64>,
}

impl ActiveSurface {
    /// A surface to start from.
    ///
    /// # Errors
    /// [`Error::Rational`] for a surface with weights, which is not linear in its unknowns.
    pub fn new(surface: BsplineSurface) -> Result<Self, Error> {
        if surface.weights().is_some() {
            return Err(Error::Rational);
        }
        let (unknowns, count) = unknowns_of(&surface);
        let mut coefficients = vec![Vector3::zeros(); count];
        for (point, &unknown) in surface.control_points().iter().zip(&unknowns) {
            coefficients[unknown] = *point;
        }
        let spans = [surface.knots_u(), surface.knots_v()].map(|k| k.spans().collect::<Vec<_>>());
        let place_of_span = [0, 1].map(|d| {
            let knots = [surface.knots_u(), surface.knots_v()][d];
            let mut places = vec![0; knots.basis_count()];
            spans[d].iter().enumerate().for_each(|(place, &span)| places[span] = place);
            places
        });
        let (p, q, n_v) = (surface.degree_u(), surface.degree_v(), surface.n_v());
        let mut table = Vec::with_capacity(spans[0].len() * spans[1].len());
        for &u in &spans[0] {
            for &v in &spans[1] {
                let rows = u - p..=u;
                let cell: Vec<usize> =
                    rows.flat_map(|i| (v - q..=v).map(move |j| i * n_v + j)).map(|k| unknowns[k]).collect();
                table.push(cell);
            }
        }
        let cells = CellTable::new(table);
        let areas = areas(&surface, &spans);
        let mean = areas.iter().map(|cell| cell.mean).sum::<f64>() / areas.len().max(1) as f64;
        let reference = |(cell, area): (usize, &CellArea)| {
            let usual = area.mean.max(0.1 * mean);
            // Cells at a pole have no area there to begin with.
            let mut columns = cells.columns(cell).to_vec();
            columns.sort_unstable();
            let at_pole = columns.windows(2).any(|pair| pair[0] == pair[1]);
            // Not `clamp`, which panics where an area is not a number.
            area.least.max(if at_pole { 1e-3 * usual } else { NARROW * usual }).min(usual)
        };
        let references = areas.iter().enumerate().map(reference).collect();
        let stiffness = vec![1.0; areas.len()];
        Ok(Self { surface, coefficients, unknowns, cells, spans, place_of_span, references, stiffness })
    }

    /// The surface.
    #[must_use]
    pub fn surface(&self) -> &BsplineSurface {
        &self.surface
    }

    /// The surface by value.
    #[must_use]
    pub fn into_surface(self) -> BsplineSurface {
        self.surface
    }

    /// The coefficient that is the control point `p_ij`.
    #[must_use]
    pub fn coefficient_of(&self, i: usize, j: usize) -> Option<usize> {
        (j < self.surface.n_v()).then(|| self.unknowns.get(i * self.surface.n_v() + j).copied()).flatten()
    }

    /// The coefficients of the control points in so many rows at each open side, in the order of
    /// [`Side::ALL`](nurbs_core::construct::Side::ALL).
    #[must_use]
    pub fn rows_at_sides(&self, rows: [usize; 4]) -> Vec<usize> {
        let (n_u, n_v) = (self.surface.n_u(), self.surface.n_v());
        let at_end = |knots: &KnotVector, i: usize, n: usize, rows: [usize; 2]| {
            !knots.is_periodic() && (i < rows[0] || i + rows[1] >= n)
        };
        let [u_start, u_end, v_start, v_end] = rows;
        let on = |i, j| {
            at_end(self.surface.knots_u(), i, n_u, [u_start, u_end])
                || at_end(self.surface.knots_v(), j, n_v, [v_start, v_end])
        };
        let mut out: Vec<usize> = (0..n_u)
            .flat_map(|i| (0..n_v).map(move |j| (i, j)))
            .filter(|&(i, j)| on(i, j))
            .map(|(i, j)| self.unknowns[i * n_v + j])
            .collect();
        out.sort_unstable();
        out.dedup();
        out
    }

    /// The coefficients of the control points on the edges of open directions.
    #[must_use]
    pub fn boundary(&self) -> Vec<usize> {
        self.rows_at_sides([1; 4])
    }

    /// Makes the given cells (spans in u and v) and their neighbours count more in the fairing.
    pub(super) fn stiffen(&mut self, cells: &[[usize; 2]]) {
        let counts = [self.spans[0].len(), self.spans[1].len()];
        let closed = self.knots().map(KnotVector::is_periodic);
        let mut touched = vec![false; self.stiffness.len()];
        for cell in cells {
            for k in 0..9 {
                let place = [0, 1].map(|d| {
                    let moved = cell[d] + counts[d] + [k / 3, k % 3][d] - 1;
                    let inside = closed[d] || (counts[d]..2 * counts[d]).contains(&moved);
                    inside.then_some(moved % counts[d])
                });
                if let [Some(u), Some(v)] = place {
                    touched[u * counts[1] + v] = true;
                }
            }
        }
        for (stiffness, _) in self.stiffness.iter_mut().zip(touched).filter(|(_, t)| *t) {
            *stiffness = (*stiffness * STIFFER).min(STIFFEST);
        }
    }

    fn knots(&self) -> [&KnotVector; 2] {
        [self.surface.knots_u(), self.surface.knots_v()]
    }

    /// For each span that is not empty: `∫ N_i⁽ᵏ⁾ N_j⁽ᵏ⁾` for the orders 0 to 3, the domain scaled so that a span is 1 long
    /// on average, divided by its length.
    fn line_grams(&self, direction: usize) -> Vec<[Vec<f64>; 4]> {
        let knots = self.knots()[direction];
        let (p, domain) = (knots.degree(), knots.domain().length());
        let unit = domain / self.spans[direction].len() as f64;
        let nodes = gauss_legendre(p + 1);
        let mut rows = [[0.0; MAX_DEGREE + 1]; 4];
        let of_span = |&span: &usize| {
            let interval = knots.span_interval(span);
            let mut grams: [Vec<f64>; 4] = std::array::from_fn(|_| vec![0.0; (p + 1) * (p + 1)]);
            for &(s, weight) in &nodes {
                basis::derivatives(knots, span, interval.lerp(s), 3, &mut rows);
                let mut factor = weight * interval.length() / domain;
                for (gram, row) in grams.iter_mut().zip(&rows) {
                    for (i, line) in gram.chunks_exact_mut(p + 1).enumerate() {
                        for (slot, value) in line.iter_mut().zip(row) {
                            *slot += factor * row[i] * value;
                        }
                    }
                    factor *= unit * unit;
                }
            }
            grams
        };
        self.spans[direction].iter().map(of_span).collect()
    }
}

/// Normal and area of a cell.
struct CellArea {
    normal: Vector3<f64>,
    /// Mean of `|s_u × s_v|`.
    mean: f64,
    /// Least `⟨s_u × s_v, n⟩`; negative where the cell is folded.
    least: f64,
}

fn areas(surface: &BsplineSurface, spans: &[Vec<usize>; 2]) -> Vec<CellArea> {
    let columns = spans[1].len();
    crate::parallel::map(spans[0].len() * columns, |cell| {
        let u = surface.knots_u().span_interval(spans[0][cell / columns]);
        let v = surface.knots_v().span_interval(spans[1][cell % columns]);
        // From edge to edge, but clear of poles.
        let share = |k: usize| 0.001 + 0.998 * k as f64 / (PLACES - 1) as f64;
        let mut vectors = [Vector3::zeros(); PLACES * PLACES];
        for (k, vector) in vectors.iter_mut().enumerate() {
            let jet = surface.jet(u.lerp(share(k / PLACES)), v.lerp(share(k % PLACES)));
            *vector = jet.du.cross(&jet.dv);
        }
        let sum: Vector3<f64> = vectors.iter().sum();
        let normal = sum.try_normalize(0.0).unwrap_or_else(Vector3::zeros);
        let mean = vectors.iter().map(|a| a.norm()).sum::<f64>() / vectors.len() as f64;
        let least = vectors.iter().map(|a| a.dot(&normal)).fold(f64::INFINITY, f64::min);
        CellArea { normal, mean, least }
    })
}

/// The coefficient of each control point, and their number: rows that repeat in closed directions share theirs, and so do
/// the points of an edge that is one point.
pub(super) fn unknowns_of(surface: &BsplineSurface) -> (Vec<usize>, usize) {
    let (n_u, n_v) = (surface.n_u(), surface.n_v());
    let (d_u, d_v) = (surface.knots_u().distinct_count(), surface.knots_v().distinct_count());
    let net = surface.control_points();
    let size = net.iter().map(|p| (p - net[0]).amax()).fold(0.0, f64::max);
    let one_point =
        |edge: Vec<usize>| edge.iter().all(|&k| (net[k] - net[edge[0]]).amax() <= ONE_POINT * size);
    let (open_u, open_v) = (!surface.knots_u().is_periodic(), !surface.knots_v().is_periodic());
    let pole_u = [0, n_u - 1].map(|i| open_u && one_point((0..n_v).map(|j| i * n_v + j).collect()));
    let pole_v = [0, n_v - 1].map(|j| open_v && one_point((0..n_u).map(|i| i * n_v + j).collect()));
    // The control point that stands for another one.
    let representative = |i: usize, j: usize| {
        let (mut i, mut j) = (i % d_u, j % d_v);
        if (i == 0 && pole_u[0]) || (i + 1 == n_u && pole_u[1]) {
            j = 0;
        }
        if (j == 0 && pole_v[0]) || (j + 1 == n_v && pole_v[1]) {
            i = 0;
        }
        i * n_v + j
    };
    let mut numbers = vec![usize::MAX; n_u * n_v];
    let mut count = 0;
    let mut unknowns = Vec::with_capacity(n_u * n_v);
    for i in 0..n_u {
        for j in 0..n_v {
            let slot = &mut numbers[representative(i, j)];
            if *slot == usize::MAX {
                *slot = count;
                count += 1;
            }
            unknowns.push(*slot);
        }
    }
    (unknowns, count)
}

impl ActiveShape<3> for ActiveSurface {
    fn coefficients(&self) -> &[Vector3<f64>] {
        &self.coefficients
    }

    fn set_coefficients(&mut self, coefficients: &[Vector3<f64>]) -> Result<(), Error> {
        if coefficients.len() != self.coefficients.len() {
            let found = coefficients.len();
            return Err(Error::Length { what: "coefficients", found, points: self.coefficients.len() });
        }
        let net = self.unknowns.iter().map(|&k| coefficients[k]).collect();
        let (u, v) = (self.surface.knots_u().clone(), self.surface.knots_v().clone());
        self.surface = BsplineSurface::new(u, v, net, None)?;
        self.coefficients.copy_from_slice(coefficients);
        Ok(())
    }

    fn cells(&self) -> &CellTable {
        &self.cells
    }

    fn cell(&self, parameter: [f64; 2]) -> usize {
        let [u, v] = [0, 1].map(|d| {
            let knots = self.knots()[d];
            self.place_of_span[d][knots.span(knots.normalize(parameter[d]))]
        });
        u * self.spans[1].len() + v
    }

    fn basis(&self, parameter: [f64; 2], cell: usize, values: &mut [f64]) {
        let columns = self.spans[1].len();
        let mut rows = [[0.0; MAX_DEGREE + 1]; 2];
        for (d, place) in [cell / columns, cell % columns].into_iter().enumerate() {
            let knots = self.knots()[d];
            basis::values(knots, self.spans[d][place], knots.normalize(parameter[d]), &mut rows[d]);
        }
        let width = self.surface.degree_v() + 1;
        for (line, a) in values.chunks_exact_mut(width).zip(&rows[0]) {
            for (slot, b) in line.iter_mut().zip(&rows[1]) {
                *slot = a * b;
            }
        }
    }

    fn energy(&self, weights: [f64; 3]) -> Vec<CellGram> {
        let lines = [self.line_grams(0), self.line_grams(1)];
        let (a, b) = (self.surface.degree_u() + 1, self.surface.degree_v() + 1);
        // Order in u, order in v, how often that derivative occurs.
        let terms = [
            (1, 0, 1.0, 0),
            (0, 1, 1.0, 0),
            (2, 0, 1.0, 1),
            (1, 1, 2.0, 1),
            (0, 2, 1.0, 1),
            (3, 0, 1.0, 2),
            (2, 1, 3.0, 2),
            (1, 2, 3.0, 2),
            (0, 3, 1.0, 2),
        ];
        let mut out = Vec::with_capacity(self.cells.len());
        for u in &lines[0] {
            for v in &lines[1] {
                let mut gram = vec![0.0; a * b * a * b];
                for (k, l, times, order) in terms {
                    let factor = times * weights[order];
                    if factor == 0.0 {
                        continue;
                    }
                    for (row, line) in gram.chunks_exact_mut(a * b).enumerate() {
                        let (i, j) = (row / b, row % b);
                        for (column, slot) in line.iter_mut().enumerate() {
                            *slot += factor * u[k][i * a + column / b] * v[l][j * b + column % b];
                        }
                    }
                }
                out.push(CellGram { cell: out.len(), gram });
            }
        }
        out
    }

    fn tangent_planes(&self) -> Vec<(Vector3<f64>, f64)> {
        let now = areas(&self.surface, &self.spans);
        let factor = |(cell, area): (usize, &CellArea)| {
            let share = (area.least / self.references[cell]).max(COLLAPSED);
            let narrow = if share < NARROW { (NARROW / share).powi(2) } else { 1.0 };
            (area.normal, narrow * self.stiffness[cell])
        };
        now.iter().enumerate().map(factor).collect()
    }

    /// Cells that fold are stiffened while the folds are small.
    fn step_taken(&mut self) {
        self.stiffness.iter_mut().for_each(|stiffness| *stiffness = (*stiffness * KEPT).max(1.0));
        self.stiffen(&Folds::on_grid(&self.surface).folded);
    }

    fn frames(
        &self,
        points: &[Vector3<f64>],
        search: Search,
        previous: &[PrincipalFrame<3>],
    ) -> Result<Vec<PrincipalFrame<3>>, Error> {
        let hints: Vec<Hint> = if search == Search::Global {
            Vec::new()
        } else {
            previous.iter().map(|frame| frame.hint).collect()
        };
        Ok(SurfaceField::new(&self.surface)?.frames(points, search, &hints))
    }

    /// On the edge of an open surface the model is a blend, see [`ActiveCurve`](crate::ActiveCurve): the point model for a
    /// residual that points out of the surface, that of the surface for one along its normal.
    fn model(&self, x: &Vector3<f64>, frame: &PrincipalFrame<3>, term: ErrorTerm) -> Matrix3<f64> {
        if !frame.on_boundary || term == ErrorTerm::Point {
            return term.model(frame).matrix();
        }
        let [u, v] = frame.hint.parameter;
        let jet: SurfaceJet = self.surface.jet(u, v);
        edge_model(&jet, &(x - frame.foot), term).unwrap_or_else(Matrix3::identity)
    }

    fn sensors(&self, per_cell: usize) -> Vec<[f64; 2]> {
        let share = |k: usize| (k as f64 + 0.5) / per_cell as f64;
        let line = |d: usize, place: usize| -> Vec<f64> {
            let interval = self.knots()[d].span_interval(self.spans[d][place]);
            (0..per_cell).map(|k| interval.lerp(share(k))).collect()
        };
        let columns: Vec<Vec<f64>> = (0..self.spans[1].len()).map(|place| line(1, place)).collect();
        let mut out = Vec::with_capacity(self.cells.len() * per_cell * per_cell);
        for place in 0..self.spans[0].len() {
            let row = line(0, place);
            for column in &columns {
                out.extend(row.iter().flat_map(|&u| column.iter().map(move |&v| [u, v])));
            }
        }
        out
    }
}
