//! What a shape is fitted to, and on which side the squared distance field is.

use crate::shape::ActiveShape;
use crate::{Error, parallel};
use distance_field::{DistanceField, ErrorTerm, Hint, PrincipalFrame, Search};
use footpoint::Status as FootStatus;
use nalgebra::{SMatrix, SVector};

/// The two attachments of the squared distance field (\[P05, sec. 4.1 and 4.4\]).
#[derive(Clone, Copy)]
pub enum Target<'a, const D: usize> {
    /// Data points; distances are measured orthogonal to the active shape, on which the footpoints lie. For sparse or noisy
    /// data.
    Points {
        /// The data.
        points: &'a [SVector<f64, D>],
        /// What each point counts, at least 0; none for equal weights.
        weights: Option<&'a [f64]>,
    },
    /// A model shape; distances of sensor points of the active shape are measured orthogonal to the model.
    Model {
        /// The distance field of the model.
        field: &'a dyn DistanceField<D>,
        /// Sensor points per cell (in each direction).
        sensors: usize,
        /// Whether sensor points count whose foot lies on the boundary of the model.
        boundary: bool,
    },
}

impl<const D: usize> std::fmt::Debug for Target<'_, D> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Points { points, .. } => write!(f, "Points({})", points.len()),
            Self::Model { sensors, .. } => write!(f, "Model({sensors} sensors per cell)"),
        }
    }
}

/// One term of the sum that is minimised: `weight · (s(parameter) − place)ᵀ Q (s(parameter) − place)`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Observation<const D: usize> {
    pub(crate) parameter: [f64; 2],
    pub(crate) place: SVector<f64, D>,
    pub(crate) matrix: SMatrix<f64, D, D>,
}

/// The feet of all samples (data points or sensor points) at one state of the shape.
#[derive(Clone, Debug)]
pub(crate) struct Feet<const D: usize> {
    pub(crate) frames: Vec<PrincipalFrame<D>>,
}

impl<const D: usize> Feet<D> {
    pub(crate) fn distance(&self, index: usize) -> f64 {
        self.frames[index].distance.abs()
    }

    /// Whether a sample can be used.
    pub(crate) fn usable(&self, index: usize) -> bool {
        let frame = &self.frames[index];
        frame.is_finite() && frame.status != FootStatus::InvalidPoint
    }
}

/// A target with all that stays the same during a fit.
#[derive(Debug)]
pub(crate) struct Samples<'a, const D: usize> {
    target: Target<'a, D>,
    /// Parameters of sensor points; empty for data points.
    sensors: Vec<[f64; 2]>,
}

impl<'a, const D: usize> Samples<'a, D> {
    pub(crate) fn new<S: ActiveShape<D>>(target: Target<'a, D>, shape: &S) -> Result<Self, Error> {
        let sensors = match target {
            Target::Points { points, weights } => {
                check_points(points, weights)?;
                Vec::new()
            }
            Target::Model { sensors, .. } => {
                if sensors == 0 {
                    return Err(Error::Option { name: "sensors", value: 0.0, allowed: "at least 1" });
                }
                shape.sensors(sensors)
            }
        };
        Ok(Self { target, sensors })
    }

    /// Data points with equal weights.
    pub(crate) fn of_points(points: &'a [SVector<f64, D>]) -> Result<Self, Error> {
        check_points(points, None)?;
        Ok(Self { target: Target::Points { points, weights: None }, sensors: Vec::new() })
    }

    pub(crate) fn len(&self) -> usize {
        match self.target {
            Target::Points { points, .. } => points.len(),
            Target::Model { .. } => self.sensors.len(),
        }
    }

    /// What a sample counts before its distance is known.
    pub(crate) fn weight(&self, index: usize, feet: &Feet<D>) -> f64 {
        if !feet.usable(index) {
            return 0.0;
        }
        match self.target {
            Target::Points { weights, .. } => weights.map_or(1.0, |w| w[index]),
            Target::Model { boundary, .. } => {
                if boundary || !feet.frames[index].on_boundary {
                    1.0
                } else {
                    0.0
                }
            }
        }
    }

    /// The feet at the present state of the shape.
    pub(crate) fn feet<S: ActiveShape<D>>(
        &self,
        shape: &S,
        search: Search,
        previous: Option<&Feet<D>>,
    ) -> Result<Feet<D>, Error> {
        let frames = match self.target {
            Target::Points { points, .. } => {
                shape.frames(points, search, previous.map_or(&[], |feet| &feet.frames))?
            }
            Target::Model { field, .. } => {
                let places = parallel::map(self.sensors.len(), |i| shape.point(self.sensors[i]));
                let hints: Vec<Hint> = previous
                    .map(|feet| feet.frames.iter().map(|frame| frame.hint).collect())
                    .unwrap_or_default();
                field.frames(&places, search, &hints)
            }
        };
        Ok(Feet { frames })
    }

    /// Where on the active shape a usable sample acts.
    pub(crate) fn parameter(&self, feet: &Feet<D>, index: usize) -> [f64; 2] {
        match self.target {
            Target::Points { .. } => feet.frames[index].hint.parameter,
            Target::Model { .. } => self.sensors[index],
        }
    }

    /// The term of a sample; it must be usable.
    pub(crate) fn observation<S: ActiveShape<D>>(
        &self,
        shape: &S,
        feet: &Feet<D>,
        index: usize,
        term: ErrorTerm,
    ) -> Observation<D> {
        let (frame, parameter) = (&feet.frames[index], self.parameter(feet, index));
        match self.target {
            Target::Points { points, .. } => {
                let place = points[index];
                Observation { parameter, place, matrix: shape.model(&place, frame, term) }
            }
            Target::Model { .. } => {
                Observation { parameter, place: frame.foot, matrix: term.model(frame).matrix() }
            }
        }
    }
}

fn check_points<const D: usize>(points: &[SVector<f64, D>], weights: Option<&[f64]>) -> Result<(), Error> {
    if let Some(weights) = weights {
        if weights.len() != points.len() {
            return Err(Error::Length { what: "weights", found: weights.len(), points: points.len() });
        }
        if let Some(index) = weights.iter().position(|w| !(w.is_finite() && *w >= 0.0)) {
            return Err(Error::Weight { index, value: weights[index] });
        }
    }
    let bad = points.iter().filter(|p| p.iter().any(|c| !c.is_finite())).count();
    match points.iter().position(|p| p.iter().any(|c| !c.is_finite())) {
        Some(index) => Err(Error::NotFinite { index, count: bad }),
        None => Ok(()),
    }
}
