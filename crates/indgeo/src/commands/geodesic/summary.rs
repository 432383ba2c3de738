//! The summary of geodesic distances and curves.

use super::job::GeodesicResults;
use crate::report::summary::{plain, write_end};
use crate::report::wording::counted;
use crate::report::{Report, Results};
use std::fmt::Write;

impl Results for GeodesicResults {
    fn summarise(&self, text: &mut String, report: &Report) -> std::fmt::Result {
        let found = self;
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
}
