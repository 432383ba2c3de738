//! IGES files out: trimmed surfaces (144) of B-splines (128) with boundaries in space (142, 102, 126), and free curves.

mod entities;
mod sections;

use crate::write::flat::{placed, unwritable};
use crate::write::shape;
use crate::{Error, edges};
use brep_core::description::{
    Carrier, EdgeCurve, EdgeUse, FaceDescription, LoopDescription, ModelDescription, PartDescription,
};
use entities::{Entities, Status};
use nurbs_core::{BsplineCurve, BsplineSurface};
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::f64::consts::TAU;

/// Angle from which an arc is a whole circle.
const FULL_TURN: f64 = TAU * (1.0 - 1e-12);

/// The bytes of an IGES file (5.3, fixed format) of a model.
///
/// Every face becomes a trimmed surface (type 144) of a B-spline surface (128) with its loops as curves in space (142, 102,
/// 126), and in the parameters of the surface where the description has them; a face without loops becomes a bare surface.
/// Planes, cylinders, cones, spheres, tori, lines and arcs become the exact B-splines. Instances are put in their places,
/// shells are not kept. Names become name properties (type 406). B-splines that are clamped keep every bit; others are
/// clamped first. A file without a unit is in millimetres. The same model always gives the same bytes, so the file bears no
/// time.
///
/// # Errors
/// [`Error::Unwritable`] names the face or curve that cannot be written: an unbounded carrier without loops, an index
/// that leads nowhere, a unit that the format does not know.
pub fn to_iges(model: &ModelDescription) -> Result<Vec<u8>, Error> {
    let mut entities = Entities::default();
    let mut largest: f64 = 0.0;
    for part in placed(model)? {
        for face in &part.faces {
            write_face(&mut entities, &part, face, &mut largest)
                .map_err(|error| named(error, &face_name(face)))?;
        }
        for free in &part.curves {
            let name = format!("curve \"{}\" (entity {})", free.name, free.source);
            let curve = edges::nurbs(&free.curve, free.range).map_err(|error| named(error.into(), &name))?;
            let curve =
                shape::clamped_curve(&curve).map_err(|error| named(error.into(), &name))?.into_owned();
            largest = reach(curve.control_points(), largest);
            let property = entities.name(&free.name);
            entities.curve(&curve, Status::Free, property);
        }
    }
    sections::file(model, &entities, largest)
}

fn face_name(face: &FaceDescription) -> String {
    format!("face \"{}\" (entity {})", face.name, face.source)
}

/// Why a face cannot be written.
enum Fault {
    Shape(nurbs_core::Error),
    Other(String),
}

impl From<nurbs_core::Error> for Fault {
    fn from(error: nurbs_core::Error) -> Self {
        Self::Shape(error)
    }
}

fn named(fault: Fault, what: &str) -> Error {
    match fault {
        Fault::Shape(error) => unwritable(what, error.to_string()),
        Fault::Other(why) => unwritable(what, why),
    }
}

fn reach(points: &[nalgebra::Vector3<f64>], largest: f64) -> f64 {
    points.iter().map(nalgebra::Vector3::amax).fold(largest, f64::max)
}

fn write_face(
    entities: &mut Entities,
    part: &PartDescription,
    face: &FaceDescription,
    largest: &mut f64,
) -> Result<(), Fault> {
    let unbounded = || Fault::Other("its surface is unbounded and it has no loops".to_owned());
    let whole = is_whole(part, face);
    let margin = if whole { 0.0 } else { shape::MARGIN };
    let surface = shape::nurbs(part, face, margin)?.ok_or_else(unbounded)?;
    // A face has no sense of its own in this format: the surface is turned over instead.
    let turned = !face.same_sense;
    let surface: Cow<'_, BsplineSurface> = if turned { Cow::Owned(surface.transposed()?) } else { surface };
    *largest = reach(surface.control_points(), *largest);
    let name = entities.name(&face.name);
    let mut boundaries: Vec<&[EdgeUse]> = Vec::new();
    for boundary in &face.loops {
        match boundary {
            LoopDescription::Edges(uses) if !uses.is_empty() => boundaries.push(uses),
            // A loop that is a point bounds nothing.
            LoopDescription::Edges(_) | LoopDescription::Vertex(_) => {}
        }
    }
    if whole || boundaries.is_empty() {
        entities.surface(&surface, Status::Free, name);
        return Ok(());
    }
    let surface = entities.surface(&surface, Status::Dependent, None);
    let keeps_parameters = matches!(face.carrier, Carrier::Nurbs(_));
    let mut written = Vec::with_capacity(boundaries.len());
    for uses in boundaries {
        let flat = keeps_parameters.then(|| in_parameters(uses, turned)).flatten();
        let (curves, size) = in_space(part, uses)?;
        let flat = flat.map(|flat| {
            let members = flat.iter().map(|curve| entities.parameter_curve(curve)).collect();
            entities.composite(members, Status::Parameters)
        });
        let members = curves.iter().map(|curve| entities.curve(curve, Status::Dependent, None)).collect();
        let space = entities.composite(members, Status::Dependent);
        written.push((entities.boundary(surface, flat, space), size));
    }
    // The outer boundary comes first; it is the largest.
    let outer = written.iter().enumerate().fold(0, |best, (i, (_, size))| {
        let largest: f64 = written[best].1;
        if *size > largest { i } else { best }
    });
    let outer = written.remove(outer).0;
    entities.trimmed(surface, outer, written.into_iter().map(|(boundary, _)| boundary).collect(), name);
    Ok(())
}

/// Whether the loops of a face are the boundary that its carrier has by itself: a seam, and at most two circles about the
/// axis. The bare surface says the same, and says it without seams, which not all readers understand.
fn is_whole(part: &PartDescription, face: &FaceDescription) -> bool {
    let mut counts: BTreeMap<usize, usize> = BTreeMap::new();
    for boundary in &face.loops {
        if let LoopDescription::Edges(uses) = boundary {
            uses.iter().for_each(|edge| *counts.entry(edge.edge).or_default() += 1);
        }
    }
    let seams = counts.values().filter(|&&count| count == 2).count();
    let is_circle = |index: &usize| {
        part.edges.get(*index).is_some_and(|edge| {
            matches!(edge.curve, EdgeCurve::Circle { .. }) && edge.range[1] - edge.range[0] >= FULL_TURN
        })
    };
    let rings = counts.iter().filter(|(_, count)| **count == 1);
    match face.carrier {
        Carrier::Sphere { .. } | Carrier::Torus { .. } => seams > 0 && seams == counts.len(),
        Carrier::Cylinder { .. } | Carrier::Cone { .. } => {
            seams == 1
                && counts.len() <= 3
                && rings.clone().count() + 1 == counts.len()
                && rings.map(|(edge, _)| edge).all(is_circle)
        }
        Carrier::Plane { .. } | Carrier::Nurbs(_) => false,
    }
}

/// The curves of a loop in its direction, and the diagonal of the box around their control points.
fn in_space(part: &PartDescription, uses: &[EdgeUse]) -> Result<(Vec<BsplineCurve<3>>, f64), Fault> {
    let mut curves = Vec::with_capacity(uses.len());
    let (mut low, mut high) =
        (nalgebra::Vector3::repeat(f64::INFINITY), nalgebra::Vector3::repeat(f64::NEG_INFINITY));
    for edge_use in uses {
        let Some(edge) = part.edges.get(edge_use.edge) else {
            return Err(Fault::Other(format!("a loop names edge {}, of which there is none", edge_use.edge)));
        };
        let curve = edges::nurbs(&edge.curve, edge.range)?;
        let curve = shape::clamped_curve(&curve)?.into_owned();
        for point in curve.control_points() {
            low = low.inf(point);
            high = high.sup(point);
        }
        curves.push(if edge_use.forward { curve } else { curve.reversed()? });
    }
    Ok((curves, (high - low).norm()))
}

/// The same in the parameters of the surface, if the description has all of them.
fn in_parameters(uses: &[EdgeUse], turned: bool) -> Option<Vec<BsplineCurve<2>>> {
    let one = |edge_use: &EdgeUse| {
        let curve = shape::clamped_curve(edge_use.pcurve.as_deref()?).ok()?.into_owned();
        let curve = if edge_use.forward { curve } else { curve.reversed().ok()? };
        if !turned {
            return Some(curve);
        }
        let (knots, points, weights) = curve.into_parts();
        let points = points.iter().map(|p| nalgebra::Vector2::new(p.y, p.x)).collect();
        BsplineCurve::new(knots, points, weights).ok()
    };
    uses.iter().map(one).collect()
}
