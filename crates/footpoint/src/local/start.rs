//! Initial parameters of a local iteration.

use super::quadrilaterals::{nearest_quadrilateral, share_of};
use nalgebra::{SVector, Vector3};
use nurbs_core::{ParametricCurve, ParametricSurface};

/// Samples taken where a start has nothing better to go by.
const FALLBACK_SAMPLES: usize = 16;

/// Where a local iteration starts; `P` is `f64` for curves and `[f64; 2]` for surfaces.
///
/// A parameter converts into [`Start::At`]; outside the domain it is wrapped or clamped.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Start<P> {
    /// At this parameter: a previous answer, the foot of a neighbouring point, a guess. If it is NaN, as
    /// `NearestSample(16)`.
    At(P),
    /// At the nearest of `n + 1` equally spaced samples, ends included; `(n + 1)²` on a surface.
    NearestSample(usize),
    /// At the Greville parameter of the nearest control point (\[MH03\]). For shapes without control points as
    /// `NearestSample(16)`.
    ControlPolygon,
    /// On the nearest of the planar pieces spanned by `n + 1` (`(n + 1)²`) samples: chords of a curve,
    /// quadrilaterals of a surface (\[PT01\]).
    Quadrilaterals(usize),
}

impl From<f64> for Start<f64> {
    fn from(t: f64) -> Self {
        Self::At(t)
    }
}

impl From<[f64; 2]> for Start<[f64; 2]> {
    fn from(parameter: [f64; 2]) -> Self {
        Self::At(parameter)
    }
}

impl Start<f64> {
    /// The initial parameter for the point `x` (finite).
    pub(crate) fn on_curve<const D: usize, C: ParametricCurve<D> + ?Sized>(
        self,
        curve: &C,
        x: &SVector<f64, D>,
    ) -> f64 {
        match self {
            Self::At(t) if !t.is_nan() => t,
            Self::At(_) => nearest_sample(curve, x, FALLBACK_SAMPLES),
            Self::NearestSample(n) => nearest_sample(curve, x, n),
            Self::ControlPolygon => curve
                .nearest_control_parameter(x)
                .unwrap_or_else(|| nearest_sample(curve, x, FALLBACK_SAMPLES)),
            Self::Quadrilaterals(n) => nearest_chord(curve, x, n),
        }
    }
}

impl Start<[f64; 2]> {
    /// The initial parameters for the point `x` (finite).
    pub(crate) fn on_surface<S: ParametricSurface + ?Sized>(self, surface: &S, x: &Vector3<f64>) -> [f64; 2] {
        match self {
            Self::At(p) if !p.iter().any(|t| t.is_nan()) => p,
            Self::At(_) => nearest_surface_sample(surface, x, FALLBACK_SAMPLES),
            Self::NearestSample(n) => nearest_surface_sample(surface, x, n),
            Self::ControlPolygon => surface
                .nearest_control_parameter(x)
                .unwrap_or_else(|| nearest_surface_sample(surface, x, FALLBACK_SAMPLES)),
            Self::Quadrilaterals(n) => nearest_quadrilateral(surface, x, [n, n]),
        }
    }
}

/// The first of the parameters with the smallest distance; distances that are NaN lose.
fn nearest<P: Copy>(candidates: impl Iterator<Item = (P, f64)>, otherwise: P) -> P {
    let mut best = (otherwise, f64::INFINITY);
    for candidate in candidates {
        if candidate.1 < best.1 {
            best = candidate;
        }
    }
    best.0
}

fn nearest_sample<const D: usize, C: ParametricCurve<D> + ?Sized>(
    curve: &C,
    x: &SVector<f64, D>,
    n: usize,
) -> f64 {
    let (domain, n) = (curve.domain(), n.max(1));
    let samples = (0..=n).map(|i| domain.lerp(i as f64 / n as f64));
    nearest(samples.map(|t| (t, (curve.point(t) - x).norm_squared())), domain.start())
}

fn nearest_surface_sample<S: ParametricSurface + ?Sized>(
    surface: &S,
    x: &Vector3<f64>,
    n: usize,
) -> [f64; 2] {
    let ([du, dv], n) = (surface.domain(), n.max(1));
    let at = |domain: nurbs_core::Interval, i: usize| domain.lerp(i as f64 / n as f64);
    let samples = (0..=n).flat_map(|i| (0..=n).map(move |j| [at(du, i), at(dv, j)]));
    nearest(
        samples.map(|[u, v]| ([u, v], (surface.point(u, v) - x).norm_squared())),
        [du.start(), dv.start()],
    )
}

fn nearest_chord<const D: usize, C: ParametricCurve<D> + ?Sized>(
    curve: &C,
    x: &SVector<f64, D>,
    n: usize,
) -> f64 {
    let (domain, n) = (curve.domain(), n.max(1));
    let mut before = curve.point(domain.start());
    let chords = (0..n).map(|i| {
        let after = curve.point(domain.lerp((i + 1) as f64 / n as f64));
        let chord = after - before;
        let share = share_of(&(x - before), &chord);
        let distance = (before + chord * share - x).norm_squared();
        before = after;
        (domain.lerp((i as f64 + share) / n as f64), distance)
    });
    nearest(chords, domain.start())
}
