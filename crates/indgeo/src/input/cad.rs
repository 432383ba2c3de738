//! CAD models: recognised, read, and described.

use crate::error::Error;
use crate::files;
use crate::runtime::memory;
use clap::ValueEnum;
use industrial_geometry::brep::description::{Carrier, FaceDescription, LengthUnit, ModelDescription};
use industrial_geometry::brep::{Foot, Model, On};
use industrial_geometry::cad::{is_iges, read_iges};
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::fs::File;
use std::io::Read;
use std::path::Path;
use std::sync::Arc;

/// Bytes from which the format is recognised.
const HEAD: u64 = 4096;
const HEAD_BYTES: usize = 4096;

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

/// The format of a CAD file by its content.
fn recognised(path: &Path) -> Result<Option<&'static str>, Error> {
    let mut head = Vec::new();
    if let Some(bytes) = files::stream(path)? {
        head.extend(bytes.iter().take(HEAD_BYTES));
    } else if memory::read(path, |bytes, _| head.extend(bytes.iter().take(HEAD_BYTES))).is_none() {
        // What cannot be opened is told by who reads it.
        let _ = File::open(path).and_then(|file| file.take(HEAD).read_to_end(&mut head));
    }
    let text = head.strip_prefix(b"\xef\xbb\xbf").unwrap_or(&head).trim_ascii_start();
    Ok(if text.starts_with(b"ISO-10303-21") {
        Some("step")
    } else if is_iges(&head) {
        Some("iges")
    } else {
        None
    })
}

impl CadModel {
    /// Reads a CAD file; `None` for a file of another kind.
    pub(crate) fn read(path: &Path, choice: &Choice) -> Result<Option<Self>, Error> {
        let Some(format) = recognised(path)? else {
            choice.check_unused(path)?;
            return Ok(None);
        };
        let bytes = files::read_bytes(path)?;
        let read = if format == "step" { read_step(&bytes, path)? } else { read_iges(&bytes) };
        drop(bytes);
        let mut description = read.map_err(|error| Error::cad(error, files::spoken(path)))?;
        choice.apply(&mut description, path)?;
        let model = Model::new(&description)
            .map_err(|error| Error::content(path, error.to_string(), "export the part again as solids"))?;
        let unread = model.unread();
        let mut warnings = Vec::new();
        if let Some(first) = unread.first() {
            warnings.push(format!(
                "{} of the file are left out, the first is #{} ({}): {}",
                crate::report::wording::counted(unread.len(), "geometric element"),
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

    /// Number in the file of the face or edge that holds a foot.
    pub(crate) fn entity(&self, foot: &Foot) -> Option<u64> {
        let part = &self.model.parts()[self.model.instances().get(foot.instance)?.part];
        match foot.on {
            On::Face { face, .. } | On::Apex { face } => part.faces().get(face).map(|face| face.source()),
            On::Edge { edge, .. } | On::Vertex { edge, .. } => {
                part.edges().get(edge).map(|edge| edge.source())
            }
        }
    }

    /// What is said when the sizes of model and scan look like those of different units.
    pub(crate) fn unit_warning(&self, scan: f64) -> Option<String> {
        self.units().warning(scan)
    }

    /// The unit in which points beside the model are taken.
    pub(crate) fn points_unit(&self) -> String {
        self.units().of_points()
    }

    /// The unit and the size of the model.
    pub(crate) fn units(&self) -> Units {
        Units { name: self.unit().to_owned(), diagonal: self.model.bounds().diagonal() }
    }

    /// The facts about the model, for `info`.
    pub(crate) fn describe(&self) -> Value {
        let model = &self.model;
        let mut kinds = BTreeMap::<&str, usize>::new();
        // What they are in the file counts, not the B-splines that they became.
        let swept: BTreeMap<u64, &str> = model.converted().iter().map(|c| (c.face, c.kind)).collect();
        for instance in model.instances() {
            for face in model.parts()[instance.part].faces() {
                let own = swept.get(&face.source()).copied();
                let own = own.filter(|_| matches!(face.carrier(), Carrier::Nurbs(_)));
                *kinds.entry(own.unwrap_or_else(|| kind(face.carrier()))).or_default() += 1;
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
            "part_list": self.part_list(),
            "tolerances": self.tolerances(),
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

impl CadModel {
    /// Each part with its name, how often it stands in the model, and what it holds.
    fn part_list(&self) -> Vec<Value> {
        let model = &self.model;
        let described = model.parts().iter().enumerate().map(|(index, part)| {
            let instances = model.instances().iter().filter(|instance| instance.part == index).count();
            json!({
                "name": part.name(),
                "instances": instances,
                "closed_shells": part.shells().iter().filter(|shell| shell.is_closed()).count(),
                "faces": part.faces().len(),
            })
        });
        described.collect()
    }

    /// Tolerances and dimensions of the file, with the faces of which they are stated.
    fn tolerances(&self) -> Vec<Value> {
        let faces = self.model.parts().iter().flat_map(|part| part.faces());
        let names: BTreeMap<u64, &str> = faces.map(|face| (face.source(), face.name())).collect();
        let called = |number: &u64| match names.get(number) {
            None | Some(&("" | "NONE")) => format!("#{number}"),
            Some(name) => format!("{name} #{number}"),
        };
        // JSON knows no infinite numbers.
        let finite = |value: f64| value.is_finite().then_some(value);
        let stated = self.model.tolerances().iter().map(|stated| {
            json!({
                "entity": stated.source,
                "kind": stated.kind,
                "name": stated.name,
                "value": stated.value,
                "lower": stated.limits.and_then(|limits| finite(limits[0])),
                "upper": stated.limits.and_then(|limits| finite(limits[1])),
                "fit": stated.fit,
                "datums": stated.datums,
                "modifiers": stated.modifiers,
                "faces": stated.faces.iter().map(called).collect::<Vec<_>>(),
                "other_entities": stated.others,
            })
        });
        stated.collect()
    }
}

#[cfg(feature = "step")]
#[expect(clippy::unnecessary_wraps, reason = "without the feature it is an error")]
fn read_step(
    bytes: &[u8],
    _path: &Path,
) -> Result<Result<ModelDescription, industrial_geometry::cad::Error>, Error> {
    Ok(industrial_geometry::cad::read_step(bytes))
}

#[cfg(not(feature = "step"))]
fn read_step(
    _bytes: &[u8],
    path: &Path,
) -> Result<Result<ModelDescription, industrial_geometry::cad::Error>, Error> {
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
    /// The unit in which points beside the model are taken.
    pub(crate) fn of_points(&self) -> String {
        format!("{}, taken as that of the model: the file of the points states none", self.name)
    }

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
