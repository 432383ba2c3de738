//! NURBS JSON, both ways.
//!
//! A file holds one curve, one surface, or `{"kind":"model","shapes":[…]}`; see [`nurbs_core`] for the fields of a
//! shape, and `docs/nurbs-json.md`. Each may have a `name`. Fields that are not known are passed over. Files of geomdl
//! are read as well.

mod geomdl;

use std::io::{self, Write};

use nurbs_core::{BsplineCurve, BsplineSurface, TrimLoops};
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use serde_json::value::RawValue;

use crate::error::Place;
use crate::model::{Model, Shape};
use crate::parsed::Parsed;
use crate::source::Source;
use crate::{Error, Format};

const EXPORT: &str = "correct the file or export it again";

/// What has to be known before the fields of a shape can be read.
#[derive(Deserialize)]
struct Head<'a> {
    kind: Option<String>,
    name: Option<String>,
    dim: Option<usize>,
    #[serde(borrow)]
    control_points: Option<&'a RawValue>,
    #[serde(borrow)]
    shapes: Option<Vec<&'a RawValue>>,
    #[serde(borrow)]
    trim: Option<&'a RawValue>,
}

/// Reads a model.
pub(crate) fn read(source: Source<'_>) -> Result<Parsed, Error> {
    let text = std::str::from_utf8(source.data).map_err(|error| {
        Error::malformed(Place::Byte(error.valid_up_to()), "the text is not UTF-8, as JSON has to be", EXPORT)
    })?;
    let part = Part { source, text, offset: 0, shape: None };
    let mut warnings = Vec::new();
    let head = part.parse_head()?;
    let mut model = Model::default();
    match head.kind.as_deref() {
        None => match geomdl::read(&part, &mut warnings)? {
            Some(found) => model = found,
            None => return Err(geomdl::unknown(&part)),
        },
        Some("model") => {
            let shapes = head.shapes.ok_or_else(|| part.error(0, "a model needs the field \"shapes\""))?;
            for (index, raw) in shapes.into_iter().enumerate() {
                let part = part.within(raw, Some(index));
                part.read_shape(part.parse_head()?, &mut model)?;
            }
        }
        Some(_) => part.read_shape(head, &mut model)?,
    }
    Ok(Parsed::model(Format::Json, model, warnings))
}

/// A JSON value within the file.
struct Part<'a> {
    source: Source<'a>,
    text: &'a str,
    offset: usize,
    /// Its place among the shapes of a model.
    shape: Option<usize>,
}

impl<'a> Part<'a> {
    /// A value of this one.
    fn within<'b>(&self, raw: &'b RawValue, shape: Option<usize>) -> Part<'b>
    where
        'a: 'b,
    {
        // A raw value is a part of the text, not a copy.
        let offset = self.offset + (raw.get().as_ptr() as usize - self.text.as_ptr() as usize);
        Part { source: self.source, text: raw.get(), offset, shape: shape.or(self.shape) }
    }

    fn read_shape(&self, head: Head<'_>, model: &mut Model) -> Result<(), Error> {
        let kind = head.kind.ok_or_else(|| self.error(0, "the field \"kind\" is missing"))?;
        match kind.as_str() {
            "surface" => {
                let surface = self.parse_owned::<BsplineSurface>()?;
                let trim = head.trim.map(|raw| self.within(raw, None).read_trim(&surface)).transpose()?;
                model.push_trimmed(surface, trim, head.name);
            }
            "curve" => match head.dim.or_else(|| first_length(head.control_points?)) {
                Some(2) => model.push(self.parse_owned::<BsplineCurve<2>>()?, head.name),
                Some(3) => model.push(self.parse_owned::<BsplineCurve<3>>()?, head.name),
                Some(other) => {
                    return Err(self.error(0, &format!("the dimension of a curve is 2 or 3, not {other}")));
                }
                None => {
                    return Err(self.error(0, "a curve needs the field \"control_points\", a list of points"));
                }
            },
            other => {
                let what = format!("the kind {other:?} is not curve, surface or, at the top, model");
                return Err(self.error(0, &what));
            }
        }
        Ok(())
    }

    /// The loops that bound a surface.
    fn read_trim(&self, surface: &BsplineSurface) -> Result<TrimLoops, Error> {
        let loops = self.parse_owned::<Vec<Vec<[f64; 2]>>>()?;
        let found = TrimLoops::new(loops).and_then(|trim| trim.within(surface));
        found.map_err(|error| self.error(0, &format!("trim: {error}")))
    }

    fn parse_head(&self) -> Result<Head<'a>, Error> {
        if !self.text.trim_start().starts_with('{') {
            return Err(self.error(0, "an object with the field \"kind\" is expected: {\"kind\": …}"));
        }
        serde_json::from_str(self.text).map_err(|error| self.explain(&error))
    }

    fn parse_owned<T: DeserializeOwned>(&self) -> Result<T, Error> {
        serde_json::from_str(self.text).map_err(|error| self.explain(&error))
    }

    /// Says where in the file a message of the JSON reader belongs, and to which field.
    fn explain(&self, error: &serde_json::Error) -> Error {
        let message = error.to_string();
        let message = message.rsplit_once(" at line ").map_or(message.as_str(), |(message, _)| message);
        let message = in_terms_of_json(message);
        let lines = self.text.split_inclusive('\n').take(error.line().saturating_sub(1));
        let at = (lines.map(str::len).sum::<usize>() + error.column()).min(self.text.len());
        let before = self.text.get(..at).unwrap_or(self.text);
        // What concerns the shape as a whole has no place, or is noticed behind the last brace.
        let whole = error.line() == 0 || error.is_data() && self.text[before.len()..].trim_start().is_empty();
        match last_key(before).filter(|_| !whole) {
            Some(key) => self.error(at, &format!("{key}: {message} (column {})", error.column())),
            None if whole => self.error(0, &message),
            None => self.error(at, &format!("{message} (column {})", error.column())),
        }
    }

    fn error(&self, at: usize, what: &str) -> Error {
        let what = match self.shape {
            Some(index) => format!("shape {index}: {what}"),
            None => what.to_owned(),
        };
        self.source.line_error(self.offset + at, what, EXPORT)
    }
}

/// A message of the JSON reader without the names of types in its program.
fn in_terms_of_json(message: &str) -> String {
    const WORDS: [(&str, &str); 4] = [
        ("expected usize", "expected an integer that is not negative"),
        ("expected f64", "expected a number"),
        ("expected a sequence", "expected a list"),
        ("expected an array of length", "expected a list of length"),
    ];
    WORDS.iter().fold(message.to_owned(), |message, (from, to)| message.replace(from, to))
}

/// Number of coordinates of the first control point.
fn first_length(control_points: &RawValue) -> Option<usize> {
    let points: Vec<&RawValue> = serde_json::from_str(control_points.get()).ok()?;
    let first: Vec<f64> = serde_json::from_str(points.first()?.get()).ok()?;
    Some(first.len())
}

/// The last `"key":` of a text.
fn last_key(text: &str) -> Option<&str> {
    let mut rest = text;
    while let Some((before, _)) = rest.rsplit_once(':') {
        if let Some((inside, key)) =
            before.trim_end().strip_suffix('"').and_then(|before| before.rsplit_once('"'))
            && (inside.trim_end().ends_with(['{', ',']))
        {
            return Some(key);
        }
        rest = before;
    }
    None
}

/// A shape as it is written.
#[derive(Serialize)]
struct Named<'a, T> {
    #[serde(flatten)]
    shape: &'a T,
    #[serde(skip_serializing_if = "Option::is_none")]
    name: Option<&'a str>,
    #[serde(skip_serializing_if = "Option::is_none")]
    trim: Option<&'a [Vec<[f64; 2]>]>,
}

/// Writes one shape as it is, and another number of shapes as a model, one per line.
pub(crate) fn write(out: &mut dyn Write, model: &Model) -> io::Result<()> {
    if let [shape] = model.shapes() {
        write_shape(out, model, 0, shape)?;
        return out.write_all(b"\n");
    }
    out.write_all(b"{\"kind\":\"model\",\"shapes\":[")?;
    for (index, shape) in model.shapes().iter().enumerate() {
        out.write_all(if index == 0 { b"\n" } else { b",\n" })?;
        write_shape(out, model, index, shape)?;
    }
    out.write_all(b"\n]}\n")
}

fn write_shape(out: &mut dyn Write, model: &Model, index: usize, shape: &Shape) -> io::Result<()> {
    let name = model.name(index);
    let trim = model.trim(index).map(TrimLoops::loops);
    match shape {
        Shape::Curve2(shape) => serde_json::to_writer(out, &Named { shape, name, trim }),
        Shape::Curve3(shape) => serde_json::to_writer(out, &Named { shape, name, trim }),
        Shape::Surface(shape) => serde_json::to_writer(out, &Named { shape, name, trim }),
    }
    .map_err(io::Error::from)
}
