//! The summary of a parameterization.

use super::job::ParameterResults;
use super::patch::PatchResults;
use crate::fits::summary::write_coverage;
use crate::report::summary::{plain, write_end};
use crate::report::wording::counted;
use crate::report::{Report, Results};
use industrial_geometry::inspection::{Rounding, percent_of_share};
use std::fmt::Write;

impl Results for ParameterResults {
    fn summarise(&self, text: &mut String, report: &Report) -> std::fmt::Result {
        let results = self;
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
}

impl Results for PatchResults {
    fn summarise(&self, text: &mut String, report: &Report) -> std::fmt::Result {
        writeln!(
            text,
            "{} over a {} ({} metric): {}, {} without positive area",
            counted(self.triangles, "triangle"),
            self.domain,
            self.metric,
            counted(self.rows, "row"),
            self.folded
        )?;
        if let Some([a, b, c, d]) = self.corners {
            writeln!(text, "  corners   vertices {a}, {b}, {c}, {d}")?;
        }
        writeln!(text, "  boundary  length {}", plain(self.boundary_length))?;
        write_end(text, report)
    }
}
