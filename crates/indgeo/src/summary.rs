//! What a projection or an inspection says to a person.

use crate::alignment_summary;
use crate::fit_numbers::FitNumbers;
use crate::fitting_ruled::RuledResults;
use crate::fitting_subdivision::SubdivisionResults;
use crate::fitting_surface::SurfaceResults;
use crate::on_surface;
use crate::parameterizing::ParameterResults;
use crate::registration_report::RegistrationResults;
use crate::report::{ModelSummary, ProjectionResults, Report, Results};
use crate::segmenting;
use crate::views_report::ViewsResults;
use crate::wording::counted;
use industrial_geometry::fit::curve::CurveReport;
use industrial_geometry::fit::{CurveCoverage, Folds, SurfaceCoverage};
use industrial_geometry::inspection::{
    Inspection, Outcome, PartDeviations, Rounding, Tolerance, percent, percent_in_full, percent_of_share,
};
use std::fmt::Write;

/// Parts that are listed at most.
const PARTS: usize = 20;

/// A few lines about a projection or an inspection; empty for other commands.
pub(crate) fn of(report: &Report) -> String {
    let mut text = String::new();
    // Writing to memory cannot fail.
    let _ = match &report.results {
        Some(Results::Projection(results)) => write_projection(&mut text, report, results),
        Some(Results::Inspection(found)) => write_inspection(&mut text, report, &found.found),
        Some(Results::Registration(found)) => write_registration(&mut text, report, found),
        Some(Results::Alignment(found)) => alignment_summary::write(&mut text, report, found),
        Some(Results::Parameters(found)) => write_parameters(&mut text, report, found),
        Some(Results::Views(found)) => write_views(&mut text, report, found),
        Some(Results::Curve(found)) => write_curve(&mut text, report, &found.fitted, found.parts.len()),
        Some(Results::Surface(found)) => write_surface(&mut text, report, found),
        Some(Results::Ruled(found)) => write_ruled(&mut text, report, found),
        Some(Results::Subdivision(found)) => write_subdivision(&mut text, report, found),
        Some(Results::Geodesic(found)) => on_surface::summary::write_geodesic(&mut text, report, found),
        Some(Results::Morphology(found)) => on_surface::summary::write_morphology(&mut text, report, found),
        Some(Results::Patch(found)) => on_surface::summary::write_patch(&mut text, report, found),
        Some(Results::Segmentation(found)) => segmenting::summary::write(&mut text, report, found),
        _ => Ok(()),
    };
    text
}

fn write_projection(text: &mut String, report: &Report, results: &ProjectionResults) -> std::fmt::Result {
    if let Some(model) = &report.model {
        let piece = match model.kind {
            "mesh" => "triangle",
            "cad" => "face",
            "level_set" => "crossing",
            _ => "Bézier piece",
        };
        writeln!(
            text,
            "{} projected onto {} ({})",
            counted(results.points, "point"),
            counted(model.shapes, "shape"),
            counted(model.patches, piece)
        )?;
    }
    let counts = |counts: Vec<(&str, usize)>| {
        let parts: Vec<String> = counts.iter().map(|(name, count)| format!("{count} {name}")).collect();
        parts.join(", ")
    };
    writeln!(text, "  status    {}", counts(results.status.iter().map(|(&name, &n)| (name, n)).collect()))?;
    if let Some(distance) = &results.distance {
        let [min, max] = [distance.min, distance.max].map(plain);
        let [mean, rms] = [distance.mean, distance.rms].map(plain);
        let median = plain(distance.quantile(0.5).unwrap_or(f64::NAN));
        writeln!(text, "  distance  min {min}  max {max}  mean {mean}  rms {rms}  median {median}")?;
    }
    if let Some(worst) = &results.worst {
        let name = quoted(worst.name.as_deref());
        writeln!(text, "  worst     {} at point {} (from 0){name}", plain(worst.distance), worst.index)?;
    }
    if let Some(gap) = results.largest_gap {
        let wide = results.wide_gaps.map_or_else(String::new, |wide| {
            let share = percent(wide as u64, results.points as u64, Rounding::Up);
            format!("; by more than 1e-7 of its diagonal at {wide} points ({share})")
        });
        writeln!(text, "  certified no point of the model is nearer by more than {gap:.1e}{wide}")?;
    } else if report.model.as_ref().is_some_and(|model| model.kind != "mesh") {
        let mode = report.options.as_ref().map_or("", |options| options.mode);
        let what = match mode {
            "certified" => "each foot is found from the crossings next to its point",
            "local" => "each foot is the local minimum next to a nearby sample",
            _ => "each foot is the best of several local minima",
        };
        writeln!(text, "  proven    none: in mode {mode} {what}; another point may be nearer")?;
    }
    write_end(text, report)
}

fn write_inspection(text: &mut String, report: &Report, found: &Inspection) -> std::fmt::Result {
    let verdict = &found.verdict;
    let Tolerance { lower, upper } = found.options.tolerance;
    writeln!(
        text,
        "{}: {} of {} within {lower} to {upper} ({}, at least {} asked for)",
        if verdict.pass { "PASS" } else { "FAIL" },
        verdict.within,
        counted(verdict.judged, "point"),
        percent(verdict.within, verdict.judged, Rounding::Down),
        percent_in_full(verdict.min_share)
    )?;
    let total = &found.total;
    writeln!(
        text,
        "  points    {} measured: {} within, {} over, {} under",
        total.count, total.within, total.over, total.under
    )?;
    let listed = |judged: bool| {
        let chosen = Outcome::ALL.iter().filter(|o| **o != Outcome::Measured && o.is_judged() == judged);
        let counts = chosen.map(|outcome| (outcome.name(), found.outcomes.get(outcome.name())));
        let counts = counts.filter_map(|(name, count)| Some((name, count.filter(|count| **count > 0)?)));
        counts.map(|(name, count)| format!("{count} {name}")).collect::<Vec<String>>().join(", ")
    };
    for (label, counts) in [("not within", listed(true)), ("not used ", listed(false))] {
        if !counts.is_empty() {
            writeln!(text, "  {label} {counts}")?;
        }
    }
    if found.restricted > 0 {
        writeln!(
            text,
            "  normals   {} points are measured on a face that is not the nearest",
            found.restricted
        )?;
    }
    if let Some(distance) = &total.distance {
        let [min, max, mean] = [distance.min, distance.max, distance.mean].map(plain);
        let [rms, sigma] = [distance.rms, distance.standard_deviation].map(plain);
        writeln!(text, "  deviation min {min}  max {max}  mean {mean}  rms {rms}  sigma {sigma}")?;
    }
    if let Some(worst) = found.worst.first() {
        let name = quoted(worst.name.as_deref());
        writeln!(text, "  worst     {} at point {} (from 0){name}", plain(worst.distance), worst.index)?;
    }
    write_parts(text, found)?;
    write_end(text, report)
}

/// One line for each part of a CAD model that has several; of many parts those that are worst.
fn write_parts(text: &mut String, found: &Inspection) -> std::fmt::Result {
    let mut parts: Vec<_> = found.parts.iter().collect();
    if parts.len() < 2 {
        return Ok(());
    }
    let out = |part: &PartDeviations| part.deviations.over + part.deviations.under;
    parts.sort_by(|a, b| out(b).cmp(&out(a)).then(a.index.cmp(&b.index)));
    for part in parts.iter().take(PARTS) {
        let Some(distance) = &part.deviations.distance else { continue };
        let size = distance.max.abs().max(distance.min.abs());
        writeln!(
            text,
            "  part      {} \"{}\": {}, rms {}, max {}, {} out",
            part.index,
            part.name,
            counted(part.deviations.count, "point"),
            plain(distance.rms),
            plain(size),
            percent(out(part), part.deviations.count, Rounding::Up)
        )?;
    }
    match parts.len().saturating_sub(PARTS) {
        0 => Ok(()),
        more => writeln!(text, "  parts     {more} more, with fewer points out of tolerance"),
    }
}

fn write_registration(text: &mut String, report: &Report, found: &RegistrationResults) -> std::fmt::Result {
    let motion = &found.transform;
    writeln!(
        text,
        "{} after {}: {} of {} used",
        motion.status,
        counted(motion.iterations, "step"),
        motion.points_used,
        counted(motion.points, "point")
    )?;
    writeln!(text, "  distance  rms {}  (at the start {})", plain(motion.rms), plain(motion.initial_rms))?;
    let [x, y, z] = motion.translation.map(plain);
    writeln!(
        text,
        "  motion    turned by {:.4} degrees, moved by ({x}, {y}, {z})",
        motion.rotation.angle.to_degrees()
    )?;
    if motion.scale != 1.0 {
        writeln!(text, "  scale     {}", motion.scale)?;
    }
    for free in &motion.free_motions {
        writeln!(text, "  not fixed {free}")?;
    }
    let chosen = &found.starts[found.best_start];
    writeln!(
        text,
        "  start     {} of {} ({}), {} of the points near the model",
        found.best_start + 1,
        found.starts.len(),
        chosen.origin,
        percent_of_share(chosen.share_near, Rounding::Down)
    )?;
    if let Some(inspection) = &found.inspection {
        return write_inspection(text, report, &inspection.found);
    }
    write_end(text, report)
}

fn write_views(text: &mut String, report: &Report, found: &ViewsResults) -> std::fmt::Result {
    let name = |view: usize| {
        let path = &found.views[view].path;
        path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned()
    };
    writeln!(
        text,
        "{} after {}: {}, {}, started from {}",
        found.status,
        counted(found.iterations, "step"),
        counted(found.views.len(), "view"),
        counted(found.pairs.len(), "overlapping pair"),
        match found.start {
            "search" => "a search over all positions",
            "init" => "the poses of --init",
            _ => "where the views are",
        }
    )?;
    writeln!(text, "  distance  rms {}", plain(found.rms))?;
    for pair in &found.pairs {
        let [i, j] = pair.views;
        writeln!(
            text,
            "  pair      {} - {}: rms {} (before {}), {}, overlap {} and {}",
            name(i),
            name(j),
            plain(pair.rms_after),
            plain(pair.rms_before),
            counted(pair.count, "point"),
            percent_of_share(pair.overlap[0], Rounding::Down),
            percent_of_share(pair.overlap[1], Rounding::Down)
        )?;
    }
    if found.components.len() > 1 {
        for members in &found.components {
            let names: Vec<String> = members.iter().map(|&view| name(view)).collect();
            writeln!(text, "  together  {}", names.join(", "))?;
        }
    }
    write_end(text, report)
}

fn write_curve(text: &mut String, report: &Report, found: &CurveReport, parts: usize) -> std::fmt::Result {
    let kind = if found.closed { "closed" } else { "open" };
    let kind = if parts > 1 { format!("{parts} curves") } else { format!("{kind} curve") };
    writeln!(
        text,
        "{kind} of degree {} with {} after {} ({})",
        found.degree,
        counted(found.controls, "control point"),
        counted(found.iterations, "iteration"),
        found.status
    )?;
    writeln!(
        text,
        "  distance  rms {}  max {} at point {} (from 0)",
        plain(found.rms),
        plain(found.max),
        found.max_index
    )?;
    write_curve_coverage(text, &found.coverage)?;
    if found.used + found.dropped < found.points {
        writeln!(text, "  left out  {}", counted(found.points - found.dropped - found.used, "outlier"))?;
    }
    if let (Some(share), Some(reached)) = (found.share_within, found.reached) {
        let verdict = if reached { "reached" } else { "NOT reached" };
        let share = percent_of_share(share, Rounding::Down);
        writeln!(text, "  tolerance {verdict}: {share} of the points within")?;
    }
    if !found.crossings.is_empty() {
        writeln!(text, "  crossings {} (the curve crosses itself)", found.crossings.len())?;
    }
    write_end(text, report)
}

fn write_parameters(text: &mut String, report: &Report, results: &ParameterResults) -> std::fmt::Result {
    let found = &results.found;
    let [around, along] = found.grid;
    writeln!(
        text,
        "{}: a {} of {around} x {along} samples; {} of {} used",
        found.status,
        found.shape.shape.name(),
        found.used,
        counted(found.points, "point")
    )?;
    writeln!(text, "  shape     {}", found.shape.why)?;
    if found.views > 0 {
        let axis = &found.axis;
        writeln!(
            text,
            "  axis      ({:.6}, {:.6}, {:.6}), {}, {} of {}",
            axis.direction.x,
            axis.direction.y,
            axis.direction.z,
            counted(found.views, "view"),
            found.layers[0],
            counted(found.layers[1], "layer")
        )?;
    }
    writeln!(
        text,
        "  distance  rms {}  max {}  (points are {} apart)",
        plain(found.rms),
        plain(found.max),
        plain(found.spacing)
    )?;
    writeln!(
        text,
        "  surface   {}, {}; {} of the points have one closest point only",
        counted(found.defects.self_loops, "self-loop"),
        counted(found.defects.crossovers, "crossover"),
        percent_of_share(found.unique, Rounding::Down)
    )?;
    if let Some(fit) = &results.fit {
        let [u, v] = fit.control_points;
        writeln!(
            text,
            "  fit       {u} x {v} control points: rms {}  max {}",
            plain(fit.rms),
            plain(fit.max)
        )?;
        write_coverage(text, Some(&fit.coverage))?;
        if let Some(finish) = &fit.finish {
            let least_squares = &fit.least_squares;
            writeln!(
                text,
                "  finish    {}: rms {} -> {}, folds {} -> {}",
                finish.outcome.name().replace('_', " "),
                plain(least_squares.rms),
                plain(fit.rms),
                least_squares.defects.crossovers,
                fit.defects.crossovers
            )?;
        }
    }
    write_end(text, report)
}

fn write_surface(text: &mut String, report: &Report, results: &SurfaceResults) -> std::fmt::Result {
    let fit = &results.fit;
    let insertions = results.runs.saturating_sub(1);
    writeln!(
        text,
        "{} × {} control points after {} ({}), {}",
        results.control_points[0],
        results.control_points[1],
        counted(fit.iterations, "iteration"),
        fit.status,
        counted(insertions, "change of the knots")
    )?;
    let start = results.base.map_or("the surface given", |base| base.name());
    match &results.start {
        Some(from) => writeln!(text, "  start     {start}: {}", from.why)?,
        None => writeln!(text, "  start     {start}")?,
    }
    if let Some((base, least_squares)) =
        results.start.as_ref().and_then(|from| from.base_rms.zip(from.least_squares_rms))
    {
        writeln!(
            text,
            "            rms {} from the base surface, {} from the least squares surface",
            plain(base),
            plain(least_squares)
        )?;
    }
    write_distances(text, fit)?;
    write_coverage(text, results.coverage.as_ref())?;
    write_folds(text, &results.folds)?;
    write_end(text, report)
}

fn write_ruled(text: &mut String, report: &Report, found: &RuledResults) -> std::fmt::Result {
    let (fit, [along, sections]) = (&found.fit, found.control_points);
    writeln!(
        text,
        "{sections} sections of {along} control points after {} ({}), {} fitted",
        counted(fit.iterations, "iteration"),
        fit.status,
        counted(found.runs, "surface")
    )?;
    writeln!(text, "  start     {}", found.base.map_or("the surface given", |base| base.name()))?;
    write_distances(text, fit)?;
    write_coverage(text, found.coverage.as_ref())?;
    writeln!(text, "  rulings   {}", found.developability)?;
    write_folds(text, &found.folds)?;
    write_end(text, report)
}

fn write_subdivision(text: &mut String, report: &Report, found: &SubdivisionResults) -> std::fmt::Result {
    writeln!(
        text,
        "control mesh of {} vertices ({} irregular) and {} triangles, {}, after {} ({})",
        found.vertices,
        found.irregular,
        found.triangles,
        found.start,
        counted(found.fit.iterations, "iteration"),
        found.fit.status
    )?;
    write_distances(text, &found.fit)?;
    write_coverage(text, found.coverage.as_ref())?;
    match found.folded_edges.limit {
        0 => {}
        count => writeln!(text, "  folds     at {} of the limit surface", counted(count, "edge"))?,
    }
    write_end(text, report)
}

fn write_curve_coverage(text: &mut String, found: &CurveCoverage) -> std::fmt::Result {
    writeln!(
        text,
        "  curve     to the points: rms {}  max {} ({:.1} spacings)",
        plain(found.rms),
        plain(found.max),
        found.max_in_spacings
    )?;
    if found.is_complete() {
        return writeln!(text, "  length    {}, none of it without data", plain(found.length));
    }
    let share = percent_of_share(found.length_without_data / found.length, Rounding::Up);
    writeln!(text, "  length    {}, {share} of it without data", plain(found.length))
}

fn write_coverage(text: &mut String, coverage: Option<&SurfaceCoverage>) -> std::fmt::Result {
    let Some(found) = coverage else { return Ok(()) };
    writeln!(
        text,
        "  surface   to the points: rms {}  max {} ({:.1} spacings)",
        plain(found.rms),
        plain(found.max),
        found.max_in_spacings
    )?;
    let without = found.area_without_data;
    if without > 0.0 {
        let share = percent_of_share(without / found.area, Rounding::Up);
        writeln!(text, "  area      {}, {share} of it without data", plain(found.area))
    } else {
        writeln!(text, "  area      {}, none of it without data", plain(found.area))
    }
}

fn write_distances(text: &mut String, fit: &FitNumbers) -> std::fmt::Result {
    writeln!(text, "  distance  rms {}  max {}", plain(fit.rms), plain(fit.max))?;
    if let (Some(share), Some(holds)) = (fit.share_within, fit.within_tolerance) {
        let verdict = if holds { "reached" } else { "NOT reached" };
        let share = percent_of_share(share, Rounding::Down);
        writeln!(text, "  tolerance {verdict}: {share} of the points within")?;
    }
    Ok(())
}

fn write_folds(text: &mut String, folds: &Folds) -> std::fmt::Result {
    match folds.count() {
        0 => Ok(()),
        count => writeln!(text, "  folds     in {count} of {}", counted(folds.cells, "cell")),
    }
}

pub(crate) fn write_end(text: &mut String, report: &Report) -> std::fmt::Result {
    if let Some(ModelSummary { unit: Some(unit), points_unit: Some(of_points), .. }) = &report.model {
        writeln!(text, "  units     model {unit}; points {of_points}")?;
    }
    let timings = &report.timings;
    if !report.no_timings {
        writeln!(
            text,
            "  seconds   read {:.3}  build {:.3}  compute {:.3}  write {:.3}",
            timings.read, timings.build, timings.compute, timings.write
        )?;
    }
    for output in &report.outputs {
        writeln!(text, "  wrote     {} ({})", output.path.display(), counted(output.bytes, "byte"))?;
    }
    Ok(())
}

/// A name behind what it names.
fn quoted(name: Option<&str>) -> String {
    name.map(|name| format!(" \"{name}\"")).unwrap_or_default()
}

/// A number with six decimals, or with an exponent where these would hide it.
pub(crate) fn plain(value: f64) -> String {
    let size = value.abs();
    if size >= 1e9 || (size < 1e-3 && size > 0.0) { format!("{value:.6e}") } else { format!("{value:.6}") }
}
