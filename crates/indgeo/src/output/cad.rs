//! Shapes as CAD files: STEP and IGES, with their name and unit.

use crate::error::Error;
use crate::files;
use crate::report::wording::counted;
use industrial_geometry::cad::description::{LengthUnit, ModelDescription};
use industrial_geometry::cad::{ModelBuilder, to_iges, to_step};
use industrial_geometry::io::{Model, Shape};
use industrial_geometry::nurbs::BsplineCurve;
use industrial_geometry::nurbs::nalgebra::Vector3;
use std::path::Path;

/// A CAD format.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum CadFormat {
    /// ISO 10303-21.
    Step,
    /// IGES 5.3.
    Iges,
}

impl CadFormat {
    /// The format with a file name extension.
    pub(crate) fn from_extension(extension: &str) -> Option<Self> {
        match extension.to_ascii_lowercase().as_str() {
            "step" | "stp" => Some(Self::Step),
            "igs" | "iges" => Some(Self::Iges),
            _ => None,
        }
    }

    /// The format that the extension of a path names.
    pub(crate) fn of(path: &Path) -> Option<Self> {
        Self::from_extension(&files::extension(path))
    }

    /// Its usual extension.
    pub(crate) const fn extension(self) -> &'static str {
        match self {
            Self::Step => "step",
            Self::Iges => "igs",
        }
    }
}

/// What a shape is called, and what its numbers mean.
#[derive(Clone, Debug, Default, clap::Args)]
pub(crate) struct CadArgs {
    /// Name of the shape in the output [default: that in the input, or the name of the file]
    #[arg(long, value_name = "NAME")]
    pub(crate) name: Option<String>,
    /// Unit of length of the coordinates, which STEP and IGES state: mm, cm, m, km, um, inch or ft [default: that of the input, else mm]
    #[arg(long, value_name = "UNIT", value_parser = parse_unit)]
    pub(crate) unit: Option<LengthUnit>,
}

/// A unit by its name.
pub(crate) fn parse_unit(text: &str) -> Result<LengthUnit, String> {
    let metres = match text.trim().to_ascii_lowercase().as_str() {
        "mm" => 1e-3,
        "cm" => 1e-2,
        "m" => 1.0,
        "km" => 1e3,
        "um" | "µm" => 1e-6,
        "inch" | "in" => 0.0254,
        "ft" => 0.3048,
        _ => return Err("choose mm, cm, m, km, um, inch or ft".to_owned()),
    };
    let name = if text.trim().eq_ignore_ascii_case("in") { "inch" } else { text.trim() };
    Ok(LengthUnit { name: name.to_ascii_lowercase(), metres })
}

impl CadArgs {
    /// Makes sure that the options have an effect on the output, before any work is done.
    pub(crate) fn check(&self, out: Option<&Path>) -> Result<(), Error> {
        self.check_format(out.and_then(CadFormat::of).is_some())?;
        if self.name.is_some() && out.is_none() {
            return Err(Error::usage("--name has no effect without -o", "add -o, or leave it out"));
        }
        Ok(())
    }

    /// The same, where it is known whether the output is a CAD file.
    pub(crate) fn check_format(&self, is_cad: bool) -> Result<(), Error> {
        if self.unit.is_none() || is_cad {
            return Ok(());
        }
        let what = "--unit has no effect: only STEP and IGES files state a unit";
        Err(Error::usage(what, "leave it out, or call the output .step or .igs"))
    }

    /// The shapes of a model as faces and curves; curves in the plane lie in z = 0.
    pub(crate) fn describe(&self, model: &Model, path: &Path) -> Result<ModelDescription, Error> {
        let stem = path.file_stem().map(|stem| stem.to_string_lossy().into_owned()).unwrap_or_default();
        let single = match model.shapes() {
            [_] => model.name(0),
            _ => None,
        };
        let name = self.name.as_deref().or(single).unwrap_or(&stem);
        let mut builder = ModelBuilder::new(name, self.unit.clone());
        for (index, shape) in model.shapes().iter().enumerate() {
            let own = model.name(index).filter(|_| self.name.is_none() || model.shapes().len() > 1);
            let own = own.unwrap_or(name);
            match shape {
                Shape::Surface(surface) => match model.trim(index) {
                    Some(trim) => builder
                        .trimmed_surface(own, surface.clone(), trim)
                        .map_err(|error| refused(path, &error))?,
                    None => builder.surface(own, surface.clone()),
                },
                Shape::Curve3(curve) => builder.curve(own, curve.clone()),
                Shape::Curve2(curve) => {
                    let curve = in_space(curve);
                    let curve = curve.map_err(|error| refused(path, &error))?;
                    builder.curve(own, curve);
                }
            }
        }
        Ok(builder.finish())
    }

    /// The same model with the name that was typed.
    pub(crate) fn named(&self, model: Model) -> Model {
        match &self.name {
            Some(name) => model.renamed(name),
            None => model,
        }
    }
}

fn in_space(curve: &BsplineCurve<2>) -> Result<BsplineCurve<3>, industrial_geometry::nurbs::Error> {
    let points = curve.control_points().iter().map(|p| Vector3::new(p.x, p.y, 0.0)).collect();
    let weights = curve.weights().map(<[f64]>::to_vec);
    BsplineCurve::new(curve.knots().clone(), points, weights)
}

/// Writes a model and returns the number of bytes. One that has no unit is written in millimetres, which is said.
pub(crate) fn write(
    path: &Path,
    format: CadFormat,
    mut model: ModelDescription,
    warnings: &mut Vec<String>,
) -> Result<u64, Error> {
    if model.unit.is_none() {
        model.unit = Some(LengthUnit::millimetre());
        warnings
            .push("the unit of length is not known and was written as mm; --unit states another".to_owned());
    }
    let made = match format {
        CadFormat::Step => to_step(&model),
        CadFormat::Iges => to_iges(&model),
    };
    let bytes = made.map_err(|error| refused(path, &error))?;
    files::write(path, |out| out.write_all(&bytes))
}

fn refused(path: &Path, error: &dyn std::fmt::Display) -> Error {
    Error::content(path, error.to_string(), "check the model with `indgeo info`")
}

/// How many faces and curves a model has, in words.
pub(crate) fn describe_counts(model: &ModelDescription) -> String {
    let count = |of: fn(&industrial_geometry::cad::description::PartDescription) -> usize| -> usize {
        model.instances.iter().filter_map(|instance| model.parts.get(instance.part)).map(of).sum()
    };
    let (faces, curves) = (count(|part| part.faces.len()), count(|part| part.curves.len()));
    match (faces, curves) {
        (0, curves) => counted(curves, "curve"),
        (faces, 0) => counted(faces, "face"),
        (faces, curves) => format!("{} and {}", counted(faces, "face"), counted(curves, "curve")),
    }
}
