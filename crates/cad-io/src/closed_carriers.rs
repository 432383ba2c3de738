//! The loops of whole spheres and tori: seams, passed along in both directions.

use crate::builder;
use brep_core::description::{EdgeCurve, EdgeDescription, EdgeUse, LoopDescription, PartDescription};
use nalgebra::Vector3;
use nurbs_core::{Error, Frame};
use std::f64::consts::{FRAC_PI_2, TAU};

/// The meridian `u = 0` from pole to pole and back.
pub(crate) fn sphere(part: &mut PartDescription, frame: &Frame, radius: f64) -> LoopDescription {
    let pole = |z: f64| frame.origin() + frame.z() * (radius * z);
    let [south, north] = [-1.0, 1.0].map(|z| builder::add_vertex(part, pole(z), 0));
    // In the plane of x and z, so that the angle is the latitude.
    let meridian = Frame::new(frame.origin(), -frame.y(), frame.x()).unwrap_or(*frame);
    let seam = add_edge(
        part,
        EdgeCurve::Circle { frame: meridian, radius },
        [-FRAC_PI_2, FRAC_PI_2],
        [south, north],
    );
    uses(&[(seam, true), (seam, false)])
}

/// The circles `u = 0` and `v = 0`, each in both directions.
pub(crate) fn torus(
    part: &mut PartDescription,
    frame: &Frame,
    major_radius: f64,
    minor_radius: f64,
) -> Result<LoopDescription, Error> {
    if major_radius < minor_radius {
        let what = "a whole torus that meets itself has no boundary that could be written".to_owned();
        return Err(Error::Argument { what });
    }
    let corner = frame.point(&Vector3::new(major_radius + minor_radius, 0.0, 0.0));
    let corner = builder::add_vertex(part, corner, 0);
    let middle = frame.point(&Vector3::new(major_radius, 0.0, 0.0));
    let tube = Frame::new(middle, -frame.y(), frame.x())?;
    let around = EdgeCurve::Circle { frame: *frame, radius: major_radius + minor_radius };
    let around = add_edge(part, around, [0.0, TAU], [corner; 2]);
    let tube = EdgeCurve::Circle { frame: tube, radius: minor_radius };
    let tube = add_edge(part, tube, [0.0, TAU], [corner; 2]);
    Ok(uses(&[(around, true), (tube, true), (around, false), (tube, false)]))
}

fn add_edge(part: &mut PartDescription, curve: EdgeCurve, range: [f64; 2], ends: [usize; 2]) -> usize {
    let [start, end] = ends.map(Some);
    part.edges.push(EdgeDescription { source: 0, curve, range, start, end });
    part.edges.len() - 1
}

fn uses(edges: &[(usize, bool)]) -> LoopDescription {
    LoopDescription::Edges(edges.iter().map(|&(edge, forward)| EdgeUse { edge, forward, pcurve: None }).collect())
}
