//! The NURBS JSON form of curves and surfaces.
//!
//! ```json
//! {"kind":"curve","dim":2,"degree":1,"knots":[0,0,1,1],"control_points":[[0,0],[1,2]],"weights":null}
//! {"kind":"surface","degree_u":1,"degree_v":1,"knots_u":[0,0,1,1],"knots_v":[0,0,1,1],
//!  "control_points":[[[0,0,0],[0,1,0]],[[1,0,0],[1,1,0]]],"weights":null}
//! ```
//! Periodic directions carry `"periodic": true` (`periodic_u`, `periodic_v`), their knots are complete
//! (`n + p + 1`), and the last `p` control points repeat the first ones. Other fields are ignored.

use crate::{BsplineCurve, BsplineSurface, Error, KnotVector};
use nalgebra::{SVector, Vector3};
use serde::{Deserialize, Serialize};

fn is_false(value: &bool) -> bool {
    !value
}

#[derive(Serialize, Deserialize)]
struct CurveForm {
    kind: String,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    dim: Option<usize>,
    degree: usize,
    knots: Vec<f64>,
    #[serde(default, skip_serializing_if = "is_false")]
    periodic: bool,
    control_points: Vec<Vec<f64>>,
    #[serde(default)]
    weights: Option<Vec<f64>>,
}

#[derive(Serialize, Deserialize)]
struct SurfaceForm {
    kind: String,
    degree_u: usize,
    degree_v: usize,
    knots_u: Vec<f64>,
    knots_v: Vec<f64>,
    #[serde(default, skip_serializing_if = "is_false")]
    periodic_u: bool,
    #[serde(default, skip_serializing_if = "is_false")]
    periodic_v: bool,
    control_points: Vec<Vec<[f64; 3]>>,
    #[serde(default)]
    weights: Option<Vec<Vec<f64>>>,
}

fn check_kind(found: &str, wanted: &'static str) -> Result<(), Error> {
    if found == wanted {
        Ok(())
    } else {
        Err(Error::Form { field: "kind", what: format!("is `{found}` where `{wanted}` is needed") })
    }
}

fn knot_vector(degree: usize, knots: Vec<f64>, periodic: bool) -> Result<KnotVector, Error> {
    if periodic { KnotVector::periodic(degree, knots) } else { KnotVector::new(degree, knots) }
}

impl<const D: usize> TryFrom<CurveForm> for BsplineCurve<D> {
    type Error = Error;

    fn try_from(form: CurveForm) -> Result<Self, Error> {
        check_kind(&form.kind, "curve")?;
        if let Some(dim) = form.dim.filter(|&dim| dim != D) {
            return Err(Error::Form { field: "dim", what: format!("is {dim} where {D} is needed") });
        }
        let mut points = Vec::with_capacity(form.control_points.len());
        for (i, p) in form.control_points.iter().enumerate() {
            if p.len() != D {
                let what = format!("point {i} has {} coordinates where {D} are needed", p.len());
                return Err(Error::Form { field: "control_points", what });
            }
            points.push(SVector::from_column_slice(p));
        }
        Self::new(knot_vector(form.degree, form.knots, form.periodic)?, points, form.weights)
    }
}

impl TryFrom<SurfaceForm> for BsplineSurface {
    type Error = Error;

    fn try_from(form: SurfaceForm) -> Result<Self, Error> {
        check_kind(&form.kind, "surface")?;
        let columns = form.control_points.first().map_or(0, Vec::len);
        if let Some(i) = form.control_points.iter().position(|row| row.len() != columns) {
            let what = format!("row {i} has {} points, row 0 has {columns}", form.control_points[i].len());
            return Err(Error::Form { field: "control_points", what });
        }
        let knots_u = knot_vector(form.degree_u, form.knots_u, form.periodic_u)?;
        let knots_v = knot_vector(form.degree_v, form.knots_v, form.periodic_v)?;
        let (n_u, n_v) = (knots_u.basis_count(), knots_v.basis_count());
        let rows = form.control_points.len();
        if (rows, columns) != (n_u, n_v) {
            let what = format!("net is {rows} x {columns} where the knots need {n_u} x {n_v}");
            return Err(Error::Form { field: "control_points", what });
        }
        if let Some(weights) = &form.weights
            && (weights.len() != rows || weights.iter().any(|row| row.len() != columns))
        {
            let what = format!("must be {rows} rows of {columns} numbers, as the control points");
            return Err(Error::Form { field: "weights", what });
        }
        let points = form.control_points.into_iter().flatten().map(Vector3::from).collect();
        let weights = form.weights.map(|rows| rows.into_iter().flatten().collect());
        Self::new(knots_u, knots_v, points, weights)
    }
}

impl<const D: usize> From<&BsplineCurve<D>> for CurveForm {
    fn from(curve: &BsplineCurve<D>) -> Self {
        Self {
            kind: "curve".into(),
            dim: Some(D),
            degree: curve.degree(),
            knots: curve.knots().as_slice().to_vec(),
            periodic: curve.knots().is_periodic(),
            control_points: curve.control_points().iter().map(|p| p.as_slice().to_vec()).collect(),
            weights: curve.weights().map(<[f64]>::to_vec),
        }
    }
}

impl From<&BsplineSurface> for SurfaceForm {
    fn from(s: &BsplineSurface) -> Self {
        let rows = s.control_points().chunks(s.n_v());
        Self {
            kind: "surface".into(),
            degree_u: s.degree_u(),
            degree_v: s.degree_v(),
            knots_u: s.knots_u().as_slice().to_vec(),
            knots_v: s.knots_v().as_slice().to_vec(),
            periodic_u: s.knots_u().is_periodic(),
            periodic_v: s.knots_v().is_periodic(),
            control_points: rows.map(|row| row.iter().map(|p| [p.x, p.y, p.z]).collect()).collect(),
            weights: s.weights().map(|w| w.chunks(s.n_v()).map(<[f64]>::to_vec).collect()),
        }
    }
}

#[derive(Serialize, Deserialize)]
struct KnotForm {
    degree: usize,
    knots: Vec<f64>,
    #[serde(default, skip_serializing_if = "is_false")]
    periodic: bool,
}

impl Serialize for KnotVector {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let form =
            KnotForm { degree: self.degree(), knots: self.as_slice().to_vec(), periodic: self.is_periodic() };
        form.serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for KnotVector {
    fn deserialize<De: serde::Deserializer<'de>>(deserializer: De) -> Result<Self, De::Error> {
        let form = KnotForm::deserialize(deserializer)?;
        knot_vector(form.degree, form.knots, form.periodic).map_err(serde::de::Error::custom)
    }
}

impl<const D: usize> Serialize for BsplineCurve<D> {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        CurveForm::from(self).serialize(serializer)
    }
}

impl<'de, const D: usize> Deserialize<'de> for BsplineCurve<D> {
    fn deserialize<De: serde::Deserializer<'de>>(deserializer: De) -> Result<Self, De::Error> {
        Self::try_from(CurveForm::deserialize(deserializer)?).map_err(serde::de::Error::custom)
    }
}

impl Serialize for BsplineSurface {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        SurfaceForm::from(self).serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for BsplineSurface {
    fn deserialize<De: serde::Deserializer<'de>>(deserializer: De) -> Result<Self, De::Error> {
        Self::try_from(SurfaceForm::deserialize(deserializer)?).map_err(serde::de::Error::custom)
    }
}
