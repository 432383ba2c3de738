//! Base surfaces that are closed around an axis.

use super::{Base, Clock, ParameteriseOptions, ParameteriseReport, Stage};
use crate::curves::CurveOrigin;
use crate::{
    AxisEstimate, Error, Neighbourhood, ShapeDecision, Turntable, base_curves, grid_of_curves,
    project_curves, refine,
};

/// Rows that may be added beyond the last full layer at each end.
const ROWS_BEYOND: f64 = 3.0;
/// Factors by which the grid is made coarser as long as the base surface folds.
const COARSER: [f64; 4] = [1.0, 1.5, 2.25, 3.5];

pub(super) fn base(
    cloud: &Neighbourhood,
    shape: ShapeDecision,
    axis: &AxisEstimate,
    options: &ParameteriseOptions,
    clock: &mut Clock<'_>,
) -> Result<Base, Error> {
    clock.enter(Stage::BaseCurves)?;
    let mut report = ParameteriseReport::new(shape, axis);
    let table = Turntable::new(cloud.points(), &axis.direction)?;
    let mut found = base_curves(&table, cloud, &options.curves)?;
    (report.views, report.seen) = (found.views, found.seen);
    report.layers = [found.curves.len(), found.layers];
    report.radial_layers = found.curves.iter().filter(|c| c.origin == CurveOrigin::Radial).count();

    clock.enter(Stage::Projection)?;
    let projected = project_curves(&table.frame, cloud, &mut found.curves, &options.projection)?;
    report.curve_history = projected.history;
    report.smoothed_curves = projected.smoothed;

    clock.enter(Stage::Refinement)?;
    let automatic = found.curves.iter().map(|c| c.curve.points()).max().unwrap_or(0).max(8);
    let count = options.curves.samples.unwrap_or(automatic);
    let mut best: Option<(usize, Base)> = None;
    for (attempt, coarser) in COARSER.into_iter().enumerate() {
        // Fewer and smoother samples where more would fold: detail that the cloud does not resolve, as in threads.
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "less than a number of rows"
        )]
        let fewer = |n: usize, least: usize| ((n as f64 / coarser).round() as usize).max(least);
        let heights = heights(&table, found.heights, fewer(found.layers, 7));
        let mut grid = grid_of_curves(&table.frame, &found.curves, &heights, fewer(count, 12))?;
        for _ in 0..2 * attempt {
            grid = grid.smoothed();
        }
        let (grid, surface, refined) = refine(&grid, cloud, Some(&table.frame), &options.refine)?;
        let mut report = report.clone();
        report.grid = grid.size;
        report.defects = super::defects(&surface, Some(&table.frame.axes));
        report.refine_history = refined.history;
        report.unsupported = refined.unsupported;
        let wrong = report.defects.self_loops + report.defects.crossovers;
        if best.as_ref().is_none_or(|(least, _)| wrong < *least) {
            best = Some((wrong, Base { surface, report }));
        }
        if wrong == 0 || options.curves.layers.is_some() {
            break;
        }
    }
    best.map(|(_, base)| base)
        .ok_or(Error::Shape { wanted: "a cylinder", why: "no base surface could be made".into() })
}

/// Heights of the rows: those of the layers, and a few beyond them where the cloud goes on without going all around.
fn heights(table: &Turntable, [low, high]: [f64; 2], layers: usize) -> Vec<f64> {
    let step = (high - low) / (layers - 1) as f64;
    let beyond = |length: f64| ((length / step).round()).clamp(0.0, ROWS_BEYOND);
    let (below, above) = (beyond(low - table.heights[0]), beyond(table.heights[1] - high));
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "at most 3")]
    let rows = layers + (below + above) as usize;
    (0..rows).map(|k| low + step * (k as f64 - below)).collect()
}
