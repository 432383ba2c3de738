//! Base surfaces that are height fields.

use super::{Base, Clock, ParameteriseReport, Stage};
use crate::plane_frame::plane_frame;
use crate::{AxisEstimate, Error, MultilevelOptions, Neighbourhood, ShapeDecision, multilevel};
use nalgebra::Vector3;
use nurbs_core::{Direction, Interval};

/// Data per piece, on average.
const DATA_PER_PIECE: f64 = 6.0;

pub(super) fn base(
    cloud: &Neighbourhood,
    shape: ShapeDecision,
    axis: &AxisEstimate,
    clock: &mut Clock<'_>,
) -> Result<Base, Error> {
    clock.enter(Stage::Refinement)?;
    let frame = plane_frame(cloud.points())?;
    let local: Vec<Vector3<f64>> = cloud.points().iter().map(|p| frame.to_local(p)).collect();
    let options = MultilevelOptions::default().with_data_per_piece(DATA_PER_PIECE);
    let (field, _) = multilevel(&local, None, &options)?;
    let unit = Interval::new(0.0, 1.0)?;
    let surface = field
        .to_surface()?
        .clamped(Direction::U)?
        .clamped(Direction::V)?
        .reparameterized([unit, unit])?
        .transformed(&frame.rotation(), &frame.origin)?;
    let mut report = ParameteriseReport::new(shape, axis);
    report.grid = [surface.n_u(), surface.n_v()];
    report.defects = super::defects(&surface, None);
    Ok(Base { surface, report })
}
