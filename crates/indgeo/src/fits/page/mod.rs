//! One self-contained HTML page of a fit: the shape, the points by their distance from it, how smooth it is, and the history.

mod bands;
mod curve;
mod history;
mod surface;

pub(crate) use curve::{CurveSections, curve_sections};
pub(crate) use surface::{IsoCurves, SurfaceSections, mesh_sections, surface_sections};

use super::numbers::{FitNumbers, FitVerdict};
use crate::error::Error;
use crate::files;
use crate::output::html::{HtmlPage, section, table};
use crate::report::{Output, Report};
use industrial_geometry::fit::{FitStep, Folds, SurfaceCoverage};
use industrial_geometry::inspection::html::{escape, number};
use industrial_geometry::inspection::{Rounding, percent_of_share};
use serde::Serialize;
use std::path::Path;

/// Most points in a picture.
const SHOWN: usize = 4000;

/// What a page shows besides the warnings of the report.
pub(crate) struct FitPage<'a> {
    /// The points or the model.
    pub(crate) source: &'a Path,
    /// What was fitted, as `B-spline surface`.
    pub(crate) shape: String,
    pub(crate) verdict: FitVerdict,
    pub(crate) rms: f64,
    pub(crate) max: f64,
    pub(crate) used: usize,
    /// Sections with pictures, as markup.
    pub(crate) pictures: String,
    /// Rows of the table of the result.
    pub(crate) facts: Vec<(String, String)>,
    pub(crate) history: &'a [FitStep],
}

impl FitPage<'_> {
    /// Writes it, with the results as they are in the report.
    pub(crate) fn write(
        &self,
        path: &Path,
        results: &impl Serialize,
        report: &mut Report,
    ) -> Result<(), Error> {
        let name = self.source.file_name().unwrap_or(self.source.as_os_str()).to_string_lossy();
        let word = match self.verdict {
            FitVerdict::Good => "AS ASKED FOR",
            FitVerdict::OutOfTolerance => "OUT OF TOLERANCE",
            FitVerdict::NotConverged => "NOT CONVERGED",
            FitVerdict::Defective => "NOT TO BE TRUSTED",
        };
        let warnings: String =
            report.warnings.iter().map(|warning| format!("<li>{}</li>\n", escape(warning))).collect();
        let mut right = section("Result", &table(&self.facts));
        if !warnings.is_empty() {
            right += &section("Warnings", &format!("<ul>\n{warnings}</ul>\n"));
        }
        if !self.history.is_empty() {
            right += &section("History", &history::chart(self.history));
        }
        let broken = |error: serde_json::Error| {
            Error::content(path, error.to_string(), "leave out --report, and use --json")
        };
        let page = HtmlPage {
            title: format!("Fit of {name}"),
            verdict: (self.verdict == FitVerdict::Good, word.to_owned()),
            headline: format!(
                "rms {}, largest distance {}, {} points count",
                number(self.rms),
                number(self.max),
                self.used
            ),
            sentence: format!("{} to {name}", self.shape),
            left: self.pictures.clone(),
            right,
            json: serde_json::to_string(results).map_err(broken)?,
        };
        let bytes = files::write(path, |out| page.write(out))?;
        report.add_output(Output { path: path.to_path_buf(), bytes, content: "page".to_owned() });
        Ok(())
    }
}

/// Makes sure that the page has the extension of one.
pub(crate) fn check(path: Option<&Path>) -> Result<(), Error> {
    match path {
        Some(path) if !is_page(path) => {
            Err(Error::content(path, "reports are pages", "choose a name that ends in .html"))
        }
        _ => Ok(()),
    }
}

/// Whether a name is that of a page.
pub(crate) fn is_page(path: &Path) -> bool {
    matches!(files::extension(path).as_str(), "html" | "htm")
}

/// Rows about the iteration and the distances.
pub(crate) fn number_facts(fit: &FitNumbers) -> Vec<(String, String)> {
    let mut rows = vec![
        ("iteration".to_owned(), format!("{} after {} steps", fit.status, fit.iterations)),
        ("points that count".to_owned(), format!("{} of {}", fit.points_used, fit.points)),
        ("rms at the start".to_owned(), number(fit.initial_rms)),
        ("rms".to_owned(), number(fit.rms)),
        ("largest distance".to_owned(), number(fit.max)),
        ("factor of the energy".to_owned(), number(fit.lambda)),
    ];
    if let (Some(tolerance), Some(share)) = (fit.tolerance, fit.share_within) {
        let share = percent_of_share(share, Rounding::Down);
        rows.push((format!("points within {}", number(tolerance)), share));
    }
    rows
}

/// Rows about the other direction.
pub(crate) fn coverage_facts(
    coverage: Option<&SurfaceCoverage>,
    folds: Option<&Folds>,
) -> Vec<(String, String)> {
    let mut rows = Vec::new();
    if let Some(found) = coverage {
        let share = percent_of_share(found.area_without_data / found.area, Rounding::Up);
        rows.push(("surface to points, rms".to_owned(), number(found.rms)));
        rows.push((
            "surface to points, largest".to_owned(),
            format!("{} ({:.1} spacings)", number(found.max), found.max_in_spacings),
        ));
        rows.push(("area".to_owned(), number(found.area)));
        rows.push(("area without data".to_owned(), share));
    }
    if let Some(folds) = folds {
        rows.push(("cells with folds".to_owned(), format!("{} of {}", folds.count(), folds.cells)));
    }
    rows
}
