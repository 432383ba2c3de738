//! Straight segments.

use super::CurveFoot;
use super::frame::finite;
use crate::{BsplineCurve, CurveJet, Error, Interval, KnotVector, ParametricCurve};
use nalgebra::SVector;

/// The straight segment between two points, with the distance from the first one as parameter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Line<const D: usize> {
    start: SVector<f64, D>,
    end: SVector<f64, D>,
}

impl<const D: usize> Line<D> {
    /// The segment from `start` to `end`.
    ///
    /// # Errors
    /// [`Error::Argument`] when a coordinate is not finite or the points coincide.
    pub fn new(start: SVector<f64, D>, end: SVector<f64, D>) -> Result<Self, Error> {
        finite("start of the line", start.as_slice())?;
        finite("end of the line", end.as_slice())?;
        let length = (end - start).norm();
        if !(length > 0.0 && length.is_finite()) {
            return Err(Error::argument(format!(
                "the line from {start:?} to {end:?} has the length {length}"
            )));
        }
        Ok(Self { start, end })
    }

    /// First point.
    #[must_use]
    pub fn start(&self) -> SVector<f64, D> {
        self.start
    }

    /// Last point.
    #[must_use]
    pub fn end(&self) -> SVector<f64, D> {
        self.end
    }

    /// Length.
    #[must_use]
    pub fn length(&self) -> f64 {
        (self.end - self.start).norm()
    }

    /// Unit vector from start to end.
    #[must_use]
    pub fn direction(&self) -> SVector<f64, D> {
        (self.end - self.start) / self.length()
    }

    /// The closest point of the segment.
    #[must_use]
    pub fn footpoint(&self, x: &SVector<f64, D>) -> CurveFoot<D> {
        let length = self.length();
        let parameter = ((x - self.start).dot(&self.direction())).max(0.0).min(length);
        let point = self.point(parameter);
        CurveFoot { parameter, point, distance: (x - point).norm() }
    }

    /// The segment as a B-spline curve of degree 1 with the same parameter.
    ///
    /// # Errors
    /// None for a line that could be made.
    pub fn to_nurbs(&self) -> Result<BsplineCurve<D>, Error> {
        BsplineCurve::new(KnotVector::bezier(1, self.domain())?, vec![self.start, self.end], None)
    }
}

impl<const D: usize> ParametricCurve<D> for Line<D> {
    fn domain(&self) -> Interval {
        Interval::from_ordered(0.0, self.length())
    }

    fn jet(&self, t: f64) -> CurveJet<D> {
        CurveJet { point: self.point(t), d1: self.direction(), d2: SVector::zeros() }
    }

    fn point(&self, t: f64) -> SVector<f64, D> {
        let s = t / self.length();
        // From the nearer end, so that both ends are met exactly.
        if s < 0.5 {
            self.start + (self.end - self.start) * s
        } else {
            self.end - (self.end - self.start) * (1.0 - s)
        }
    }
}
