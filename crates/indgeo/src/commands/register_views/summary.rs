//! The summary of a registration of many views.

use super::results::ViewsResults;
use crate::report::summary::{plain, write_end};
use crate::report::wording::counted;
use crate::report::{Report, Results};
use industrial_geometry::inspection::{Rounding, percent_of_share};
use std::fmt::Write;

impl Results for ViewsResults {
    fn summarise(&self, text: &mut String, report: &Report) -> std::fmt::Result {
        let found = self;
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
}
