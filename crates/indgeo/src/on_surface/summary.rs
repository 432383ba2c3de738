//! What distances, curves and regions on surfaces say to a person.

use super::geodesic::GeodesicResults;
use super::morphology::MorphologyResults;
use super::parameters::PatchResults;
use crate::report::Report;
use crate::summary::{plain, write_end};
use crate::wording::counted;
use std::fmt::Write;

pub(crate) fn write_geodesic(
    text: &mut String,
    report: &Report,
    found: &GeodesicResults,
) -> std::fmt::Result {
    if let (Some(vertices), Some(unreachable)) = (found.vertices, found.unreachable) {
        let max = found.max.map_or_else(|| "none".to_owned(), plain);
        writeln!(
            text,
            "distances of {} ({} metric, {}), largest {max}",
            counted(vertices, "vertex"),
            found.metric,
            found.method
        )?;
        if unreachable > 0 {
            writeln!(text, "  no way leads to {}", counted(unreachable, "vertex"))?;
        }
    }
    for path in &found.paths {
        match path.length {
            Some(length) => {
                let kind = if path.is_geodesic { "" } else { ", not locally shortest" };
                writeln!(
                    text,
                    "  curve     length {}, {}{kind}",
                    plain(length),
                    counted(path.points.len(), "point")
                )?;
            }
            None => writeln!(text, "  curve     none: no way leads there")?,
        }
    }
    write_end(text, report)
}

pub(crate) fn write_morphology(
    text: &mut String,
    report: &Report,
    found: &MorphologyResults,
) -> std::fmt::Result {
    writeln!(
        text,
        "{} by {} in the {} metric: {}",
        found.operation,
        found.radius,
        found.metric,
        counted(found.regions.len(), "region")
    )?;
    for region in &found.regions {
        writeln!(
            text,
            "  region    {}: {} before, {} after",
            region.label,
            counted(region.vertices_before, "vertex"),
            region.vertices_after
        )?;
    }
    write_end(text, report)
}

pub(crate) fn write_patch(text: &mut String, report: &Report, found: &PatchResults) -> std::fmt::Result {
    writeln!(
        text,
        "{} over a {} ({} metric): {}, {} without positive area",
        counted(found.triangles, "triangle"),
        found.domain,
        found.metric,
        counted(found.rows, "row"),
        found.folded
    )?;
    if let Some([a, b, c, d]) = found.corners {
        writeln!(text, "  corners   vertices {a}, {b}, {c}, {d}")?;
    }
    writeln!(text, "  boundary  length {}", plain(found.boundary_length))?;
    write_end(text, report)
}
