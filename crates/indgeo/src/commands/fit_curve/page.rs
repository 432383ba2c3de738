//! The page of a fit of curves.

use super::results::CurveResults;
use super::tables::feet_of;
use crate::error::Error;
use crate::fits::numbers::FitVerdict;
use crate::fits::page::{CurveSections, FitPage, curve_sections};
use crate::report::Report;
use crate::report::wording::counted;
use industrial_geometry::fit::curve::{CurvePart, CurveReport};
use industrial_geometry::inspection::html::number;
use industrial_geometry::inspection::{Rounding, percent_of_share};
use industrial_geometry::nurbs::nalgebra::SVector;
use std::path::Path;

/// Writes it.
pub(super) fn put<const D: usize>(
    source: &Path,
    path: &Path,
    (points, found): (&[SVector<f64, D>], &[CurvePart<D>]),
    results: &CurveResults,
    verdict: FitVerdict,
    report: &mut Report,
) -> Result<(), Error> {
    let fitted = &results.fitted;
    let feet = feet_of(points.len(), found);
    let distances: Vec<f64> =
        feet.into_iter().map(|foot| foot.map_or(f64::NAN, |(foot, _)| foot.distance)).collect();
    let pictures = curve_sections(&CurveSections {
        curves: found.iter().map(|part| &part.fit.curve).collect(),
        points,
        distances: &distances,
        tolerance: fitted.tolerance,
        max: fitted.max,
    });
    let shape = if found.len() == 1 {
        "B-spline curve".to_owned()
    } else {
        format!("{} B-spline curves", found.len())
    };
    let page = FitPage {
        source,
        shape: format!("{shape} with {}", counted(fitted.controls, "control point")),
        verdict,
        rms: fitted.rms,
        max: fitted.max,
        used: fitted.used,
        pictures,
        facts: facts(fitted),
        history: &fitted.history,
    };
    page.write(path, results, report)
}

fn facts(fitted: &CurveReport) -> Vec<(String, String)> {
    let coverage = &fitted.coverage;
    let without = percent_of_share(coverage.length_without_data / coverage.length, Rounding::Up);
    let mut rows = vec![
        ("curve", if fitted.closed { "closed" } else { "open" }.to_owned()),
        ("degree", fitted.degree.to_string()),
        ("control points", fitted.controls.to_string()),
        ("iteration", format!("{} after {} steps", fitted.status, fitted.iterations)),
        ("points that count", format!("{} of {}", fitted.used, fitted.points)),
        ("rms", number(fitted.rms)),
        ("largest distance", number(fitted.max)),
        ("factor of the energy", number(fitted.lambda)),
        ("curve to points, rms", number(coverage.rms)),
        (
            "curve to points, largest",
            format!("{} ({:.1} spacings)", number(coverage.max), coverage.max_in_spacings),
        ),
        ("length", number(coverage.length)),
        ("length without data", without),
        ("crosses itself", counted(fitted.crossings.len(), "time")),
    ];
    if let (Some(tolerance), Some(share)) = (fitted.tolerance, fitted.share_within) {
        rows.push(("tolerance", number(tolerance)));
        rows.push(("points within it", percent_of_share(share, Rounding::Down)));
    }
    rows.into_iter().map(|(name, value)| (name.to_owned(), value)).collect()
}
