//! Options of the whole way.

use crate::{AxisChoice, BaseCurveOptions, CurveOptions, DirectedWeight, RefineOptions, Shape};
use nalgebra::Vector3;

/// Options of [`parameterise`](crate::parameterise). The defaults ask for nothing.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct ParameteriseOptions {
    /// Kind of the base surface; default decided by the cloud.
    pub shape: Shape,
    /// Axis of the turntable; default estimated.
    pub axis: AxisChoice,
    /// How base curves are made.
    pub curves: BaseCurveOptions,
    /// How they are drawn to the cloud.
    pub projection: CurveOptions,
    /// How the surface through them is drawn to the cloud.
    pub refine: RefineOptions,
}

impl ParameteriseOptions {
    /// The same options for a kind of surface.
    #[must_use]
    pub fn with_shape(self, shape: Shape) -> Self {
        Self { shape, ..self }
    }

    /// The same options with a given axis.
    #[must_use]
    pub fn with_axis(self, direction: Vector3<f64>) -> Self {
        Self { axis: AxisChoice::Given(direction), ..self }
    }

    /// The same options with a given number of views.
    #[must_use]
    pub fn with_views(mut self, views: usize) -> Self {
        self.curves.views = Some(views);
        self
    }

    /// The same options with a grid of given size: samples around the axis, and layers along it.
    #[must_use]
    pub fn with_grid(mut self, samples: usize, layers: usize) -> Self {
        self.curves.samples = Some(samples);
        self.projection.samples = Some(samples);
        self.curves.layers = Some(layers);
        self
    }

    /// The same options with another weight of directed projections.
    #[must_use]
    pub fn with_weight(mut self, weight: DirectedWeight) -> Self {
        self.projection.directed.weight = weight;
        self.refine.directed.weight = weight;
        self
    }
}
