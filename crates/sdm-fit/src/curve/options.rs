//! Options of a curve fit.

use crate::{Error, FitOptions};
use nalgebra::SVector;
use nurbs_core::MAX_DEGREE;

/// Where an open curve ends, and how it goes on there.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct CurveEnd {
    /// The end; the third coordinate does not count in the plane.
    pub point: [f64; 3],
    /// The direction of the tangent there, into the curve; without one only the place is given.
    pub direction: Option<[f64; 3]>,
}

impl CurveEnd {
    /// The place from a centre.
    pub(super) fn place<const D: usize>(&self, centre: &SVector<f64, D>) -> SVector<f64, D> {
        SVector::from_fn(|i, _| self.point[i]) - centre
    }
}

/// What a curve fit does. The defaults need nothing but points.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct CurveOptions {
    /// Degree; default 3. That of a given start is kept.
    pub degree: usize,
    /// Whether the curve is closed; by default the points decide.
    pub closed: Option<bool>,
    /// Number of control points (those that repeat in a closed curve counted once); by default as many as the tolerance
    /// asks for, or as the noise supports.
    pub controls: Option<usize>,
    /// Distance that no point shall exceed; knots are inserted where it is exceeded and removed where they carry nothing.
    /// Default none.
    pub abs_tolerance: Option<f64>,
    /// Most control points; default 200.
    pub max_controls: usize,
    /// Whether weights are unknowns, too, so that conics are exact; default not.
    pub rational: bool,
    /// Whether the outline is searched in the whole plane first, by a contour that grows inside the points until it meets them: for
    /// starts that are far away, and for outlines that wind. Only for closed curves in the plane; default not.
    pub search: bool,
    /// Length without points that belongs to the curve nevertheless; by default as much as the other distances of neighbours lead to
    /// expect. Where points are further apart there are several curves, or a part of the curve has no data.
    pub max_gap: Option<f64>,
    /// Where an open curve ends, in any order; then it is open. Default: where the points do.
    pub ends: [Option<CurveEnd>; 2],
    /// Options of the loop.
    pub fit: FitOptions,
}

impl Default for CurveOptions {
    fn default() -> Self {
        Self {
            degree: 3,
            closed: None,
            controls: None,
            abs_tolerance: None,
            max_controls: 200,
            rational: false,
            search: false,
            max_gap: None,
            ends: [None; 2],
            fit: FitOptions::default(),
        }
    }
}

impl CurveOptions {
    /// The same options with another degree.
    #[must_use]
    pub fn with_degree(self, degree: usize) -> Self {
        Self { degree, ..self }
    }

    /// The same options for a closed curve, an open one, or one that the points decide.
    #[must_use]
    pub fn with_closed(self, closed: Option<bool>) -> Self {
        Self { closed, ..self }
    }

    /// The same options with a number of control points.
    #[must_use]
    pub fn with_controls(self, controls: Option<usize>) -> Self {
        Self { controls, ..self }
    }

    /// The same options with a distance that no point shall exceed.
    #[must_use]
    pub fn with_abs_tolerance(self, abs_tolerance: Option<f64>) -> Self {
        Self { abs_tolerance, ..self }
    }

    /// The same options with another limit on the number of control points.
    #[must_use]
    pub fn with_max_controls(self, max_controls: usize) -> Self {
        Self { max_controls, ..self }
    }

    /// The same options with or without unknown weights.
    #[must_use]
    pub fn with_rational(self, rational: bool) -> Self {
        Self { rational, ..self }
    }

    /// The same options with or without a search of the whole plane.
    #[must_use]
    pub fn with_search(self, search: bool) -> Self {
        Self { search, ..self }
    }

    /// The same options with another length that may be without points.
    #[must_use]
    pub fn with_max_gap(self, max_gap: Option<f64>) -> Self {
        Self { max_gap, ..self }
    }

    /// The same options with ends that are given, of an open curve.
    #[must_use]
    pub fn with_ends(self, ends: [Option<CurveEnd>; 2]) -> Self {
        let closed = if ends.iter().any(Option::is_some) { Some(false) } else { self.closed };
        Self { ends, closed, ..self }
    }

    /// The same options with other options of the loop.
    #[must_use]
    pub fn with_fit(self, fit: FitOptions) -> Self {
        Self { fit, ..self }
    }

    /// Fewest control points of a curve of the degree.
    pub(crate) fn fewest(&self) -> usize {
        self.degree + 1
    }

    pub(crate) fn check(&self) -> Result<(), Error> {
        self.fit.check()?;
        let error = |name, value: f64, allowed| Err(Error::Option { name, value, allowed });
        if self.degree == 0 || self.degree > MAX_DEGREE {
            return error("degree", self.degree as f64, "between 1 and 25");
        }
        if let Some(value) = self.abs_tolerance.filter(|t| !(*t > 0.0 && t.is_finite())) {
            return error("tolerance", value, "a positive length");
        }
        if let Some(value) = self.max_gap.filter(|t| !(*t > 0.0 && t.is_finite())) {
            return error("max_gap", value, "a positive length");
        }
        let ends = self.ends.iter().flatten().count();
        if ends > 0 && (self.closed == Some(true) || self.rational || self.search) {
            return error("ends", ends as f64, "none (0) for closed and rational curves, and for a search");
        }
        let all = self
            .ends
            .iter()
            .flatten()
            .flat_map(|e| e.point.into_iter().chain(e.direction.into_iter().flatten()));
        if let Some(value) = all.into_iter().find(|c| !c.is_finite()) {
            return error("ends", value, "finite places and directions");
        }
        if self.max_controls < self.fewest() {
            return error("max_controls", self.max_controls as f64, "more than the degree");
        }
        if let Some(controls) = self.controls.filter(|&c| c < self.fewest()) {
            return error("controls", controls as f64, "more than the degree");
        }
        Ok(())
    }
}
