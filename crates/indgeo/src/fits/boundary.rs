//! Boundary curves and neighbours of surfaces, from files.

use crate::error::Error;
use crate::input::cad_shapes;
use crate::report::Report;
use crate::report::wording::counted;
use clap::ValueEnum;
use industrial_geometry::io::{Content, Shape};
use industrial_geometry::nurbs::construct::BoundaryCurves;
use industrial_geometry::nurbs::nalgebra::Vector3;
use industrial_geometry::nurbs::{Aabb, BsplineCurve, BsplineSurface};
use std::path::Path;

/// Share of the size up to which ends of curves are the same point.
const SAME: f64 = 1e-6;

/// How a shape continues its neighbours.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum ContinuityChoice {
    /// With a common edge or end
    G0,
    /// With common tangent planes or tangents there
    G1,
}

/// Four curves around a patch, and up to which distance their ends are the same.
pub(crate) struct Boundary {
    pub(crate) curves: BoundaryCurves,
    pub(crate) slack: f64,
}

impl Boundary {
    /// The four space curves of a file, in any order and direction.
    pub(crate) fn read(path: &Path, report: &mut Report) -> Result<Self, Error> {
        let shapes = shapes(path, "boundary", report)?;
        let curves: Vec<BsplineCurve<3>> = shapes
            .into_iter()
            .filter_map(|shape| match shape {
                Shape::Curve3(curve) => Some(curve),
                _ => None,
            })
            .collect();
        let count = curves.len();
        let curves: [BsplineCurve<3>; 4] = curves.try_into().map_err(|_| {
            let what = format!("a patch has four boundary curves in space, but this file holds {count}");
            Error::content(path, what, "give four B-spline curves (JSON, STEP, IGES) around the patch")
        })?;
        let places: Vec<Vector3<f64>> = curves.iter().flat_map(|c| c.control_points().to_vec()).collect();
        let slack = SAME * Aabb::of_points(&places).map_or(0.0, |bounds| bounds.diagonal());
        let curves = BoundaryCurves::of(curves, slack).map_err(|error| {
            Error::content(path, error.to_string(), "give curves that meet at four corners")
        })?;
        Ok(Self { curves, slack })
    }
}

/// All surfaces of a file.
pub(crate) fn neighbours(path: &Path, report: &mut Report) -> Result<Vec<BsplineSurface>, Error> {
    let shapes = shapes(path, "neighbour", report)?;
    let surfaces: Vec<BsplineSurface> = shapes
        .into_iter()
        .filter_map(|shape| match shape {
            Shape::Surface(surface) => Some(surface),
            _ => None,
        })
        .collect();
    if surfaces.is_empty() || surfaces.len() > 4 {
        let what = format!(
            "a patch has one to four neighbours, but this file holds {}",
            counted(surfaces.len(), "surface")
        );
        return Err(Error::content(path, what, "give B-spline surfaces (JSON, STEP, IGES)"));
    }
    Ok(surfaces)
}

fn shapes(path: &Path, role: &'static str, report: &mut Report) -> Result<Vec<Shape>, Error> {
    Ok(match cad_shapes::read(path, role, report)? {
        Content::Nurbs(model) => model.into_shapes(),
        _ => Vec::new(),
    })
}
