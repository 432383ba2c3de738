//! What was gathered of a cloud is judged, written and reported.

use super::gather::{Gathered, Kept, check_counts};
use super::nominal::Setup;
use super::results::InspectionResults;
use super::{Job, usage};
use crate::error::Error;
use crate::files;
use crate::output::{self, DeviationTable, Format, NAME, Rows};
use crate::report::wording::{counted, not_finite};
use crate::report::{Input, Output, ReadSummary, Report, Timings};
use industrial_geometry::inspection::html::{self, Page};
use industrial_geometry::inspection::{Backdrop, Inspection, Picture};
use std::io::BufWriter;
use std::path::{Path, PathBuf};

/// What is, or was, written per point.
pub(super) enum RowsOut<'a> {
    None,
    /// Points in memory, to be written.
    Kept(Box<Kept>, Format),
    /// A file that is written: its bytes and rows.
    Written(&'a Path, u64, usize),
}

/// Judges what was gathered, writes the files of the job, and fills in the report.
pub(super) fn conclude(
    job: &Job<'_>,
    setup: Setup,
    gathered: Gathered,
    rows: RowsOut<'_>,
    mut timings: Timings,
    report: &mut Report,
) -> Result<Inspection, Error> {
    add_inputs(job, &setup, &gathered, report)?;
    let found = gathered.found.finish(&setup.options, setup.nominal.shapes());
    let mut found = found.map_err(|error| usage(&error))?;
    for worst in &mut found.worst {
        worst.name = gathered.names.get(&worst.index).cloned();
    }
    super::warnings::warn_of_unproven(report, job, &found);
    report.points_per_second =
        (timings.compute > 0.0).then(|| gathered.found.points() as f64 / timings.compute);
    let mut write = timings.write;
    Timings::measure(&mut write, || -> Result<(), Error> {
        match (rows, job.out) {
            (RowsOut::Kept(kept, format), Some(path)) => write_rows(path, &kept, format, &setup, report)?,
            (RowsOut::Written(path, bytes, rows), _) => {
                let columns = setup.table(&[], None, &[]).names();
                let content = format!("{}: {}", counted(rows, "row"), columns.join(","));
                report.add_output(Output { path: path.to_path_buf(), bytes, content });
            }
            _ => {}
        }
        if let Some((path, picture)) = job.page.zip(gathered.picture.as_ref()) {
            write_page(path, job, picture, &found, &setup.nominal.backdrop(), report)?;
        }
        Ok(())
    })?;
    timings.write = write;
    report.timings = timings;
    let dropped = gathered.tiles.iter().map(|(_, counts)| counts.non_finite).sum();
    let results = InspectionResults::new(found.clone(), dropped);
    report.results = Some(Box::new(results));
    Ok(found)
}

/// Tells of the files that were read, and what the readers said.
pub(super) fn add_inputs(
    job: &Job<'_>,
    setup: &Setup,
    gathered: &Gathered,
    report: &mut Report,
) -> Result<(), Error> {
    let named = |path: &Path, warning: &String| format!("{}: {warning}", path.display());
    report.warnings.extend(setup.of_model.iter().map(|warning| named(job.model, warning)));
    for (path, counts) in &gathered.tiles {
        // A range may hold nothing of use; the file it is a part of may not.
        if job.range.is_none() {
            check_counts(path, counts)?;
        }
        let read = ReadSummary {
            format: counts.format.clone(),
            points_read: counts.points,
            points_dropped: counts.non_finite,
            points_used: 0,
            non_finite: counts.non_finite,
            triangles: counts.triangles,
            shapes: counts.shapes,
        };
        let mut input = Input { role: "points", path: path.clone(), read };
        input.count(counts.non_finite, usize::try_from(counts.used).unwrap_or(usize::MAX));
        report.add_input(input);
        report.warnings.extend(counts.warnings.iter().map(|warning| named(path, warning)));
        if counts.non_finite > 0 {
            let warning = not_finite(path, counts.non_finite, counts.points, "counted, not used");
            report.warnings.push(warning);
        }
    }
    let diagonal = gathered.bounds.map_or(0.0, |bounds| bounds.diagonal());
    let of_units = setup.units.as_ref().and_then(|units| units.warning(diagonal));
    if gathered.told.is_some() {
        report.told.extend(of_units.clone());
    }
    report.warnings.extend(of_units);
    report.warnings.extend(setup.of_build.iter().cloned());
    Ok(())
}

fn write_rows(
    path: &Path,
    kept: &Kept,
    format: Format,
    setup: &Setup,
    report: &mut Report,
) -> Result<(), Error> {
    let points = &kept.points;
    let table = DeviationTable {
        point_names: points.names.as_ref(),
        triangles: &points.triangles,
        ..setup.table(&points.positions, points.normals.as_deref(), &kept.records)
    };
    let written = output::write(path, format, &table)?;
    report.warnings.extend(written.warnings);
    let columns: Vec<&str> = table.names().into_iter().chain(points.names.as_ref().map(|_| NAME)).collect();
    let content = format!("{}: {}", counted(kept.records.len(), "row"), columns.join(","));
    report.add_output(Output { path: path.to_path_buf(), bytes: written.bytes, content });
    Ok(())
}

fn write_page(
    path: &Path,
    job: &Job<'_>,
    picture: &Picture,
    found: &Inspection,
    backdrop: &Backdrop,
    report: &mut Report,
) -> Result<(), Error> {
    let name = |path: &Path| path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned();
    let cloud = match job.points.iter().min() {
        Some(first) if job.points.len() == 1 => name(first),
        _ => job.cloud(),
    };
    // Which units the lengths of the page have.
    let unit = report.model.as_ref().and_then(|model| model.unit.clone());
    let in_unit = |name: &str, how: &str| match &unit {
        Some(unit) => format!("{name} ({how}{unit})"),
        None => name.to_owned(),
    };
    let page = Page {
        title: &format!("Inspection of {cloud}"),
        model: &in_unit(&name(job.model), "unit: "),
        cloud: &in_unit(&cloud, "states no unit, taken as "),
        program: concat!("indgeo ", env!("CARGO_PKG_VERSION")),
        inspection: found,
        picture,
        backdrop,
        alignment: report.options.as_ref().and_then(|options| options.transform),
    };
    let bytes = files::write(path, |out| html::write(&mut BufWriter::new(out), &page))?;
    let content = "page: map of the deviations, histogram, tables".to_owned();
    report.add_output(Output { path: PathBuf::from(path), bytes, content });
    Ok(())
}
