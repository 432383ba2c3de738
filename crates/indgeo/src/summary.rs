//! What a projection or an inspection says to a person.

use crate::fitting_ruled::RuledResults;
use crate::fitting_subdivision::SubdivisionResults;
use crate::fitting_surface::SurfaceResults;
use crate::parameterizing::ParameterResults;
use crate::registration_report::RegistrationResults;
use crate::report::{ProjectionResults, Report, Results};
use crate::views_report::ViewsResults;
use industrial_geometry::fit::curve::CurveReport;
use industrial_geometry::fit::{FitReport, Folds};
use industrial_geometry::inspection::{
    Inspection, Outcome, Rounding, Tolerance, percent, percent_in_full, percent_of_share,
};
use std::fmt::Write;

/// A few lines about a projection or an inspection; empty for other commands.
pub(crate) fn of(report: &Report) -> String {
    let mut text = String::new();
    // Writing to memory cannot fail.
    let _ = match &report.results {
        Some(Results::Projection(results)) => write_projection(&mut text, report, results),
        Some(Results::Inspection(found)) => write_inspection(&mut text, report, found),
        Some(Results::Registration(found)) => write_registration(&mut text, report, found),
        Some(Results::Parameters(found)) => write_parameters(&mut text, report, found),
        Some(Results::Views(found)) => write_views(&mut text, report, found),
        Some(Results::Curve(found)) => write_curve(&mut text, report, found),
        Some(Results::Surface(found)) => write_surface(&mut text, report, found),
        Some(Results::Ruled(found)) => write_ruled(&mut text, report, found),
        Some(Results::Subdivision(found)) => write_subdivision(&mut text, report, found),
        _ => Ok(()),
    };
    text
}

fn write_projection(text: &mut String, report: &Report, results: &ProjectionResults) -> std::fmt::Result {
    if let Some(model) = &report.model {
        let pieces = if model.kind == "mesh" { "triangles" } else { "Bézier pieces" };
        let shapes = if model.shapes == 1 { "shape" } else { "shapes" };
        writeln!(
            text,
            "{} points projected onto {} {shapes} ({} {pieces})",
            results.points, model.shapes, model.patches
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
        writeln!(text, "  worst     {} at point {} (from 0)", plain(worst.distance), worst.index)?;
    }
    if let Some(gap) = results.largest_gap {
        writeln!(text, "  certified no point of the model is nearer by more than {gap:.1e}")?;
    }
    write_end(text, report)
}

fn write_inspection(text: &mut String, report: &Report, found: &Inspection) -> std::fmt::Result {
    let verdict = &found.verdict;
    let Tolerance { lower, upper } = found.options.tolerance;
    writeln!(
        text,
        "{}: {} of {} points within {lower} to {upper} ({}, at least {} asked for)",
        if verdict.pass { "PASS" } else { "FAIL" },
        verdict.within,
        verdict.judged,
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
        writeln!(text, "  worst     {} at point {} (from 0)", plain(worst.distance), worst.index)?;
    }
    write_end(text, report)
}

fn write_registration(text: &mut String, report: &Report, found: &RegistrationResults) -> std::fmt::Result {
    let motion = &found.transform;
    writeln!(
        text,
        "{} after {} steps: {} of {} points count",
        motion.status, motion.iterations, motion.points_used, motion.points
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
    write_end(text, report)
}

fn write_views(text: &mut String, report: &Report, found: &ViewsResults) -> std::fmt::Result {
    let name = |view: usize| {
        let path = &found.views[view].path;
        path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned()
    };
    writeln!(
        text,
        "{} after {} steps: {} views, {} overlapping pairs, started from {}",
        found.status,
        found.iterations,
        found.views.len(),
        found.pairs.len(),
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
            "  pair      {} - {}: rms {} (before {}), {} points, overlap {} and {}",
            name(i),
            name(j),
            plain(pair.rms_after),
            plain(pair.rms_before),
            pair.count,
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

fn write_curve(text: &mut String, report: &Report, found: &CurveReport) -> std::fmt::Result {
    writeln!(
        text,
        "{} curve of degree {} with {} control points after {} iterations ({})",
        if found.closed { "closed" } else { "open" },
        found.degree,
        found.controls,
        found.iterations,
        found.status
    )?;
    writeln!(
        text,
        "  distance  rms {}  max {} at point {} (from 0)",
        plain(found.rms),
        plain(found.max),
        found.max_index
    )?;
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
        "{}: a {} of {around} x {along} samples; {} of {} points count",
        found.status,
        found.shape.shape.name(),
        found.used,
        found.points
    )?;
    writeln!(text, "  shape     {}", found.shape.why)?;
    if found.views > 0 {
        let axis = &found.axis;
        writeln!(
            text,
            "  axis      ({:.6}, {:.6}, {:.6}), {} views, {} of {} layers",
            axis.direction.x,
            axis.direction.y,
            axis.direction.z,
            found.views,
            found.layers[0],
            found.layers[1]
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
        "  surface   {} self-loops, {} crossovers; {} of the points have one closest point only",
        found.defects.self_loops,
        found.defects.crossovers,
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
    let found = &results.fitted;
    let fit = &found.fit;
    writeln!(
        text,
        "{} × {} control points after {} iterations ({}), {} insertions of knots",
        found.controls[0],
        found.controls[1],
        fit.history.len(),
        fit.status,
        found.runs - 1
    )?;
    let start = found.base.map_or("the surface given", |base| base.name());
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
    write_distances(text, fit, found.share_within, found.within_tolerance)?;
    write_folds(text, &found.folds)?;
    write_end(text, report)
}

fn write_ruled(text: &mut String, report: &Report, found: &RuledResults) -> std::fmt::Result {
    let (fit, [along, sections]) = (&found.fitted.fit, found.fitted.controls);
    writeln!(
        text,
        "{sections} sections of {along} control points after {} iterations ({}), {} surfaces fitted",
        fit.history.len(),
        fit.status,
        found.runs
    )?;
    writeln!(text, "  start     {}", found.base.map_or("the surface given", |base| base.name()))?;
    write_distances(text, fit, found.share_within, found.within_tolerance)?;
    writeln!(text, "  rulings   {}", found.fitted.developability)?;
    write_folds(text, &found.folds)?;
    write_end(text, report)
}

fn write_subdivision(text: &mut String, report: &Report, found: &SubdivisionResults) -> std::fmt::Result {
    writeln!(
        text,
        "control mesh of {} vertices ({} irregular) and {} triangles, {}, after {} iterations ({})",
        found.vertices,
        found.irregular,
        found.triangles,
        found.start,
        found.fit.history.len(),
        found.fit.status
    )?;
    write_distances(text, &found.fit, found.share_within, found.within_tolerance)?;
    write_end(text, report)
}

fn write_distances(text: &mut String, fit: &FitReport, share: Option<f64>, holds: bool) -> std::fmt::Result {
    writeln!(text, "  distance  rms {}  max {}", plain(fit.rms), plain(fit.max))?;
    if let Some(share) = share {
        let verdict = if holds { "reached" } else { "NOT reached" };
        let share = percent_of_share(share, Rounding::Down);
        writeln!(text, "  tolerance {verdict}: {share} of the points within")?;
    }
    Ok(())
}

fn write_folds(text: &mut String, folds: &Folds) -> std::fmt::Result {
    match folds.count() {
        0 => Ok(()),
        count => writeln!(text, "  folds     in {count} of {} cells", folds.cells),
    }
}

fn write_end(text: &mut String, report: &Report) -> std::fmt::Result {
    let timings = &report.timings;
    writeln!(
        text,
        "  seconds   read {:.3}  build {:.3}  compute {:.3}  write {:.3}",
        timings.read, timings.build, timings.compute, timings.write
    )?;
    for output in &report.outputs {
        writeln!(text, "  wrote     {} ({} bytes)", output.path.display(), output.bytes)?;
    }
    Ok(())
}

/// A number with six decimals, or with an exponent where these would hide it.
fn plain(value: f64) -> String {
    let size = value.abs();
    if size >= 1e9 || (size < 1e-3 && size > 0.0) { format!("{value:.6e}") } else { format!("{value:.6}") }
}
