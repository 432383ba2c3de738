//! The moving points.

use crate::Error;
use crate::neighbourhood::plane_normals;
use crate::parallel;
use mesh_core::spatial_order;
use nalgebra::{Point, SVector};

/// Width of the points as a share of their length below which they count as collinear.
const COLLINEAR: f64 = 1e-9;
/// Largest coordinate of which sums of squares are finite.
const LARGEST: f64 = 1e150;

/// The first point with a coordinate that is too large for sums of squares.
pub(crate) fn too_large<const D: usize>(points: &[SVector<f64, D>]) -> Option<Error> {
    let value = |x: &SVector<f64, D>| x.iter().copied().find(|c| c.is_finite() && c.abs() > LARGEST);
    points.iter().enumerate().find_map(|(index, x)| Some(Error::TooLarge { index, value: value(x)? }))
}

/// The points that are to be moved onto a shape, with what is known about them.
#[derive(Clone, Copy, Debug)]
pub struct Source<'a, const D: usize> {
    /// Their coordinates, in any unit and frame.
    pub points: &'a [SVector<f64, D>],
    /// Normals, of any length; those that are 0 or not finite are ignored.
    pub normals: Option<&'a [SVector<f64, D>]>,
    /// Weights, not negative; 1 where there are none.
    pub weights: Option<&'a [f64]>,
}

impl<'a, const D: usize> Source<'a, D> {
    /// Points without normals, all of the same weight.
    #[must_use]
    pub fn new(points: &'a [SVector<f64, D>]) -> Self {
        Self { points, normals: None, weights: None }
    }

    /// The same points with normals.
    #[must_use]
    pub fn with_normals(self, normals: &'a [SVector<f64, D>]) -> Self {
        Self { normals: Some(normals), ..self }
    }

    /// The same points with weights.
    #[must_use]
    pub fn with_weights(self, weights: &'a [f64]) -> Self {
        Self { weights: Some(weights), ..self }
    }
}

/// What is done with points that have a coordinate which is NaN or infinite.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "snake_case"))]
pub enum NonFinite {
    /// They are left out and counted in the report.
    #[default]
    Drop,
    /// They are an error.
    Refuse,
}

/// The points that take part, ready for the loop: finite, relative to their centre, normals of unit length.
#[derive(Clone, Debug)]
pub(crate) struct Prepared<const D: usize> {
    /// Centre of the points, in the source's coordinates.
    pub(crate) centre: SVector<f64, D>,
    /// Diagonal of the box around the points.
    pub(crate) diagonal: f64,
    /// Points relative to the centre, in an order in which neighbours follow each other.
    pub(crate) points: Vec<SVector<f64, D>>,
    /// Unit normals, 0 where unknown; empty where there are none at all.
    pub(crate) normals: Vec<SVector<f64, D>>,
    /// Weights; empty where all are 1.
    pub(crate) weights: Vec<f64>,
    /// Number of points left out.
    pub(crate) dropped: usize,
}

impl<const D: usize> Prepared<D> {
    /// Checks the input and takes it apart.
    pub(crate) fn new(source: &Source<'_, D>, non_finite: NonFinite) -> Result<Self, Error> {
        let total = source.points.len();
        check_length("normals", source.normals.map(<[_]>::len), total)?;
        check_length("weights", source.weights.map(<[_]>::len), total)?;
        let bad_weight =
            source.weights.and_then(|w| w.iter().position(|&w| !w.is_finite() || w < 0.0).map(|i| (i, w[i])));
        if let Some((index, value)) = bad_weight {
            return Err(Error::Weight { index, value });
        }
        if let Some(error) = too_large(source.points) {
            return Err(error);
        }
        let finite = |i: &usize| source.points[*i].iter().all(|c| c.is_finite());
        let weighs = |i: &usize| source.weights.is_none_or(|w| w[*i] > 0.0);
        let keep: Vec<usize> = (0..total).filter(finite).collect();
        let dropped = total - keep.len();
        if dropped > 0 && non_finite == NonFinite::Refuse {
            let index = (0..total).find(|i| !finite(i)).unwrap_or(0);
            return Err(Error::NotFinite { index, count: dropped });
        }
        let mut keep: Vec<usize> = keep.into_iter().filter(weighs).collect();
        if keep.len() < D {
            return Err(Error::TooFewPoints { total, finite: keep.len(), needed: D });
        }
        let at: Vec<Point<f64, D>> = keep.iter().map(|&i| source.points[i].into()).collect();
        if let Some(order) = spatial_order(&at) {
            keep = order.into_iter().map(|k| keep[k as usize]).collect();
        }
        let (centre, diagonal) = centre_and_diagonal(&keep, source.points);
        let points: Vec<_> = keep.iter().map(|&i| source.points[i] - centre).collect();
        let unit = |n: SVector<f64, D>| n.try_normalize(0.0).filter(|n| n.iter().all(|c| c.is_finite()));
        let normals = source.normals.map_or_else(Vec::new, |normals| {
            keep.iter().map(|&i| unit(normals[i]).unwrap_or_else(SVector::zeros)).collect()
        });
        let weights = source.weights.map_or_else(Vec::new, |w| keep.iter().map(|&i| w[i]).collect());
        let out = Self { centre, diagonal, points, normals, weights, dropped };
        out.check_extent()?;
        Ok(out)
    }

    /// One point out of every `step` consecutive ones, not always the same of them: scans have rows and columns.
    pub(crate) fn thinned(&self, step: usize) -> Self {
        let step = step.max(1);
        let pick: Vec<usize> = (0..self.points.len().div_ceil(step))
            .map(|k| (k * step + scrambled(k) % step).min(self.points.len() - 1))
            .collect();
        self.picked(&pick)
    }

    /// At least `count` of the points, evenly picked; `None` where these are all, or nearly.
    pub(crate) fn coarse(&self, count: usize) -> Option<Self> {
        let step = self.points.len() / count.max(1);
        (step >= 2).then(|| self.thinned(step))
    }

    /// Some of the points, or all, in another order.
    pub(crate) fn picked(&self, pick: &[usize]) -> Self {
        fn at<T: Copy>(values: &[T], pick: &[usize]) -> Vec<T> {
            if values.is_empty() { Vec::new() } else { pick.iter().map(|&i| values[i]).collect() }
        }
        Self {
            points: at(&self.points, pick),
            normals: at(&self.normals, pick),
            weights: at(&self.weights, pick),
            ..*self
        }
    }

    /// The same with normals of planes through neighbours, where there are none; 0 where the neighbours are not flat.
    pub(crate) fn with_estimated_normals(&self) -> Self {
        if !self.normals.is_empty() {
            return self.clone();
        }
        Self { normals: plane_normals(&self.points), ..self.clone() }
    }

    pub(crate) fn weight(&self, i: usize) -> f64 {
        self.weights.get(i).copied().unwrap_or(1.0)
    }

    /// A rigid motion is determined only by points that are not on one line (in the plane: not all in one place).
    fn check_extent(&self) -> Result<(), Error> {
        // About the line from the centre through the farthest point: sums of squares that are small without rounding.
        let farther = |a: SVector<f64, D>, b: &SVector<f64, D>| if b.norm() > a.norm() { *b } else { a };
        let farthest = self.points.iter().fold(SVector::zeros(), farther);
        let axis = farthest.try_normalize(0.0).unwrap_or_else(SVector::zeros);
        let sums = parallel::ranges(self.points.len(), |range| {
            self.points[range].iter().fold((0.0, 0.0), |(length, width), y| {
                (length + y.norm_squared(), width + (y - axis * axis.dot(y)).norm_squared())
            })
        });
        let count = self.points.len() as f64;
        let length = sums.iter().map(|sum| sum.0).sum::<f64>() / count;
        let width = if D == 2 { length } else { sums.iter().map(|sum| sum.1).sum::<f64>() / count };
        if width.is_nan() || length <= 0.0 || width <= (COLLINEAR * COLLINEAR) * length {
            let width = if width.is_nan() { 0.0 } else { width.sqrt() };
            return Err(Error::Collinear { width, length: length.sqrt() });
        }
        Ok(())
    }
}

/// A number that has nothing to do with `k`, but is always the same (the finaliser of a 64 bit hash).
fn scrambled(k: usize) -> usize {
    let mut x = (k as u64).wrapping_add(0x9e37_79b9_7f4a_7c15);
    x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    usize::try_from((x ^ (x >> 31)) >> 33).unwrap_or(0)
}

fn check_length(what: &'static str, found: Option<usize>, points: usize) -> Result<(), Error> {
    match found {
        Some(found) if found != points => Err(Error::Length { what, found, points }),
        _ => Ok(()),
    }
}

/// The mean of the points, summed relative to the first one, and the diagonal of their box.
fn centre_and_diagonal<const D: usize>(keep: &[usize], points: &[SVector<f64, D>]) -> (SVector<f64, D>, f64) {
    let first = keep.first().map_or_else(SVector::zeros, |&i| points[i]);
    let parts = parallel::ranges(keep.len(), |range| {
        let start = (SVector::<f64, D>::zeros(), first, first);
        keep[range].iter().fold(start, |(sum, low, high), &i| {
            (sum + (points[i] - first), low.inf(&points[i]), high.sup(&points[i]))
        })
    });
    let (sum, low, high) =
        parts.iter().fold((SVector::<f64, D>::zeros(), first, first), |(sum, low, high), part| {
            (sum + part.0, low.inf(&part.1), high.sup(&part.2))
        });
    (first + sum / keep.len().max(1) as f64, (high - low).norm())
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector3;

    fn error(points: &[Vector3<f64>]) -> Error {
        Prepared::new(&Source::new(points), NonFinite::Drop).unwrap_err()
    }

    #[test]
    fn bad_points_are_refused_or_dropped() {
        assert_eq!(error(&[]), Error::TooFewPoints { total: 0, finite: 0, needed: 3 });
        let nan = Vector3::new(0.0, f64::NAN, 0.0);
        assert!(matches!(error(&[nan; 9]), Error::TooFewPoints { total: 9, finite: 0, .. }));
        assert!(matches!(error(&[Vector3::new(1.0, 2.0, 3.0); 9]), Error::Collinear { .. }));
        let large = error(&[Vector3::zeros(), Vector3::new(1.0, -1e300, 0.0), Vector3::x(), Vector3::y()]);
        assert_eq!(large, Error::TooLarge { index: 1, value: -1e300 });
        let line: Vec<_> = (0..50)
            .map(|i| Vector3::new(1e6, -3.0, 2.0) + Vector3::new(0.3, 0.1, -0.2) * f64::from(i))
            .collect();
        assert!(matches!(error(&line), Error::Collinear { .. }));
        let mut plane = line.clone();
        plane.push(Vector3::new(1e6, 0.0, 0.0));
        plane.push(nan);
        let prepared = Prepared::new(&Source::new(&plane), NonFinite::Drop).unwrap();
        assert_eq!((prepared.points.len(), prepared.dropped), (51, 1));
        let refused = Prepared::new(&Source::new(&plane), NonFinite::Refuse).unwrap_err();
        assert_eq!(refused, Error::NotFinite { index: 51, count: 1 });
        let mean = prepared.points.iter().sum::<Vector3<f64>>();
        assert!(mean.norm() < 1e-7, "{mean}");
    }

    #[test]
    fn arrays_must_fit_and_weights_be_weights() {
        let points = [Vector3::zeros(), Vector3::x(), Vector3::y(), Vector3::z()];
        let source = Source::new(&points);
        let short = Prepared::new(&source.with_weights(&[1.0]), NonFinite::Drop).unwrap_err();
        assert_eq!(short, Error::Length { what: "weights", found: 1, points: 4 });
        let negative =
            Prepared::new(&source.with_weights(&[1.0, 1.0, -1.0, 1.0]), NonFinite::Drop).unwrap_err();
        assert_eq!(negative, Error::Weight { index: 2, value: -1.0 });
        let zero = Prepared::new(&source.with_weights(&[1.0, 1.0, 0.0, 1.0]), NonFinite::Drop).unwrap();
        assert_eq!(zero.points.len(), 3);
        let odd = [Vector3::x() * 9.0, Vector3::zeros(), Vector3::repeat(f64::NAN), Vector3::z()];
        let normals = Prepared::new(&source.with_normals(&odd), NonFinite::Drop).unwrap().normals;
        assert_eq!(normals, [Vector3::x(), Vector3::zeros(), Vector3::zeros(), Vector3::z()]);
    }
}
