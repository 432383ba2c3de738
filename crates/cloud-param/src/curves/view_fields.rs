//! What a view shows, as a height field.

use crate::turntable::turn;
use crate::{Error, HeightField, MultilevelOptions, Turntable, TurntableView, Weighting, multilevel};
use nalgebra::{Vector2, Vector3};
use nurbs_core::Interval;

/// Data per piece of a height field, on average.
const DATA_PER_PIECE: f64 = 4.0;

/// The height field of the points that a view shows ([MPK, sec. 3.3]), over the whole width and height of the table.
#[derive(Clone, Debug, PartialEq)]
pub struct ViewField {
    angle: f64,
    field: HeightField,
}

/// A place on the curve in which a layer cuts a height field.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Sample {
    pub(super) point: Vector2<f64>,
    /// Direction of the outward normal in the layer, an angle about the axis.
    pub(super) normal: f64,
}

impl ViewField {
    /// Approximates the visible points; outliers have little weight.
    ///
    /// # Errors
    /// [`Error::TooFewPoints`] for a view without points.
    pub fn new(table: &Turntable, points: &[Vector3<f64>], view: &TurntableView) -> Result<Self, Error> {
        let shown = points.iter().zip(&view.visible).filter(|&(_, &visible)| visible);
        // Coordinates: right, height, towards the eye.
        let data: Vec<Vector3<f64>> =
            shown.map(|(p, _)| table.turned(p, view.angle)).map(|p| Vector3::new(p.x, p.z, p.y)).collect();
        let domain =
            [Interval::new(-table.radius, table.radius)?, Interval::new(table.heights[0], table.heights[1])?];
        let options = MultilevelOptions::default()
            .with_weighting(Weighting::Linear)
            .with_data_per_piece(DATA_PER_PIECE)
            .with_tolerance(1e-4);
        let (field, _) = multilevel(&data, Some(domain), &options)?;
        Ok(Self { angle: view.angle, field })
    }

    /// Angle by which the table is turned.
    #[must_use]
    pub fn angle(&self) -> f64 {
        self.angle
    }

    /// The height field: over the place to the right and the height along the axis, towards the eye.
    #[must_use]
    pub fn field(&self) -> &HeightField {
        &self.field
    }

    /// `count` samples of a layer, anticlockwise around the axis (from right to left).
    pub(super) fn samples(&self, height: f64, count: usize) -> Vec<Sample> {
        let width = self.field.domain()[0];
        (0..count)
            .rev()
            .map(|i| width.lerp((i as f64 + 0.5) / count as f64))
            .map(|x| {
                let depth = self.field.value(x, height);
                let [slope, _] = self.field.gradient(x, height);
                let point = turn(&Vector3::new(x, depth, 0.0), -self.angle).xy();
                // Towards the eye the normal has the angle of the view plus a quarter turn.
                Sample { point, normal: self.angle + std::f64::consts::FRAC_PI_2 + slope.atan() }
            })
            .collect()
    }
}
