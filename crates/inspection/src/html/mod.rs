//! One self-contained HTML page: a map of the deviations to turn and zoom, histogram, tables.
//!
//! The page needs no network, and its content security policy forbids any. It holds the report as JSON (element
//! `report`), the cells of its tables carry all digits (`data-value`), and names of files are escaped.

mod chart;
mod scene;
mod tables;
mod text;

use crate::{Backdrop, Inspection, Picture, Rounding, percent, percent_in_full};
use std::io::{self, Write};
pub use text::{escape, json_in_script, number};

const TEMPLATE: &str = include_str!("../../assets/report.html");
/// The style of the page, for other pages of the project.
pub const CSS: &str = include_str!("../../assets/report.css");
const SCRIPT: &str = include_str!("../../assets/report.js");
const THREE: &str = include_str!("../../assets/three.min.js");

/// What a page shows.
#[derive(Clone, Copy, Debug)]
pub struct Page<'a> {
    /// The heading.
    pub title: &'a str,
    /// Name of the file of the model.
    pub model: &'a str,
    /// Name of the file of the points.
    pub cloud: &'a str,
    /// Name and version of the program.
    pub program: &'a str,
    /// The result.
    pub inspection: &'a Inspection,
    /// The points, as they were inspected, with their deviations, or a sample of them.
    pub picture: &'a Picture,
    /// Triangles that show the model.
    pub backdrop: &'a Backdrop,
    /// The motion that was applied to the points, if any, as a matrix by rows.
    pub alignment: Option<[[f64; 4]; 4]>,
}

/// Writes the page.
///
/// # Errors
/// Those of `out`.
pub fn write(out: &mut dyn Write, page: &Page<'_>) -> io::Result<()> {
    let packed = scene::pack(page);
    let verdict = &page.inspection.verdict;
    let tolerance = &page.inspection.options.tolerance;
    let headline = format!(
        "<b>{}</b>: {} of {} points within {} … {}{}",
        percent(verdict.within, verdict.judged, Rounding::Down),
        verdict.within,
        verdict.judged,
        signed(tolerance.lower),
        signed(tolerance.upper),
        if verdict.min_share < 1.0 {
            format!(" (at least {} asked for)", percent_in_full(verdict.min_share))
        } else {
            String::new()
        }
    );
    let json = serde_json::to_string(page.inspection)?;
    let scene = serde_json::to_string(&packed.scene)?;
    let mut rest = TEMPLATE;
    while let Some((before, after)) = rest.split_once("{{") {
        let Some((key, after)) = after.split_once("}}") else { break };
        out.write_all(before.as_bytes())?;
        let text = match key {
            "title" => escape(page.title),
            "program" => escape(page.program),
            "css" => CSS.to_owned(),
            "verdict_class" => if verdict.pass { "pass" } else { "fail" }.to_owned(),
            "verdict" => if verdict.pass { "✓ PASS" } else { "✗ FAIL" }.to_owned(),
            "headline" => headline.clone(),
            "sentence" => escape(&format!("{} against {}", page.cloud, page.model)),
            "label" => escape(&format!("Map of the deviations of {} points", packed.shown)),
            "shown" => shown(page, &packed),
            "histogram" => chart::histogram(&page.inspection.total, tolerance),
            "statistics" => tables::statistics(page.inspection),
            "tables" => tables::below(page),
            "method" => tables::method(page),
            "report" => json_in_script(&json),
            "scene" => json_in_script(&scene),
            "blobs" => String::new(),
            "three" => THREE.to_owned(),
            "script" => SCRIPT.to_owned(),
            _ => String::new(),
        };
        out.write_all(text.as_bytes())?;
        if key == "blobs" {
            for (name, base64) in &packed.blobs {
                writeln!(out, "<script type=\"text/plain\" id=\"{name}\">{base64}</script>")?;
            }
        }
        rest = after;
    }
    out.write_all(rest.as_bytes())
}

fn signed(value: f64) -> String {
    if value > 0.0 { format!("+{}", number(value)) } else { number(value) }
}

fn shown(page: &Page<'_>, packed: &scene::Packed) -> String {
    let total = page.picture.points();
    let mut out = if packed.shown == total {
        format!("All {total} points are shown.")
    } else if packed.unchosen > 0 {
        format!("{} of {total} points are shown, chosen evenly; the tables count all.", packed.shown)
    } else {
        format!("{} of {total} points are shown.", packed.shown)
    };
    if packed.outside > 0 {
        let chosen = if packed.unchosen > 0 { " of those chosen" } else { "" };
        out.push_str(&format!(" {}{chosen} lie outside of the picture or nowhere.", packed.outside));
    }
    out.push_str(" Positions in the picture are rounded to 1/65535 of its size, deviations are not.");
    out
}
