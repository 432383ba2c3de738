//! Base surfaces that are closed all around: rows from pole to pole, seen from the middle.

use super::{Base, Clock, ParameteriseOptions, ParameteriseReport, Stage};
use crate::curves::SAMPLE_SPACING;
use crate::{AxisEstimate, AxisFrame, Error, Neighbourhood, SampleGrid, ShapeDecision, refine};
use nalgebra::Vector3;
use std::f64::consts::{PI, TAU};

/// Points whose distances from the middle are averaged.
const AVERAGED: usize = 6;

pub(super) fn base(
    cloud: &Neighbourhood,
    shape: ShapeDecision,
    axis: &AxisEstimate,
    options: &ParameteriseOptions,
    clock: &mut Clock<'_>,
) -> Result<Base, Error> {
    clock.enter(Stage::BaseCurves)?;
    let points = cloud.points();
    let (low, high) = points.iter().fold((points[0], points[0]), |(l, h), p| (l.inf(p), h.sup(p)));
    let frame = AxisFrame::new((low + high) / 2.0, &axis.direction)?;
    let local: Vec<Vector3<f64>> =
        points.iter().map(|p| frame.to_local(p)).filter(|p| p.norm() > 0.0).collect();
    let directions: Vec<Vector3<f64>> = local.iter().map(|p| p.normalize()).collect();
    let index = Neighbourhood::new(&directions)?;
    let mean = local.iter().map(|p| p.norm()).sum::<f64>() / local.len() as f64;
    // The distance from the middle in a direction: of the points whose directions are nearest, near ones counting more.
    let distance = |d: &Vector3<f64>| {
        let near = index.nearest_indices(d, AVERAGED);
        let weight = |gap: f64| 1.0 / (gap * gap + index.spacing().powi(2));
        let (sum, total) = near.iter().fold((0.0, 0.0), |(s, t), &(i, gap)| {
            let w = weight(gap);
            (s + w * local[i].norm(), t + w)
        });
        sum / total
    };
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped")]
    let automatic = (PI * mean / (SAMPLE_SPACING * cloud.pitch())).round().clamp(9.0, 100.0) as usize;
    let rows = options.curves.layers.unwrap_or(automatic).max(5);
    let around = options.curves.samples.unwrap_or(2 * rows).max(8);
    let mut grid = Vec::with_capacity(rows * around);
    for i in 0..around {
        let (sin, cos) = (TAU * i as f64 / around as f64).sin_cos();
        for j in 0..rows {
            // From the lower pole to the upper one: normals point outwards.
            let (across, along) = match j {
                0 => (0.0, -1.0),
                j if j + 1 == rows => (0.0, 1.0),
                j => {
                    let polar = PI * j as f64 / (rows - 1) as f64;
                    (polar.sin(), -polar.cos())
                }
            };
            let d = Vector3::new(across * cos, across * sin, along);
            grid.push(frame.to_world(&(d * distance(&d))));
        }
    }
    clock.enter(Stage::Refinement)?;
    let grid = SampleGrid { size: [around, rows], points: grid, closed: true };
    let (grid, surface, refined) = refine(&grid, cloud, None, &options.refine)?;
    let mut report = ParameteriseReport::new(shape, axis);
    report.grid = grid.size;
    report.defects = super::defects(&surface, None);
    report.refine_history = refined.history;
    report.unsupported = refined.unsupported;
    Ok(Base { surface, report })
}
