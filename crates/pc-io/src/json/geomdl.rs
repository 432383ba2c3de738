//! The JSON of geomdl (NURBS-Python): `{"shape": {"type": …, "data": […]}}`.

use nalgebra::{SVector, Vector3};
use nurbs_core::{BsplineCurve, BsplineSurface, KnotVector};
use serde::Deserialize;
use serde_json::value::RawValue;

use super::{EXPORT, Part};
use crate::Error;
use crate::error::Place;
use crate::model::{Model, Shape};

/// The outermost object, if it is one of geomdl.
#[derive(Deserialize)]
struct Outer<'a> {
    #[serde(borrow)]
    shape: Option<Container<'a>>,
}

#[derive(Deserialize)]
struct Container<'a> {
    #[serde(rename = "type")]
    kind: String,
    /// A list of shapes, or one.
    #[serde(borrow)]
    data: &'a RawValue,
}

/// A curve or surface; its points are not multiplied by their weights.
#[derive(Deserialize)]
struct Spline {
    #[serde(rename = "type")]
    kind: Option<String>,
    name: Option<String>,
    degree: Option<usize>,
    degree_u: Option<usize>,
    degree_v: Option<usize>,
    degree_w: Option<usize>,
    knotvector: Option<Vec<f64>>,
    knotvector_u: Option<Vec<f64>>,
    knotvector_v: Option<Vec<f64>>,
    size_u: Option<usize>,
    size_v: Option<usize>,
    control_points: Option<ControlPoints>,
    trims: Option<Trims>,
    #[serde(default)]
    reversed: Sense,
}

#[derive(Deserialize)]
struct ControlPoints {
    points: Vec<Vec<f64>>,
    weights: Option<Vec<f64>>,
}

#[derive(Deserialize)]
struct Trims {
    data: Vec<serde::de::IgnoredAny>,
}

/// Whether a shape is run through backwards: a truth value, or a number.
#[derive(Deserialize, Default)]
#[serde(untagged)]
enum Sense {
    #[default]
    Missing,
    Truth(bool),
    Number(f64),
}

/// Reads the model if the text is one of geomdl.
pub(super) fn read(part: &Part<'_>, warnings: &mut Vec<String>) -> Result<Option<Model>, Error> {
    let Ok(Outer { shape: Some(container) }) = serde_json::from_str(part.text) else { return Ok(None) };
    if container.kind == "volume" {
        let what = "a volume of geomdl is neither a curve nor a surface";
        return Err(Error::unsupported(Place::Whole, what, "export its boundary surfaces"));
    }
    let text = container.data.get();
    let parts: Vec<&RawValue> = if text.starts_with('[') {
        let list = part.within(container.data, None);
        serde_json::from_str(text).map_err(|error| list.explain(&error))?
    } else {
        vec![container.data]
    };
    let mut model = Model::default();
    let (mut trimmed, mut reversed) = (0usize, 0usize);
    for (index, raw) in parts.into_iter().enumerate() {
        let part = part.within(raw, Some(index));
        let spline: Spline = part.parse_owned()?;
        trimmed += usize::from(spline.trims.as_ref().is_some_and(|trims| !trims.data.is_empty()));
        reversed += usize::from(match spline.reversed {
            Sense::Missing => false,
            Sense::Truth(reversed) => reversed,
            Sense::Number(sense) => sense != 0.0,
        });
        let name = spline.name.clone().filter(|name| !name.is_empty());
        let shape = spline.into_shape().map_err(|what| part.error(0, &what))?;
        model.push(shape, name);
    }
    if trimmed > 0 {
        warnings
            .push(format!("not read: the trimming curves of {trimmed} surfaces, which are taken as a whole"));
    }
    if reversed > 0 {
        warnings.push(format!(
            "not read: that {reversed} shapes are reversed; their normals are those of the parameters"
        ));
    }
    Ok(Some(model))
}

impl Spline {
    fn into_shape(self) -> Result<Shape, String> {
        let missing = |field: &str| format!("the field {field:?} is missing");
        match self.kind.as_deref() {
            None | Some("spline") => {}
            Some(other) => {
                return Err(format!("the type {other:?} is not \"spline\", and has no control points"));
            }
        }
        if self.degree_w.is_some() {
            return Err("a volume is neither a curve nor a surface".to_owned());
        }
        let ControlPoints { points, weights } =
            self.control_points.ok_or_else(|| missing("control_points"))?;
        let failed = |error: nurbs_core::Error| error.to_string();
        if let Some(degree) = self.degree {
            let knots = KnotVector::new(degree, self.knotvector.ok_or_else(|| missing("knotvector"))?);
            let knots = knots.map_err(failed)?;
            return match points.first().map_or(0, Vec::len) {
                2 => Ok(BsplineCurve::<2>::new(knots, vectors(&points)?, weights).map_err(failed)?.into()),
                3 => Ok(BsplineCurve::<3>::new(knots, vectors(&points)?, weights).map_err(failed)?.into()),
                other => Err(format!("a control point has {other} coordinates, not 2 or 3")),
            };
        }
        let direction = |degree: Option<usize>, knots: Option<Vec<f64>>, names: [&str; 2]| {
            let degree = degree.ok_or_else(|| missing(names[0]))?;
            let knots = knots.ok_or_else(|| missing(names[1]))?;
            KnotVector::new(degree, knots).map_err(|error| format!("{}: {error}", names[1]))
        };
        let u = direction(self.degree_u, self.knotvector_u, ["degree_u", "knotvector_u"])?;
        let v = direction(self.degree_v, self.knotvector_v, ["degree_v", "knotvector_v"])?;
        for (size, knots, name) in [(self.size_u, &u, "size_u"), (self.size_v, &v, "size_v")] {
            if size.is_some_and(|size| size != knots.basis_count()) {
                return Err(format!(
                    "{name} is {}, but degree and knots need {} control points",
                    size.unwrap_or(0),
                    knots.basis_count()
                ));
            }
        }
        let points: Vec<Vector3<f64>> = vectors(&points)?;
        // Row by row, the second direction fastest, as here.
        Ok(BsplineSurface::new(u, v, points, weights).map_err(failed)?.into())
    }
}

fn vectors<const D: usize>(points: &[Vec<f64>]) -> Result<Vec<SVector<f64, D>>, String> {
    let vector = |(index, point): (usize, &Vec<f64>)| {
        <[f64; D]>::try_from(point.as_slice())
            .map(SVector::from)
            .map_err(|_| format!("control point {index} has {} coordinates, not {D}", point.len()))
    };
    points.iter().enumerate().map(vector).collect()
}

/// What to say of JSON that is of no kind known.
pub(super) fn unknown(part: &Part<'_>) -> Error {
    part.source.line_error(
        part.offset,
        "the object has neither a field \"kind\" (NURBS JSON) nor a field \"shape\" with \"type\" and \"data\" (geomdl)",
        EXPORT,
    )
}
