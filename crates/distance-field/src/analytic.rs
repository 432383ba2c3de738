//! The distance from analytic shapes in closed form.

use crate::borders::Borders;
use crate::curve_ends::CurveEnds;
use crate::{DistanceField, Error, Hint, PrincipalFrame, Search};
use footpoint::Status;
use nalgebra::{SVector, Vector3};
use nurbs_core::{
    Aabb, AnalyticSurface, Circle, CurveFoot, CurveJet, Interval, Line, ParametricCurve, ParametricSurface,
};

/// The distance from a plane, sphere, cylinder, cone or torus, or a piece of one, signed by its normal.
///
/// Feet come from closed forms, whatever the [`Search`]; hints are not used.
///
/// ```
/// use distance_field::{AnalyticField, DistanceField, Hint, Search};
/// use nalgebra::Vector3;
/// use nurbs_core::{Cylinder, Frame, Interval};
///
/// let cylinder = Cylinder::new(Frame::WORLD, 2.0, Interval::new(-1.0, 1.0)?)?;
/// let frame = AnalyticField::new(cylinder)?.frame(&Vector3::new(3.0, 0.0, 0.5), Search::Global, &Hint::NONE);
/// assert_eq!((frame.distance, frame.curvatures[0], frame.curvatures[1]), (1.0, 0.0, -0.5));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct AnalyticField {
    surface: AnalyticSurface,
    borders: Borders,
    bounds: Aabb<3>,
}

impl AnalyticField {
    /// The distance from an analytic surface.
    ///
    /// # Errors
    /// [`Error::Shape`] when coordinates overflow.
    pub fn new(surface: impl Into<AnalyticSurface>) -> Result<Self, Error> {
        let surface = surface.into();
        let bounds = surface.to_nurbs()?.bounding_box(1e-6);
        Ok(Self { borders: Borders::new(&surface, 0.5 * bounds.sides().amax()), surface, bounds })
    }

    /// The surface.
    #[must_use]
    pub fn surface(&self) -> &AnalyticSurface {
        &self.surface
    }
}

impl DistanceField<3> for AnalyticField {
    fn frame(&self, x: &Vector3<f64>, _search: Search, _hint: &Hint) -> PrincipalFrame<3> {
        if !x.iter().all(|c| c.is_finite()) {
            return PrincipalFrame::invalid(Status::InvalidPoint);
        }
        let parameter = self.surface.footpoint(x).parameters;
        let jet = self.surface.jet(parameter[0], parameter[1]);
        let residual = x - jet.point;
        if !residual.norm_squared().is_finite() {
            return PrincipalFrame::invalid(Status::Diverged);
        }
        let (geometry, on_boundary) = self.borders.geometry(&self.surface, parameter, &jet, &residual);
        PrincipalFrame {
            foot: jet.point,
            axes: geometry.axes,
            curvatures: geometry.curvatures,
            tangent_dimension: geometry.tangent_dimension,
            distance: geometry.distance,
            on_boundary,
            hint: Hint::new(0, parameter),
            status: if on_boundary { Status::OnBoundary } else { Status::Converged },
        }
    }

    fn bounding_box(&self) -> Aabb<3> {
        self.bounds
    }
}

/// A curve whose feet have a closed form.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum AnalyticCurve<const D: usize> {
    /// A straight segment.
    Line(Line<D>),
    /// A circle or an arc.
    Circle(Circle<D>),
}

impl<const D: usize> From<Line<D>> for AnalyticCurve<D> {
    fn from(line: Line<D>) -> Self {
        Self::Line(line)
    }
}

impl<const D: usize> From<Circle<D>> for AnalyticCurve<D> {
    fn from(circle: Circle<D>) -> Self {
        Self::Circle(circle)
    }
}

impl<const D: usize> AnalyticCurve<D> {
    /// The closest point of the curve.
    #[must_use]
    pub fn footpoint(&self, x: &SVector<f64, D>) -> CurveFoot<D> {
        match self {
            Self::Line(line) => line.footpoint(x),
            Self::Circle(circle) => circle.footpoint(x),
        }
    }
}

impl<const D: usize> ParametricCurve<D> for AnalyticCurve<D> {
    fn domain(&self) -> Interval {
        match self {
            Self::Line(line) => line.domain(),
            Self::Circle(circle) => circle.domain(),
        }
    }

    fn period(&self) -> Option<f64> {
        match self {
            Self::Line(line) => line.period(),
            Self::Circle(circle) => circle.period(),
        }
    }

    fn jet(&self, t: f64) -> CurveJet<D> {
        match self {
            Self::Line(line) => line.jet(t),
            Self::Circle(circle) => circle.jet(t),
        }
    }
}

/// The distance from a straight segment, a circle or an arc in `R^D`, signed in the plane.
///
/// Feet come from closed forms, whatever the [`Search`]; hints are not used.
#[derive(Clone, Debug)]
pub struct AnalyticCurveField<const D: usize> {
    curve: AnalyticCurve<D>,
    ends: CurveEnds,
    bounds: Aabb<D>,
}

impl<const D: usize> AnalyticCurveField<D> {
    /// The distance from an analytic curve.
    ///
    /// # Errors
    /// [`Error::Shape`] when coordinates overflow.
    pub fn new(curve: impl Into<AnalyticCurve<D>>) -> Result<Self, Error> {
        let curve = curve.into();
        let spline = match &curve {
            AnalyticCurve::Line(line) => line.to_nurbs()?,
            AnalyticCurve::Circle(circle) => circle.to_nurbs()?,
        };
        let bounds = spline.bounding_box(1e-6);
        Ok(Self { ends: CurveEnds::new(&curve, 0.5 * bounds.sides().amax()), curve, bounds })
    }

    /// The curve.
    #[must_use]
    pub fn curve(&self) -> &AnalyticCurve<D> {
        &self.curve
    }
}

impl<const D: usize> DistanceField<D> for AnalyticCurveField<D> {
    fn frame(&self, x: &SVector<f64, D>, _search: Search, _hint: &Hint) -> PrincipalFrame<D> {
        if !x.iter().all(|c| c.is_finite()) {
            return PrincipalFrame::invalid(Status::InvalidPoint);
        }
        let parameter = self.curve.footpoint(x).parameter;
        let jet = self.curve.jet(parameter);
        let residual = x - jet.point;
        if !residual.norm_squared().is_finite() {
            return PrincipalFrame::invalid(Status::Diverged);
        }
        let (geometry, on_boundary) = self.ends.geometry(&self.curve, parameter, &jet, &residual);
        PrincipalFrame {
            foot: jet.point,
            axes: geometry.axes,
            curvatures: geometry.curvatures,
            tangent_dimension: geometry.tangent_dimension,
            distance: geometry.distance,
            on_boundary,
            hint: Hint::new(0, [parameter, 0.0]),
            status: if on_boundary { Status::OnBoundary } else { Status::Converged },
        }
    }

    fn bounding_box(&self) -> Aabb<D> {
        self.bounds
    }
}
