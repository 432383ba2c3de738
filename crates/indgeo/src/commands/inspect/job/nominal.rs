//! What is measured from: the model, its options, and what is to be said about both.

use super::{Job, usage};
use crate::error::Error;
use crate::input::cad::Units;
use crate::input::model::{Loaded, Model};
use crate::input::transform::Transform;
use crate::output::{DeviationTable, Format, Measured};
use crate::report::wording::counted;
use crate::report::{ModelSummary, Options, Report, Timings};
use industrial_geometry::inspection::{Along, DeviationRecord, InspectionOptions, Nominal};
use industrial_geometry::mesh::nalgebra::{Point3, Vector3};
use std::f64::consts::FRAC_PI_2;

/// The model and the options, ready to measure.
pub(crate) struct Setup {
    /// The shape that deviations are measured from.
    pub(crate) nominal: Nominal,
    /// Options, with what follows from the model.
    pub(crate) options: InspectionOptions,
    /// What of the model is measured from.
    pub(crate) measured: Measured,
    /// Units of a CAD model.
    pub(crate) units: Option<Units>,
    /// How the points are moved first.
    pub(crate) transform: Option<Transform>,
    /// Whether rows have colours, for formats that show them.
    pub(super) coloured: bool,
    /// What is to be said about the model.
    pub(super) of_model: Vec<String>,
    /// What is to be said about its preparation.
    pub(super) of_build: Vec<String>,
}

impl Setup {
    /// Reads and prepares the model, and describes it in the report.
    pub(super) fn read(job: &Job<'_>, timings: &mut Timings, report: &mut Report) -> Result<Self, Error> {
        let loaded = Timings::measure(&mut timings.read, || Loaded::read(job.model, job.cad))?;
        report.add_input(loaded.input(job.model));
        let transform = job.motion.transform()?;
        let measured = measured(&loaded.model);
        let units = match &loaded.model {
            Model::Cad(cad) => Some(cad.units()),
            _ => None,
        };
        let of_model = loaded.report.warnings.clone();
        let mut of_build = Vec::new();
        let nominal = Timings::measure(&mut timings.build, || build(loaded, job, &mut of_build))?;
        let options = options(job, &nominal);
        options.validate().map_err(|error| usage(&error))?;
        describe(job, &nominal, measured, units.as_ref(), transform.as_ref(), report);
        let format = job.out.map(|out| Format::of(out, job.format)).transpose()?;
        let coloured = format.is_some_and(Format::has_colours);
        Ok(Self { nominal, options, measured, units, transform, coloured, of_model, of_build })
    }

    /// Rows of points that were measured.
    pub(super) fn table<'a>(
        &'a self,
        points: &'a [Point3<f64>],
        normals: Option<&'a [Vector3<f64>]>,
        records: &'a [DeviationRecord],
    ) -> DeviationTable<'a> {
        DeviationTable {
            points,
            normals,
            point_names: None,
            records,
            triangles: &[],
            nominal: &self.nominal,
            options: &self.options,
            model: self.measured,
            coloured: self.coloured,
        }
    }
}

/// The options of the library, with what follows from the model.
fn options(job: &Job<'_>, nominal: &Nominal) -> InspectionOptions {
    let options = job.options;
    if options.along == Along::Normal && options.max_angle.is_none() && nominal.is_signed() {
        return options.with_max_angle(FRAC_PI_2);
    }
    options
}

/// Describes model and options in the report.
fn describe(
    job: &Job<'_>,
    nominal: &Nominal,
    measured: Measured,
    units: Option<&Units>,
    transform: Option<&Transform>,
    report: &mut Report,
) {
    report.model = Some(ModelSummary {
        kind: match measured {
            Measured::Mesh => "mesh",
            _ if units.is_some() => "cad",
            _ => "nurbs",
        },
        unit: units.map(|units| units.name.clone()),
        points_unit: units.map(Units::of_points),
        dimension: if measured == Measured::Profile { 2 } else { 3 },
        shapes: nominal.shapes().len(),
        patches: nominal.piece_count(),
        signed: nominal.is_signed(),
    });
    report.options = Some(Options {
        mode: job.mode,
        relative_gap: job.options.projection.relative_gap,
        threads: job.threads,
        transform: transform.map(Transform::rows),
    });
}

/// What the deviations from a model are measured from: its surfaces if it has some, otherwise its curves.
fn measured(model: &Model) -> Measured {
    match model {
        Model::Plane(_) => Measured::Profile,
        Model::Space { surfaces, .. } if surfaces.shapes.is_empty() => Measured::Curves,
        Model::Space { .. } | Model::Cad(_) => Measured::Surfaces,
        Model::Mesh(_) | Model::LevelSet(_) => Measured::Mesh,
    }
}

/// The nominal shape; curves beside surfaces are left out with a warning.
fn build(loaded: Loaded, job: &Job<'_>, warnings: &mut Vec<String>) -> Result<Nominal, Error> {
    let name = |index: usize| loaded.shapes.get(index).and_then(|shape| shape.1.clone());
    let names =
        |indices: &[u32]| indices.iter().map(|&index| name(index as usize)).collect::<Vec<Option<String>>>();
    let nominal = match loaded.model {
        Model::Plane(curves) => {
            let names: Vec<_> = (0..curves.len()).map(name).collect();
            Nominal::from_profile(curves).map(|nominal| nominal.with_names(names))
        }
        Model::Space { surfaces, curves } if surfaces.shapes.is_empty() => {
            let names = names(&curves.indices);
            Nominal::from_curves(curves.shapes).map(|nominal| nominal.with_names(names))
        }
        Model::Space { surfaces, curves } => {
            if !curves.shapes.is_empty() {
                warnings.push(format!(
                    "{}: {} left out, deviations are measured from surfaces; surfaces are numbered without curves",
                    job.model.display(),
                    counted(curves.shapes.len(), "curve")
                ));
            }
            let names = names(&surfaces.indices);
            Nominal::from_surfaces(surfaces.shapes).map(|nominal| nominal.with_names(names))
        }
        Model::Mesh(mesh) => Nominal::from_mesh(&mesh),
        Model::Cad(cad) => Nominal::from_brep(cad.model),
        Model::LevelSet(_) => {
            let what = "a grid of distances is no nominal shape: its distances have no proof";
            let advice = "make a mesh of it (`indgeo contour FIELD.vti -o MESH.ply`) and give that";
            return Err(Error::content(job.model, what, advice));
        }
    };
    let nominal = nominal
        .map_err(|error| Error::content(job.model, error.to_string(), "check it with `indgeo info`"))?;
    if !nominal.is_signed() && nominal.shapes().iter().all(|shape| shape.kind == "mesh") {
        warnings.push(format!(
            "{}: neighbouring triangles disagree on the side of their normals, so distances have no sign",
            job.model.display()
        ));
    }
    Ok(nominal)
}
