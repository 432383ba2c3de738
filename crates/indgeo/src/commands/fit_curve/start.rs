//! Curves that fits begin with or go on from.

use crate::error::Error;
use crate::input::cad_shapes;
use crate::report::Report;
use industrial_geometry::io::{Content, Shape};
use industrial_geometry::nurbs::BsplineCurve;
use std::path::Path;

/// A curve to start from.
pub(super) enum Start {
    Plane(BsplineCurve<2>),
    Space(BsplineCurve<3>),
}

/// The first B-spline curve of a NURBS or CAD file.
pub(super) fn start(path: &Path, role: &'static str, report: &mut Report) -> Result<Start, Error> {
    let shapes = match cad_shapes::read(path, role, report)? {
        Content::Nurbs(model) => model.into_shapes(),
        _ => Vec::new(),
    };
    let curves = shapes.into_iter().filter_map(|shape| match shape {
        Shape::Curve2(curve) => Some(Start::Plane(curve)),
        Shape::Curve3(curve) => Some(Start::Space(curve)),
        Shape::Surface(_) => None,
    });
    curves.into_iter().next().ok_or_else(|| {
        Error::content(
            path,
            "a curve is needed, but this file holds none",
            "give a B-spline curve (JSON, STEP, IGES)",
        )
    })
}
