//! The form in which every operation along one parameter works.

use crate::{BsplineCurve, BsplineSurface, Direction, Error, KnotVector};
use nalgebra::SVector;

/// A spline in one parameter whose coefficients are rows of plain numbers.
///
/// A curve has one point in each row; a surface seen along `u` has a whole row of its net, seen along
/// `v` a column. Points of rational shapes are homogeneous, `(w p, w)`, so that what is linear in the
/// coefficients is exact for them too.
#[derive(Clone, Debug)]
pub(crate) struct ControlRows {
    /// Knots along the parameter; there are `basis_count` rows.
    pub(crate) knots: KnotVector,
    /// The rows, one after the other.
    pub(crate) data: Vec<f64>,
    /// Numbers in a row.
    pub(crate) width: usize,
    /// Numbers in a point: the dimension, and one more when rational.
    pub(crate) point: usize,
    /// Whether the last number of each point is its weight.
    pub(crate) rational: bool,
}

impl ControlRows {
    /// Row `i`.
    pub(crate) fn row(&self, i: usize) -> &[f64] {
        &self.data[i * self.width..(i + 1) * self.width]
    }

    /// Number of rows.
    pub(crate) fn count(&self) -> usize {
        self.knots.basis_count()
    }

    /// Number of coordinates of a point, without the weight.
    pub(crate) fn dimension(&self) -> usize {
        if self.rational { self.point - 1 } else { self.point }
    }

    /// Other rows on other knots, points of the same kind.
    pub(crate) fn with(&self, knots: KnotVector, data: Vec<f64>) -> Self {
        debug_assert_eq!(data.len(), knots.basis_count() * self.width);
        Self { knots, data, ..*self }
    }

    pub(crate) fn from_curve<const D: usize>(curve: &BsplineCurve<D>) -> Self {
        let data = homogeneous(curve.control_points(), curve.factors());
        let rational = curve.factors().is_some();
        let point = D + usize::from(rational);
        Self { knots: curve.knots().clone(), data, width: point, point, rational }
    }

    pub(crate) fn into_curve<const D: usize>(self) -> Result<BsplineCurve<D>, Error> {
        let (points, weights) = euclidean(&self.data, self.rational);
        BsplineCurve::new(self.knots, points, weights)
    }

    /// The surface seen along `direction`.
    pub(crate) fn from_surface(surface: &BsplineSurface, direction: Direction) -> Self {
        let data = homogeneous(surface.control_points(), surface.factors());
        let rational = surface.factors().is_some();
        let point = 3 + usize::from(rational);
        let (n_u, n_v) = (surface.n_u(), surface.n_v());
        match direction {
            Direction::U => {
                Self { knots: surface.knots_u().clone(), data, width: n_v * point, point, rational }
            }
            Direction::V => {
                let data = transpose(&data, n_u, n_v, point);
                Self { knots: surface.knots_v().clone(), data, width: n_u * point, point, rational }
            }
        }
    }

    /// The surface whose knots in the other direction are `other`.
    pub(crate) fn into_surface(
        self,
        other: KnotVector,
        direction: Direction,
    ) -> Result<BsplineSurface, Error> {
        let count = self.width / self.point;
        match direction {
            Direction::U => {
                let (points, weights) = euclidean(&self.data, self.rational);
                BsplineSurface::new(self.knots, other, points, weights)
            }
            Direction::V => {
                let data = transpose(&self.data, self.knots.basis_count(), count, self.point);
                let (points, weights) = euclidean(&data, self.rational);
                BsplineSurface::new(other, self.knots, points, weights)
            }
        }
    }

    /// The points of rows `rows` as bounding box centre and half diagonal (coordinates, not homogeneous).
    pub(crate) fn bounds(&self, rows: impl Iterator<Item = usize>) -> (Vec<f64>, f64) {
        let d = self.dimension();
        let (mut low, mut high) = (vec![f64::INFINITY; d], vec![f64::NEG_INFINITY; d]);
        for i in rows {
            for point in self.row(i).chunks_exact(self.point) {
                let w = if self.rational { point[d] } else { 1.0 };
                for c in 0..d {
                    low[c] = low[c].min(point[c] / w);
                    high[c] = high[c].max(point[c] / w);
                }
            }
        }
        let centre = low.iter().zip(&high).map(|(a, b)| 0.5 * (a + b)).collect();
        let radius = 0.5 * low.iter().zip(&high).map(|(a, b)| (b - a) * (b - a)).sum::<f64>().sqrt();
        (centre, radius)
    }
}

/// Swaps the two indices of a net of `rows × columns` points.
pub(crate) fn transpose(data: &[f64], rows: usize, columns: usize, point: usize) -> Vec<f64> {
    let mut out = Vec::with_capacity(data.len());
    for j in 0..columns {
        for i in 0..rows {
            let start = (i * columns + j) * point;
            out.extend_from_slice(&data[start..start + point]);
        }
    }
    out
}

fn homogeneous<const D: usize>(points: &[SVector<f64, D>], weights: Option<&[f64]>) -> Vec<f64> {
    match weights {
        None => points.iter().flat_map(|p| p.iter().copied()).collect(),
        Some(weights) => {
            let mut data = Vec::with_capacity(points.len() * (D + 1));
            for (p, w) in points.iter().zip(weights) {
                data.extend(p.iter().map(|c| c * w));
                data.push(*w);
            }
            data
        }
    }
}

type Euclidean<const D: usize> = (Vec<SVector<f64, D>>, Option<Vec<f64>>);

fn euclidean<const D: usize>(data: &[f64], rational: bool) -> Euclidean<D> {
    if !rational {
        return (data.chunks_exact(D).map(SVector::from_column_slice).collect(), None);
    }
    let point = |h: &[f64]| SVector::from_column_slice(&h[..D]) / h[D];
    let points = data.chunks_exact(D + 1).map(point).collect();
    (points, Some(data.chunks_exact(D + 1).map(|h| h[D]).collect()))
}

/// Applies an operation along one direction of a surface.
pub(crate) fn along(
    surface: &BsplineSurface,
    direction: Direction,
    operation: impl FnOnce(ControlRows) -> Result<ControlRows, Error>,
) -> Result<BsplineSurface, Error> {
    let other = knots(surface, direction.other()).clone();
    operation(ControlRows::from_surface(surface, direction))?.into_surface(other, direction)
}

/// Knots of a surface in a direction.
pub(crate) fn knots(surface: &BsplineSurface, direction: Direction) -> &KnotVector {
    match direction {
        Direction::U => surface.knots_u(),
        Direction::V => surface.knots_v(),
    }
}

/// An error when a tolerance is negative or NaN; infinity is a legitimate "any".
pub(crate) fn check_tolerance(tolerance: f64) -> Result<(), Error> {
    if tolerance >= 0.0 {
        Ok(())
    } else {
        Err(Error::argument(format!("tolerance {tolerance} must be a number that is not negative")))
    }
}
