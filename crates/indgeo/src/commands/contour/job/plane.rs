//! Contours in the plane.

use super::level_function::{level_function, without_effect};
use super::{ContourResults, CurveResult, EvolutionResult, Job, Method, Region, drawing, output};
use crate::error::Error;
use crate::input::image_or_grid::{Source, refused};
use crate::report::{Report, Timings};
use crate::runtime::progress::Progress;
use industrial_geometry::distance_field::{Grid, LevelSetField, Saddles};
use industrial_geometry::level_set::evolve::{
    ChanVeseOptions, Evolved, GeodesicOptions, chan_vese, geodesic_contour, inset_box,
};
use industrial_geometry::level_set::region::topology;
use industrial_geometry::level_set::{
    FitOptions, FittedContour, Image, Inside, contours, fit_contours, signed_area, threshold,
};
use industrial_geometry::mesh::Polyline;
use industrial_geometry::mesh::nalgebra::Vector2;

/// Smoothing of images where none is given, in pixels; steps of whole pixels need more, and so do edges that are looked for.
const SMOOTHING: f64 = 1.0;
const SMOOTHING_OF_STEPS: f64 = 1.5;
/// Tolerance where none is given, in cells.
const TOLERANCE: f64 = 0.1;
/// Least area where none is given, in pixels.
const AREA: f64 = 10.0;
/// Distance of the first contour from the border of the image, in pixels.
const INSET: f64 = 3.0;

/// A level function and how it was found.
struct Found {
    grid: Grid<2>,
    /// What a picture shows.
    backdrop: Grid<2>,
    level: Option<f64>,
    inside: Option<&'static str>,
    smoothing: f64,
    evolved: Option<Evolved<2>>,
    size: [usize; 2],
    /// Height of the picture: y points down from there in SVG.
    top: f64,
}

pub(super) fn run(job: &Job<'_>, source: &Source, report: &mut Report) -> Result<ContourResults, Error> {
    if let Some(path) = job.out {
        output::check_plane(path, job.cad)?;
    }
    let failed = |error: &industrial_geometry::level_set::Error| refused(job.input, error);
    let progress = Progress::iterations("contours", job.quiet);
    let (found, field, fitted, left_out, tolerance) = {
        let mut timings = report.timings;
        let found = Timings::measure(&mut timings.build, || match source {
            Source::Image(image) => of_image(job, image),
            Source::Grid(grid) => {
                only_threshold(job)?;
                let level = job.level.unwrap_or(0.0);
                let function = level_function::<2>(job, grid, level)?;
                let is_bright = job.inside == Region::Bright;
                let grid = if is_bright { negated(&function, job)? } else { function };
                let [w, h] = grid.counts();
                let top = grid.position(grid.values().len() - 1).y;
                Ok(Found {
                    backdrop: grid.clone(),
                    grid,
                    level: Some(level),
                    inside: Some(if is_bright { "bright" } else { "dark" }),
                    smoothing: 0.0,
                    evolved: None,
                    size: [w, h],
                    top,
                })
            }
        })?;
        let cell = found.grid.spacing().min();
        let tolerance = job.tolerance.unwrap_or(TOLERANCE * cell);
        let saddles = if job.is_held { Saddles::Separate } else { Saddles::Middle };
        let field = contours(&found.grid, saddles).map_err(|error| failed(&error))?;
        let is_image = matches!(source, Source::Image(_));
        let least = job.min_area.unwrap_or(if is_image { AREA } else { 0.0 });
        let kept: Vec<Polyline<2>> = field.contours().iter().filter(|c| is_kept(c, least)).cloned().collect();
        let left_out = field.contours().len() - kept.len();
        if kept.is_empty() {
            let what = format!("all {left_out} contours surround less than {least}");
            return Err(Error::content(job.input, what, "lower --min-area, or smooth more (--smooth)"));
        }
        let options = FitOptions::default().with_abs_tolerance(tolerance).with_controls(job.controls);
        let fitted = Timings::measure(&mut timings.compute, || fit_contours(&field, &kept, &options))
            .map_err(|error| failed(&error))?;
        report.timings = timings;
        (found, field, fitted, left_out, tolerance)
    };
    drop(progress);
    let region = topology(&found.grid.counts(), found.grid.values());
    let curves = results(&fitted);
    if let Some(path) = job.out {
        output::write_plane(path, &fitted, &curves, &found.grid, found.top, tolerance, job.cad, report)?;
    }
    if let Some(path) = job.picture {
        drawing::write(path, &found.backdrop, &fitted, report)?;
    }
    drop(field);
    let max = fitted.iter().map(|c| c.forth.max(c.back)).fold(0.0, f64::max);
    Ok(ContourResults {
        method: job.method.name(),
        size: found.size.to_vec(),
        level: found.level,
        inside: found.inside,
        smoothing: found.smoothing,
        tolerance,
        max: Some(max),
        within_tolerance: fitted.iter().all(|c| c.is_within),
        components: region.components,
        holes: region.holes,
        left_out,
        evolution: found.evolved.as_ref().map(|evolved| EvolutionResult {
            steps: evolved.steps,
            settled: evolved.is_settled,
            speed: evolved.speed,
            components_at_start: evolved.before.components,
            holes_at_start: evolved.before.holes,
        }),
        contours: curves,
        mesh: None,
        surface: None,
    })
}

/// Whether a contour is large enough: one that ends at the border is if it is as long as a circle around the least area.
fn is_kept(contour: &Polyline<2>, least: f64) -> bool {
    if !contour.is_closed() {
        return contour.length() >= (4.0 * std::f64::consts::PI * least).sqrt();
    }
    let mut ring = contour.vertices().to_vec();
    ring.extend(contour.vertices().first().copied());
    Polyline::new(ring, false).is_ok_and(|ring| signed_area(&ring).abs() >= least)
}

fn results(fitted: &[FittedContour]) -> Vec<CurveResult> {
    let result = |(number, contour): (usize, &FittedContour)| CurveResult {
        name: format!("{} {number}", if contour.is_hole { "hole" } else { "contour" }),
        closed: contour.is_closed,
        hole: contour.is_hole,
        area: contour.area,
        length: contour.length,
        control_points: contour.controls,
        max_of_curve: contour.forth,
        max_of_contour: contour.back,
        crossings: contour.crossings,
        within_tolerance: contour.is_within,
    };
    fitted.iter().enumerate().map(result).collect()
}

/// Grids in the plane have level sets only.
fn only_threshold(job: &Job<'_>) -> Result<(), Error> {
    let evolves = job.method != Method::Threshold;
    without_effect(
        &[(evolves, "--method chan-vese or edges"), (job.smooth.is_some(), "--smooth")],
        "a grid",
    )?;
    without_evolution(job)
}

/// Options of evolving contours mean nothing without one.
fn without_evolution(job: &Job<'_>) -> Result<(), Error> {
    let options = [
        (job.is_held, "--topology fixed"),
        (!job.start.is_empty(), "--start"),
        (job.length_weight.is_some(), "--length-weight"),
        (job.balloon.is_some(), "--balloon"),
    ];
    without_effect(&options, "a threshold, which does not evolve")
}

fn negated(grid: &Grid<2>, job: &Job<'_>) -> Result<Grid<2>, Error> {
    let values = grid.values().iter().map(|value| -value).collect();
    grid.with_values(values).map_err(|error| Error::content(job.input, error.to_string(), "check the grid"))
}

/// The usual smoothing: more where edges are steps of whole pixels.
fn smoothing_of(image: &Image) -> f64 {
    if image.is_black_and_white() { SMOOTHING_OF_STEPS } else { SMOOTHING }
}

fn of_image(job: &Job<'_>, image: &Image) -> Result<Found, Error> {
    let failed = |error: industrial_geometry::level_set::Error| refused(job.input, &error);
    without_effect(&[(job.bounds.is_some(), "--box")], "an image, whose unit is the pixel")?;
    let usual = if job.method == Method::Edges { SMOOTHING_OF_STEPS } else { smoothing_of(image) };
    let smoothing = job.smooth.unwrap_or(usual);
    let inside = match job.inside {
        Region::Auto => Inside::Automatic,
        Region::Bright => Inside::Bright,
        Region::Dark => Inside::Dark,
    };
    let mut found = Found {
        grid: image.grid().map_err(failed)?,
        backdrop: image.grid().map_err(failed)?,
        level: None,
        inside: None,
        smoothing,
        evolved: None,
        size: [image.width(), image.height()],
        top: image.height() as f64,
    };
    let by_level = |found: &mut Found| -> Result<Grid<2>, Error> {
        let level = match job.level {
            Some(level) => level,
            None => threshold::otsu(image).map_err(failed)?,
        };
        found.level = Some(level);
        found.inside = Some(if image.side(level, inside) == Inside::Bright { "bright" } else { "dark" });
        image.level_function(level, inside, smoothing).map_err(failed)
    };
    match job.method {
        Method::Threshold => {
            without_evolution(job)?;
            found.grid = by_level(&mut found)?;
        }
        Method::ChanVese => {
            without_effect(&[(job.balloon.is_some(), "--balloon")], "--method chan-vese")?;
            let has_level = job.level.is_some() && !job.start.is_empty();
            without_effect(&[(has_level, "--level")], "a contour that starts from circles")?;
            let start = if job.start.is_empty() { by_level(&mut found)? } else { circles(job, &found.grid)? };
            let defaults = ChanVeseOptions::default();
            let options = defaults
                .with_length_weight(job.length_weight.unwrap_or(defaults.length_weight))
                .with_fixed_topology(job.is_held);
            let values = image.smoothed(smoothing).map_err(failed)?;
            let evolved = chan_vese(&values, &start, &options).map_err(failed)?;
            found.grid = evolved.grid.clone();
            found.evolved = Some(evolved);
        }
        Method::Edges => {
            without_effect(
                &[(job.level.is_some(), "--level"), (job.inside != Region::Auto, "--inside")],
                "--method edges, which knows no level",
            )?;
            let defaults = GeodesicOptions::default();
            let grows = if job.start.is_empty() { defaults.balloon } else { -defaults.balloon };
            let start = if job.start.is_empty() {
                inset_box(image, INSET).map_err(failed)?
            } else {
                circles(job, &found.grid)?
            };
            let options = defaults
                .with_smoothness(job.length_weight.unwrap_or(defaults.smoothness))
                .with_balloon(job.balloon.unwrap_or(grows))
                .with_fixed_topology(job.is_held);
            let values = image.smoothed(smoothing).map_err(failed)?;
            let evolved = geodesic_contour(&values, &start, &options).map_err(failed)?;
            found.grid = evolved.grid.clone();
            found.evolved = Some(evolved);
        }
    }
    Ok(found)
}

/// The distance from the union of the circles that were typed.
fn circles(job: &Job<'_>, grid: &Grid<2>) -> Result<Grid<2>, Error> {
    let far = |node: usize| {
        let p = grid.position(node);
        let from = |[x, y, r]: &[f64; 3]| (p - Vector2::new(*x, *y)).norm() - r;
        job.start.iter().map(from).fold(f64::INFINITY, f64::min)
    };
    let values = (0..grid.values().len()).map(far).collect();
    grid.with_values(values).map_err(|error| Error::usage(error.to_string(), "change --start"))
}

/// The level set of an image as a source of distances: its field, and curves within a tolerance of it.
pub(crate) fn of_source(
    image: &Image,
    tolerance: f64,
) -> Result<(LevelSetField<2>, Vec<FittedContour>), industrial_geometry::level_set::Error> {
    let level = threshold::otsu(image)?;
    let field =
        contours(&image.level_function(level, Inside::Automatic, smoothing_of(image))?, Saddles::Middle)?;
    let options = FitOptions::default().with_abs_tolerance(tolerance);
    let fitted = fit_contours(&field, field.contours(), &options)?;
    Ok((field, fitted))
}
