//! B-spline curves as active shapes.

use crate::Error;
use crate::shape::{ActiveShape, CellGram, CellTable};
use distance_field::{CurveField, DistanceField, ErrorTerm, Hint, PrincipalFrame, Search};
use nalgebra::{SMatrix, SVector};
use nurbs_core::{BsplineCurve, CurveJet, KnotVector, MAX_DEGREE, ParametricCurve, basis, gauss_legendre};

/// A polynomial B-spline curve in `R^D`, clamped, floating or periodic, whose control points are unknown (\[P05, eq. (6)\]).
///
/// Closed curves have periodic knots, so that closure with all derivatives needs no side condition.
#[derive(Clone, Debug)]
pub struct ActiveCurve<const D: usize> {
    curve: BsplineCurve<D>,
    coefficients: Vec<SVector<f64, D>>,
    cells: CellTable,
    /// Cell of each knot span; `usize::MAX` for empty ones.
    cell_of_span: Vec<usize>,
    spans: Vec<usize>,
}

impl<const D: usize> ActiveCurve<D> {
    /// A curve to start from.
    ///
    /// # Errors
    /// [`Error::Rational`] for a curve with weights, which is not linear in its unknowns.
    pub fn new(curve: BsplineCurve<D>) -> Result<Self, Error> {
        if curve.weights().is_some() {
            return Err(Error::Rational);
        }
        let knots = curve.knots();
        let (p, count) = (knots.degree(), knots.distinct_count());
        let spans: Vec<usize> = knots.spans().collect();
        let cells = CellTable::new(
            spans.iter().map(|&span| (span - p..=span).map(|i| i % count).collect::<Vec<_>>()),
        );
        let mut cell_of_span = vec![usize::MAX; knots.basis_count()];
        for (cell, &span) in spans.iter().enumerate() {
            cell_of_span[span] = cell;
        }
        let coefficients = curve.control_points()[..count].to_vec();
        Ok(Self { curve, coefficients, cells, cell_of_span, spans })
    }

    /// The curve.
    #[must_use]
    pub fn curve(&self) -> &BsplineCurve<D> {
        &self.curve
    }

    /// The curve by value.
    #[must_use]
    pub fn into_curve(self) -> BsplineCurve<D> {
        self.curve
    }

    fn knots(&self) -> &KnotVector {
        self.curve.knots()
    }
}

impl<const D: usize> ActiveShape<D> for ActiveCurve<D> {
    fn coefficients(&self) -> &[SVector<f64, D>] {
        &self.coefficients
    }

    fn set_coefficients(&mut self, coefficients: &[SVector<f64, D>]) -> Result<(), Error> {
        let mut points = coefficients.to_vec();
        let repeated = (self.knots().basis_count() - self.knots().distinct_count()).min(points.len());
        points.extend_from_within(..repeated);
        self.curve = BsplineCurve::new(self.knots().clone(), points, None)?;
        self.coefficients.copy_from_slice(coefficients);
        Ok(())
    }

    fn cells(&self) -> &CellTable {
        &self.cells
    }

    fn cell(&self, parameter: [f64; 2]) -> usize {
        self.cell_of_span[self.knots().span(self.knots().normalize(parameter[0]))]
    }

    fn basis(&self, parameter: [f64; 2], cell: usize, values: &mut [f64]) {
        let mut row = [0.0; MAX_DEGREE + 1];
        basis::values(self.knots(), self.spans[cell], self.knots().normalize(parameter[0]), &mut row);
        values.copy_from_slice(&row[..values.len()]);
    }

    fn energy(&self, weights: [f64; 3]) -> Vec<CellGram> {
        let (knots, p) = (self.knots(), self.knots().degree());
        let unit = knots.domain().length() / self.spans.len() as f64;
        let nodes = gauss_legendre(p + 1);
        let mut rows = [[0.0; MAX_DEGREE + 1]; 4];
        let mut grams = Vec::with_capacity(self.spans.len());
        for (cell, &span) in self.spans.iter().enumerate() {
            let interval = knots.span_interval(span);
            let mut gram = vec![0.0; (p + 1) * (p + 1)];
            for &(s, weight) in &nodes {
                basis::derivatives(knots, span, interval.lerp(s), 3, &mut rows);
                let mut factor = weight * interval.length() / knots.domain().length();
                for (order, row) in rows[1..].iter().enumerate() {
                    factor *= unit * unit;
                    for (i, line) in gram.chunks_exact_mut(p + 1).enumerate() {
                        for (slot, value) in line.iter_mut().zip(row) {
                            *slot += weights[order] * factor * row[i] * value;
                        }
                    }
                }
            }
            grams.push(CellGram { cell, gram });
        }
        grams
    }

    fn frames(
        &self,
        points: &[SVector<f64, D>],
        search: Search,
        previous: &[PrincipalFrame<D>],
    ) -> Result<Vec<PrincipalFrame<D>>, Error> {
        let hints: Vec<Hint> = if search == Search::Global {
            Vec::new()
        } else {
            previous.iter().map(|frame| frame.hint).collect()
        };
        Ok(CurveField::new(&self.curve)?.frames(points, search, &hints))
    }

    /// At an end of an open curve the model is a blend: the point model for a residual along the curve, that of the curve for
    /// one across it, `w = cos θ + (1 − cos θ) w_term` with the angle `θ` between the residual and the tangent (\[WPL06,
    /// sec. 3\]).
    fn model(&self, x: &SVector<f64, D>, frame: &PrincipalFrame<D>, term: ErrorTerm) -> SMatrix<f64, D, D> {
        if !frame.on_boundary {
            return term.model(frame).matrix();
        }
        let jet = self.curve.jet(frame.hint.parameter[0]);
        let Some(tangent) = jet.unit_tangent() else { return SMatrix::identity() };
        let weight = end_weight(&jet, &tangent, &(x - frame.foot), term);
        SMatrix::identity() - tangent * tangent.transpose() * (1.0 - weight)
    }

    fn sensors(&self, per_cell: usize) -> Vec<[f64; 2]> {
        let share = |k: usize| (k as f64 + 0.5) / per_cell as f64;
        let of_span = |&span: &usize| {
            let interval = self.knots().span_interval(span);
            (0..per_cell).map(move |k| [interval.lerp(share(k)), 0.0])
        };
        self.spans.iter().flat_map(of_span).collect()
    }
}

/// The weight of the tangent direction at an end for a residual.
fn end_weight<const D: usize>(
    jet: &CurveJet<D>,
    tangent: &SVector<f64, D>,
    residual: &SVector<f64, D>,
    term: ErrorTerm,
) -> f64 {
    let length = residual.norm();
    if length == 0.0 {
        return term.tangent_weight(0.0, 0.0);
    }
    let cosine = (tangent.dot(residual).abs() / length).min(1.0);
    let across = residual - tangent * tangent.dot(residual);
    let (distance, normal) = (across.norm(), across.try_normalize(0.0));
    let curvature = match (normal, jet.curvature_vector()) {
        (Some(normal), Some(bend)) => bend.dot(&normal),
        _ => 0.0,
    };
    let weight = cosine + (1.0 - cosine) * term.tangent_weight(distance, curvature);
    if weight.is_finite() { weight } else { 1.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector2;

    fn periodic() -> ActiveCurve<2> {
        let knots = KnotVector::uniform_periodic(3, 7).unwrap();
        let ring = |i: usize| {
            let a = (i % 7) as f64 * std::f64::consts::TAU / 7.0;
            Vector2::new(2.0 * a.cos(), a.sin())
        };
        let net = (0..10).map(ring).collect();
        ActiveCurve::new(BsplineCurve::new(knots, net, None).unwrap()).unwrap()
    }

    #[test]
    fn basis_gives_the_points_of_the_curve() {
        let curve = periodic();
        for k in 0..50 {
            let t = f64::from(k) / 50.0;
            assert!((curve.point([t, 0.0]) - curve.curve().point(t)).norm() < 1e-14);
        }
    }

    #[test]
    fn energy_is_the_integral() {
        let curve = periodic();
        let value = |weights| -> f64 {
            let grams = curve.energy(weights);
            let form = |g: &CellGram| {
                let d: Vec<_> = curve.cells.columns(g.cell).iter().map(|&i| curve.coefficients[i]).collect();
                let k = d.len();
                (0..k * k).map(|e| g.gram[e] * d[e / k].dot(&d[e % k])).sum::<f64>()
            };
            grams.iter().map(form).sum()
        };
        let n = 7 * 3000;
        for order in 1..4 {
            // Midpoint rule; a span is 1/7 long.
            let unit = 7f64.powi(-2 * i32::try_from(order).unwrap());
            let at = |k: usize| {
                curve.curve().derivatives((k as f64 + 0.5) / n as f64, order)[order].norm_squared()
            };
            let exact = (0..n).map(at).sum::<f64>() / n as f64 * unit;
            let mut weights = [0.0; 3];
            weights[order - 1] = 1.0;
            assert!((value(weights) - exact).abs() < 1e-6 * exact, "{order}");
        }
    }
}
