//! The JSON form of the analytic shapes.
//!
//! ```json
//! {"kind":"sphere","frame":{"origin":[0,0,0],"z":[0,0,1],"x":[1,0,0]},"radius":2.5}
//! {"kind":"circle","centre":[0,0],"x":[1,0],"y":[0,1],"radius":1,"arc":{"start":0,"end":3}}
//! ```
//! Domains (`u`, `v`, `arc`) may be left out when the shape is whole. Everything is checked on reading
//! as in the constructors.

use super::{AnalyticSurface, Circle, Cone, Cylinder, Ellipse, Frame, Line, Plane, Sphere, Torus};
use crate::{Error, Interval, ParametricCurve, ParametricSurface};
use nalgebra::{SVector, Vector3};
use serde::{Deserialize, Deserializer, Serialize, Serializer, de};

#[derive(Serialize, Deserialize)]
struct FrameForm {
    origin: [f64; 3],
    z: [f64; 3],
    x: [f64; 3],
}

#[derive(Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "lowercase")]
enum SurfaceForm {
    Plane {
        frame: Frame,
        u: Interval,
        v: Interval,
    },
    Sphere {
        frame: Frame,
        radius: f64,
        #[serde(default)]
        u: Option<Interval>,
        #[serde(default)]
        v: Option<Interval>,
    },
    Cylinder {
        frame: Frame,
        radius: f64,
        #[serde(default)]
        u: Option<Interval>,
        v: Interval,
    },
    Cone {
        frame: Frame,
        radii: [f64; 2],
        height: f64,
        #[serde(default)]
        u: Option<Interval>,
    },
    Torus {
        frame: Frame,
        major_radius: f64,
        minor_radius: f64,
        #[serde(default)]
        u: Option<Interval>,
        #[serde(default)]
        v: Option<Interval>,
    },
}

#[derive(Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "lowercase")]
enum CurveForm {
    Line {
        start: Vec<f64>,
        end: Vec<f64>,
    },
    Circle {
        centre: Vec<f64>,
        x: Vec<f64>,
        y: Vec<f64>,
        radius: f64,
        #[serde(default)]
        arc: Option<Interval>,
    },
    Ellipse {
        centre: Vec<f64>,
        x: Vec<f64>,
        y: Vec<f64>,
        semi_axes: [f64; 2],
    },
}

impl Serialize for Frame {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let form = FrameForm { origin: self.origin().into(), z: self.z().into(), x: self.x().into() };
        form.serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for Frame {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let form = FrameForm::deserialize(deserializer)?;
        let vector = |v: [f64; 3]| Vector3::from(v);
        Self::new(vector(form.origin), vector(form.z), vector(form.x)).map_err(de::Error::custom)
    }
}

impl From<&AnalyticSurface> for SurfaceForm {
    fn from(surface: &AnalyticSurface) -> Self {
        let [u, v] = surface.domain();
        match surface {
            AnalyticSurface::Plane(s) => Self::Plane { frame: *s.frame(), u, v },
            AnalyticSurface::Sphere(s) => {
                Self::Sphere { frame: *s.frame(), radius: s.radius(), u: Some(u), v: Some(v) }
            }
            AnalyticSurface::Cylinder(s) => {
                Self::Cylinder { frame: *s.frame(), radius: s.radius(), u: Some(u), v }
            }
            AnalyticSurface::Cone(s) => {
                Self::Cone { frame: *s.frame(), radii: s.radii(), height: s.height(), u: Some(u) }
            }
            AnalyticSurface::Torus(s) => Self::Torus {
                frame: *s.frame(),
                major_radius: s.major_radius(),
                minor_radius: s.minor_radius(),
                u: Some(u),
                v: Some(v),
            },
        }
    }
}

impl TryFrom<SurfaceForm> for AnalyticSurface {
    type Error = Error;

    fn try_from(form: SurfaceForm) -> Result<Self, Error> {
        Ok(match form {
            SurfaceForm::Plane { frame, u, v } => Plane::new(frame, u, v).into(),
            SurfaceForm::Sphere { frame, radius, u, v } => {
                let whole = Sphere::new(frame, radius)?;
                let [all_u, all_v] = whole.domain();
                whole.with_domain(u.unwrap_or(all_u), v.unwrap_or(all_v))?.into()
            }
            SurfaceForm::Cylinder { frame, radius, u, v } => {
                let whole = Cylinder::new(frame, radius, v)?;
                whole.with_angles(u.unwrap_or(whole.domain()[0]))?.into()
            }
            SurfaceForm::Cone { frame, radii: [base, top], height, u } => {
                let whole = Cone::new(frame, base, top, height)?;
                whole.with_angles(u.unwrap_or(whole.domain()[0]))?.into()
            }
            SurfaceForm::Torus { frame, major_radius, minor_radius, u, v } => {
                let whole = Torus::new(frame, major_radius, minor_radius)?;
                let [all_u, all_v] = whole.domain();
                whole.with_domain(u.unwrap_or(all_u), v.unwrap_or(all_v))?.into()
            }
        })
    }
}

impl Serialize for AnalyticSurface {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        SurfaceForm::from(self).serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for AnalyticSurface {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        Self::try_from(SurfaceForm::deserialize(deserializer)?).map_err(de::Error::custom)
    }
}

fn wrong_kind<E: de::Error>(wanted: &'static str) -> E {
    E::custom(Error::Form { field: "kind", what: format!("is not `{wanted}`") })
}

macro_rules! surfaces {
    ($($name:ident $kind:literal),*) => {$(
        impl Serialize for $name {
            fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
                AnalyticSurface::from(*self).serialize(serializer)
            }
        }

        impl<'de> Deserialize<'de> for $name {
            fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
                match AnalyticSurface::deserialize(deserializer)? {
                    AnalyticSurface::$name(surface) => Ok(surface),
                    _ => Err(wrong_kind($kind)),
                }
            }
        }
    )*};
}
surfaces!(Plane "plane", Sphere "sphere", Cylinder "cylinder", Cone "cone", Torus "torus");

fn list<const N: usize>(v: &SVector<f64, N>) -> Vec<f64> {
    v.as_slice().to_vec()
}

fn vector<const N: usize>(field: &'static str, values: &[f64]) -> Result<SVector<f64, N>, Error> {
    if values.len() == N {
        Ok(SVector::from_column_slice(values))
    } else {
        Err(Error::Form { field, what: format!("has {} coordinates where {N} are needed", values.len()) })
    }
}

macro_rules! curves {
    ($($name:ident $kind:literal, $to:expr, $from:pat => $make:expr;)*) => {$(
        impl<const N: usize> Serialize for $name<N> {
            fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
                $to(self).serialize(serializer)
            }
        }

        impl<'de, const N: usize> Deserialize<'de> for $name<N> {
            fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
                match CurveForm::deserialize(deserializer)? {
                    $from => $make.map_err(de::Error::custom),
                    _ => Err(wrong_kind($kind)),
                }
            }
        }
    )*};
}

curves! {
    Line "line",
    |c: &Line<N>| CurveForm::Line { start: list(&c.start()), end: list(&c.end()) },
    CurveForm::Line { start, end } =>
        vector("start", &start).and_then(|start| Line::new(start, vector("end", &end)?));

    Circle "circle",
    |c: &Circle<N>| CurveForm::Circle {
        centre: list(&c.centre()),
        x: list(&c.axes()[0]),
        y: list(&c.axes()[1]),
        radius: c.radius(),
        arc: Some(c.domain()),
    },
    CurveForm::Circle { centre, x, y, radius, arc } => vector("centre", &centre).and_then(|centre| {
        let whole = Circle::with_axes(centre, [vector("x", &x)?, vector("y", &y)?], radius)?;
        whole.with_arc(arc.unwrap_or(whole.domain()))
    });

    Ellipse "ellipse",
    |c: &Ellipse<N>| CurveForm::Ellipse {
        centre: list(&c.centre()),
        x: list(&c.axes()[0]),
        y: list(&c.axes()[1]),
        semi_axes: c.semi_axes(),
    },
    CurveForm::Ellipse { centre, x, y, semi_axes } => vector("centre", &centre)
        .and_then(|centre| Ellipse::with_axes(centre, [vector("x", &x)?, vector("y", &y)?], semi_axes));
}
