//! CAD models: recognised, read, and described.

use crate::error::Error;
use crate::files;
use clap::ValueEnum;
use industrial_geometry::brep::description::{Carrier, FaceDescription, LengthUnit, ModelDescription};
use industrial_geometry::brep::{Foot, Model, On};
use industrial_geometry::cad::{is_iges, read_iges_file};
use serde_json::{Value, json};
use std::fs::File;
use std::io::Read;
use std::path::Path;
use std::sync::Arc;

/// Bytes from which the format is recognised.
const HEAD: u64 = 1024;

/// Ratios of the sizes of model and scan that come from a mistaken unit.
const UNIT_FACTORS: [(f64, &str); 2] = [(25.4, "inch and mm"), (1000.0, "m and mm")];

/// How far, as a factor, the ratio of two sizes may be away from one of [`UNIT_FACTORS`].
const UNIT_SLACK: f64 = 1.5;

/// A CAD file as read.
#[derive(Clone, Debug)]
pub(crate) struct CadModel {
    /// What answers queries.
    pub(crate) model: Arc<Model>,
    /// Name of the format.
    pub(crate) format: &'static str,
    /// What is to be known: entities that were left out.
    pub(crate) warnings: Vec<String>,
}

/// Which faces of a CAD model count, and its unit.
#[derive(Clone, Debug, Default, clap::Args)]
pub(crate) struct Choice {
    /// Faces of a CAD model that count, by name or entity number (#123), with commas between them; others are left out
    #[arg(long, value_name = "NAME|#ID", value_delimiter = ',')]
    faces: Vec<String>,
    /// Unit of length of a CAD file that states none
    #[arg(long, value_enum, value_name = "UNIT")]
    unit: Option<UnitChoice>,
}

/// A unit of length.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum UnitChoice {
    /// Millimetre
    Mm,
    /// Metre
    M,
    /// Inch, 25.4 mm
    Inch,
}

impl Choice {
    /// The choice as it is typed.
    pub(crate) fn arguments(&self) -> Vec<String> {
        let unit = self.unit.and_then(|unit| unit.to_possible_value());
        let unit = unit.map(|unit| format!("--unit={}", unit.get_name()));
        self.faces.iter().map(|face| format!("--faces={face}")).chain(unit).collect()
    }

    /// Makes sure that nothing was chosen, for a model that is no CAD model.
    pub(crate) fn check_unused(&self, path: &Path) -> Result<(), Error> {
        let option = match (self.faces.is_empty(), self.unit) {
            (false, _) => "--faces",
            (true, Some(_)) => "--unit",
            (true, None) => return Ok(()),
        };
        let what = format!("{option} is for CAD models, this is none");
        Err(Error::content(path, what, "leave the option out, or give a STEP or IGES file"))
    }

    /// Takes the choice over into what a file says.
    fn apply(&self, description: &mut ModelDescription, path: &Path) -> Result<(), Error> {
        if let Some(unit) = self.unit {
            let unit = match unit {
                UnitChoice::Mm => LengthUnit::millimetre(),
                UnitChoice::M => LengthUnit::metre(),
                UnitChoice::Inch => LengthUnit::inch(),
            };
            match &description.unit {
                Some(own) if *own != unit => {
                    let what =
                        format!("the file states its unit, {}, and --unit says {}", own.name, unit.name);
                    return Err(Error::content(path, what, "leave --unit out"));
                }
                _ => description.unit = Some(unit),
            }
        }
        if self.faces.is_empty() {
            return Ok(());
        }
        let is = |wanted: &String, face: &FaceDescription| {
            *wanted == face.name || *wanted == format!("#{}", face.source)
        };
        for wanted in &self.faces {
            if !description.parts.iter().flat_map(|p| &p.faces).any(|face| is(wanted, face)) {
                let what = format!("no face is called {wanted} or has this number");
                return Err(Error::content(path, what, "the results of `indgeo project` name the faces"));
            }
        }
        description.retain_faces(|_, face| self.faces.iter().any(|wanted| is(wanted, face)));
        Ok(())
    }
}

/// The format of a CAD file by its content. Standard input is none: it can be read once only.
fn recognised(path: &Path) -> Option<&'static str> {
    let mut head = Vec::new();
    let read = !files::is_stream(path)
        && File::open(path).is_ok_and(|file| file.take(HEAD).read_to_end(&mut head).is_ok());
    let text = head.strip_prefix(b"\xef\xbb\xbf").unwrap_or(&head).trim_ascii_start();
    match read {
        true if text.starts_with(b"ISO-10303-21") => Some("step"),
        true if is_iges(&head) => Some("iges"),
        _ => None,
    }
}

impl CadModel {
    /// Reads a CAD file; `None` for a file of another kind.
    pub(crate) fn read(path: &Path, choice: &Choice) -> Result<Option<Self>, Error> {
        let Some(format) = recognised(path) else {
            choice.check_unused(path)?;
            return Ok(None);
        };
        let mut description = if format == "step" { read_step(path)? } else { read_iges_file(path)? };
        choice.apply(&mut description, path)?;
        let model = Model::new(&description)
            .map_err(|error| Error::content(path, error.to_string(), "export the part again as solids"))?;
        let unread = model.unread();
        let mut warnings = Vec::new();
        if let Some(first) = unread.first() {
            warnings.push(format!(
                "{} of the file are left out, the first is #{} ({}): {}",
                crate::wording::counted(unread.len(), "geometric element"),
                first.source,
                first.kind,
                first.why
            ));
        }
        if model.unit().is_none() {
            warnings.push("the file states no unit of length".to_owned());
        }
        Ok(Some(Self { model: Arc::new(model), format, warnings }))
    }

    /// Number of faces of all instances.
    pub(crate) fn face_count(&self) -> usize {
        self.model.instances().iter().map(|i| self.model.parts()[i.part].faces().len()).sum()
    }

    /// Name of the unit of length.
    pub(crate) fn unit(&self) -> &str {
        self.model.unit().map_or("not stated", |unit| unit.name.as_str())
    }

    /// Kind and name of each face of all instances, in their order.
    pub(crate) fn shapes(&self) -> Vec<(&'static str, Option<String>)> {
        let mut out = Vec::new();
        for instance in self.model.instances() {
            let part = &self.model.parts()[instance.part];
            let owner = if instance.name.is_empty() { part.name() } else { &instance.name };
            out.extend(part.faces().iter().map(|face| {
                let number = format!("#{}", face.source());
                let name = match face.name() {
                    "" | "NONE" => number,
                    name => format!("{name} {number}"),
                };
                ("face", Some(if owner.is_empty() { name } else { format!("{owner}: {name}") }))
            }));
        }
        out
    }

    /// Number of a face among those of all instances.
    pub(crate) fn face_number(&self, foot: &Foot) -> Option<usize> {
        let before = &self.model.instances()[..foot.instance];
        let first: usize = before.iter().map(|i| self.model.parts()[i.part].faces().len()).sum();
        foot.face.map(|face| first + face)
    }

    /// What is said when the sizes of model and scan look like those of different units.
    pub(crate) fn unit_warning(&self, scan: f64) -> Option<String> {
        self.units().warning(scan)
    }

    /// The unit and the size of the model.
    pub(crate) fn units(&self) -> Units {
        Units { name: self.unit().to_owned(), diagonal: self.model.bounds().diagonal() }
    }

    /// The facts about the model, for `info`.
    pub(crate) fn describe(&self) -> Value {
        let model = &self.model;
        let mut kinds = std::collections::BTreeMap::<&str, usize>::new();
        for instance in model.instances() {
            for face in model.parts()[instance.part].faces() {
                *kinds.entry(kind(face.carrier())).or_default() += 1;
            }
        }
        let mut tolerances: Vec<f64> =
            model.parts().iter().flat_map(|p| p.edges()).map(|e| e.tolerance()).collect();
        tolerances.sort_by(f64::total_cmp);
        let share = |s: f64| {
            #[expect(clippy::cast_possible_truncation, reason = "a share of a count")]
            let at = (s * tolerances.len().saturating_sub(1) as f64).round() as usize;
            tolerances.get(at).copied()
        };
        let bounds = model.bounds();
        let (min, max): ([f64; 3], [f64; 3]) = (bounds.min.into(), bounds.max.into());
        let unread = model.unread().iter();
        let unread: Vec<_> =
            unread.map(|u| json!({ "entity": u.source, "type": u.kind, "reason": u.why })).collect();
        let shells = model.instances().iter().flat_map(|i| model.parts()[i.part].shells());
        json!({
            "format": self.format,
            "kind": "cad",
            "dimension": 3,
            "unit": model.unit().map(|u| u.name.clone()),
            "uncertainty": model.uncertainty(),
            "parts": model.parts().len(),
            "instances": model.instances().len(),
            "closed_shells": shells.clone().filter(|s| s.is_closed()).count(),
            "open_shells": shells.filter(|s| !s.is_closed()).count(),
            "faces": self.face_count(),
            "faces_by_kind": kinds,
            "edges": model.parts().iter().map(|p| p.edges().len()).sum::<usize>(),
            "edge_tolerance_max": share(1.0),
            "edge_tolerance_p99": share(0.99),
            "not_read": unread,
            "bounding_box": { "min": min, "max": max, "diagonal": bounds.diagonal() },
        })
    }
}

#[cfg(feature = "step")]
fn read_step(path: &Path) -> Result<ModelDescription, Error> {
    Ok(industrial_geometry::cad::read_step_file(path)?)
}

#[cfg(not(feature = "step"))]
fn read_step(path: &Path) -> Result<ModelDescription, Error> {
    Err(Error::content(
        path,
        "this is a STEP file, and this program was built without reading them",
        "build it with the feature `step`",
    ))
}

/// Where a foot lies, as a word.
pub(crate) fn location(foot: &Foot) -> &'static str {
    match foot.on {
        On::Face { .. } => "face",
        On::Edge { .. } => "edge",
        On::Vertex { .. } | On::Apex { .. } => "vertex",
    }
}

fn kind(carrier: &Carrier) -> &'static str {
    match carrier {
        Carrier::Plane { .. } => "plane",
        Carrier::Cylinder { .. } => "cylinder",
        Carrier::Cone { .. } => "cone",
        Carrier::Sphere { .. } => "sphere",
        Carrier::Torus { .. } => "torus",
        Carrier::Nurbs(surface) if surface.weights().is_some() => "rational_b_spline",
        Carrier::Nurbs(_) => "b_spline",
    }
}

/// The unit of a model and how large it is, for a comparison with a scan.
#[derive(Debug)]
pub(crate) struct Units {
    /// Name of the unit.
    pub(crate) name: String,
    /// Diagonal of the box around the model.
    diagonal: f64,
}

impl Units {
    /// What is said when the sizes of model and scan look like those of different units.
    pub(crate) fn warning(&self, scan: f64) -> Option<String> {
        let model = self.diagonal;
        let ratio = if scan > model { scan / model } else { model / scan };
        let (factor, units) = UNIT_FACTORS
            .into_iter()
            .find(|(factor, _)| ratio > factor / UNIT_SLACK && ratio < factor * UNIT_SLACK)?;
        Some(format!(
            "the model is {model:.6} {} across, the scan {scan:.6}: a ratio of {ratio:.1}, near the {factor} between \
             {units}; check the units",
            self.name
        ))
    }
}
