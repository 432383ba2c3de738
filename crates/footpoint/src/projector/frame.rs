//! The frame in which a model is searched: lengths about 1, whatever the unit of the file.
//!
//! A search takes squares and products of lengths. For models of ordinary size they stay within the range of doubles, and
//! the frame is that of the file, so that nothing is copied. Models that are very small, very large or very far from the
//! origin for their size are shifted and scaled by a power of two, and so is a query that is further away than any square
//! can tell: it is moved towards the model along the line to it, where the foot is the same up to rounding.

use crate::{CurveFootpoint, SurfaceFootpoint};
use nalgebra::{ArrayStorage, SVector};
use nurbs_core::Error;
use nurbs_core::magnitude::{exponent, scaled_by_power_of_two};
use nurbs_core::{BsplineCurve, BsplineSurface};
use std::borrow::Cow;

/// Binary exponents of sizes that need no scaling.
const ORDINARY: i32 = 64;
/// Binary exponent of the distance from the origin, in sizes of the model, that needs no shift.
const FAR_OFF: i32 = 100;
/// An axis along which the model is shorter than `2^-NARROW` of its coordinates is shifted: exactly, since they are alike.
const NARROW: i32 = 30;
/// Binary exponent to which coordinates of queries are limited.
const REACH: i32 = 250;
/// `2^REACH`.
const USUAL: f64 = f64::from_bits((1023 + 250) << 52);

/// Lengths of a frame are those of the file times a power of two, after a shift.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Frame<const D: usize> {
    exponent: i32,
    origin: SVector<f64, D>,
    /// Whether it is the frame of the file.
    is_file: bool,
}

/// A footpoint whose lengths can be changed.
pub(crate) trait Lengths<const D: usize> {
    /// Point, distance and lower bound.
    fn lengths(&mut self) -> (&mut SVector<f64, D>, &mut f64, &mut f64);
    /// Makes what else tells the distance follow it.
    fn follow_distance(&mut self) {}
}

impl<const D: usize> Lengths<D> for CurveFootpoint<D> {
    fn lengths(&mut self) -> (&mut SVector<f64, D>, &mut f64, &mut f64) {
        (&mut self.point, &mut self.distance, &mut self.lower_bound)
    }
}

impl Lengths<3> for SurfaceFootpoint {
    fn lengths(&mut self) -> (&mut SVector<f64, 3>, &mut f64, &mut f64) {
        (&mut self.point, &mut self.distance, &mut self.lower_bound)
    }

    fn follow_distance(&mut self) {
        self.signed_distance = self.distance.copysign(self.signed_distance);
    }
}

impl<const D: usize> Frame<D> {
    /// That of the file.
    pub(crate) const FILE: Self =
        Self { exponent: 0, origin: SVector::from_array_storage(ArrayStorage([[0.0; D]])), is_file: true };

    /// The frame for shapes with these control points.
    pub(crate) fn of<'a>(points: impl Iterator<Item = &'a SVector<f64, D>>) -> Self {
        let mut low = SVector::<f64, D>::repeat(f64::INFINITY);
        let mut high = -low;
        for point in points {
            low = low.inf(point);
            high = high.sup(point);
        }
        let largest = |v: SVector<f64, D>| v.iter().fold(0.0f64, |a, c| a.max(c.abs()));
        let (size, reach) = (largest(high - low), largest(low).max(largest(high)));
        let (size_exponent, reach_exponent) = (exponent(size), exponent(reach));
        let ordinary = size == 0.0 && reach_exponent.abs() <= REACH
            || size_exponent.abs() <= ORDINARY && reach_exponent - size_exponent <= FAR_OFF;
        if ordinary || !size.is_finite() {
            return Self::FILE;
        }
        let origin = SVector::from_fn(|d, _| {
            let narrow = high[d] - low[d] <= scaled_by_power_of_two(low[d].abs().max(high[d].abs()), -NARROW);
            if narrow { low[d] } else { 0.0 }
        });
        Self { exponent: if size > 0.0 { -size_exponent } else { 0 }, origin, is_file: false }
    }

    /// Whether a query is the same in this frame.
    #[inline(always)]
    pub(crate) fn keeps(&self, x: &SVector<f64, D>) -> bool {
        // False for what is not finite, too.
        self.is_file && x.iter().all(|c| c.abs() < USUAL)
    }

    /// The curve in this frame.
    pub(crate) fn curve<'a>(&self, curve: &'a BsplineCurve<D>) -> Result<Cow<'a, BsplineCurve<D>>, Error> {
        if self.is_file {
            return Ok(Cow::Borrowed(curve));
        }
        Ok(Cow::Owned(curve.translated(&-self.origin)?.scaled_by_power_of_two(self.exponent)?))
    }

    /// A query in this frame, and by which power of two it was moved towards the origin; 0 for the usual ones.
    fn enter(&self, x: &SVector<f64, D>) -> (SVector<f64, D>, i32) {
        let shifted = if self.is_file { *x } else { self.shifted(x) };
        let largest = shifted.iter().fold(0.0f64, |a, c| a.max(c.abs()));
        let beyond = if largest.is_finite() { (exponent(largest) + self.exponent - REACH).max(0) } else { 0 };
        let total = self.exponent - beyond;
        let y = if total == 0 { shifted } else { shifted.map(|c| scaled_by_power_of_two(c, total)) };
        (y, beyond)
    }

    /// `x − origin`, where that does not overflow.
    fn shifted(&self, x: &SVector<f64, D>) -> SVector<f64, D> {
        let y = x - self.origin;
        if y.iter().all(|c| c.is_finite()) { y } else { *x }
    }

    /// A query in this frame.
    pub(crate) fn query(&self, x: &SVector<f64, D>) -> SVector<f64, D> {
        if self.keeps(x) { *x } else { self.enter(x).0 }
    }

    /// Queries in this frame: the same ones where the frame is that of the file and none is far off.
    pub(crate) fn queries<'a>(&self, points: &'a [SVector<f64, D>]) -> Cow<'a, [SVector<f64, D>]> {
        if points.iter().all(|x| self.keeps(x)) {
            return Cow::Borrowed(points);
        }
        Cow::Owned(points.iter().map(|x| self.query(x)).collect())
    }

    /// Takes the foot of a query out of this frame.
    pub(crate) fn leave<F: Lengths<D>>(&self, x: &SVector<f64, D>, foot: &mut F) {
        if self.keeps(x) {
            return;
        }
        let (_, beyond) = self.enter(x);
        let back = |length: f64| scaled_by_power_of_two(length, beyond - self.exponent);
        let (point, distance, bound) = foot.lengths();
        if distance.is_nan() {
            return;
        }
        *point = point.map(|c| scaled_by_power_of_two(c, -self.exponent)) + self.origin;
        let share = *bound / *distance;
        // From afar the line to the foot is measured anew, in parts that cannot overflow.
        *distance =
            if beyond > 0 { length(&self.shifted(x), &(*point - self.origin)) } else { back(*distance) };
        // A distance beyond the largest double is not known.
        if !distance.is_finite() {
            *distance = f64::MAX;
        }
        *bound = if share.is_nan() { back(*bound) } else { *distance * share }.min(*distance);
        foot.follow_distance();
    }

    /// As [`leave`](Self::leave), for many.
    pub(crate) fn leave_all<F: Lengths<D>>(&self, points: &[SVector<f64, D>], feet: &mut [F]) {
        for (x, foot) in points.iter().zip(feet) {
            self.leave(x, foot);
        }
    }
}

impl Frame<3> {
    /// The surface in this frame.
    pub(crate) fn surface<'a>(&self, surface: &'a BsplineSurface) -> Result<Cow<'a, BsplineSurface>, Error> {
        if self.is_file {
            return Ok(Cow::Borrowed(surface));
        }
        Ok(Cow::Owned(surface.translated(&-self.origin)?.scaled_by_power_of_two(self.exponent)?))
    }
}

/// `|a − b|` without overflow of the squares.
fn length<const D: usize>(a: &SVector<f64, D>, b: &SVector<f64, D>) -> f64 {
    let half = a * 0.5 - b * 0.5;
    let largest = half.iter().fold(0.0f64, |m, c| m.max(c.abs()));
    if largest == 0.0 {
        return 0.0;
    }
    let e = exponent(largest);
    scaled_by_power_of_two(half.map(|c| scaled_by_power_of_two(c, -e)).norm(), e + 1)
}
