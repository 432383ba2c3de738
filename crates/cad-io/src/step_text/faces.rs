//! Faces with their loops, and the edges and vertices that they share.

use super::curves::{curve, flag, knots};
use super::instances::{Instances, Reference, list, real, reals, string};
use crate::write::flat::unwritable;
use crate::write::shape;
use crate::{Error, natural};
use brep_core::description::{Carrier, EdgeUse, FaceDescription, LoopDescription, PartDescription};
use nalgebra::Vector3;
use nurbs_core::{BsplineSurface, Frame, Sphere, Torus};
use std::collections::HashMap;

/// What of a part was written already.
pub(super) struct Faces<'p> {
    part: &'p PartDescription,
    edges: HashMap<usize, Reference>,
    vertices: HashMap<usize, Reference>,
}

impl<'p> Faces<'p> {
    pub(super) fn new(part: &'p PartDescription) -> Self {
        Self { part, edges: HashMap::new(), vertices: HashMap::new() }
    }

    /// Writes a face.
    pub(super) fn write(&mut self, out: &mut Instances, face: &FaceDescription) -> Result<Reference, Error> {
        let named =
            |why: String| unwritable(&format!("face \"{}\" (entity {})", face.name, face.source), why);
        let mut bounds = Vec::with_capacity(face.loops.len());
        for boundary in &face.loops {
            bounds.push(self.bound(out, boundary).map_err(named)?);
        }
        if bounds.is_empty() {
            let found = by_itself(&face.carrier).map_err(|error| named(error.to_string()))?;
            let unbounded = || named("its surface is unbounded and it has no loops".to_owned());
            let (part, boundary) = found.ok_or_else(unbounded)?;
            bounds.push(Faces::new(&part).bound(out, &boundary).map_err(named)?);
        }
        let surface = carrier(out, &face.carrier).map_err(|error| named(error.to_string()))?;
        let name = string(&face.name);
        let sense = flag(face.same_sense);
        Ok(out.add(&format!("ADVANCED_FACE({name},{},{surface},{sense})", list(&bounds))))
    }

    fn bound(&mut self, out: &mut Instances, boundary: &LoopDescription) -> Result<Reference, String> {
        let boundary = match boundary {
            LoopDescription::Vertex(vertex) => {
                let vertex = self.vertex(out, *vertex)?;
                out.add(&format!("VERTEX_LOOP('',{vertex})"))
            }
            LoopDescription::Edges(uses) => {
                if uses.is_empty() {
                    return Err("a loop has no edges".to_owned());
                }
                let mut oriented = Vec::with_capacity(uses.len());
                for edge_use in uses {
                    oriented.push(self.oriented(out, edge_use)?);
                }
                out.add(&format!("EDGE_LOOP('',{})", list(&oriented)))
            }
        };
        Ok(out.add(&format!("FACE_BOUND('',{boundary},.T.)")))
    }

    fn oriented(&mut self, out: &mut Instances, edge_use: &EdgeUse) -> Result<Reference, String> {
        let edge = match self.edges.get(&edge_use.edge) {
            Some(&known) => known,
            None => {
                let made = self.edge(out, edge_use.edge)?;
                self.edges.insert(edge_use.edge, made);
                made
            }
        };
        Ok(out.add(&format!("ORIENTED_EDGE('',*,*,{edge},{})", flag(edge_use.forward))))
    }

    fn edge(&mut self, out: &mut Instances, index: usize) -> Result<Reference, String> {
        let edge = self.part.edges.get(index);
        let edge = edge.ok_or_else(|| format!("a loop names edge {index}, of which there is none"))?;
        let [start, end] = edge.range.map(|t| edge.curve.point(t));
        let mut vertex = |out: &mut Instances, known: Option<usize>, point: &Vector3<f64>| match known {
            Some(vertex) => self.vertex(out, vertex),
            None => {
                let point = out.point(point);
                Ok(out.add(&format!("VERTEX_POINT('',{point})")))
            }
        };
        let start = vertex(out, edge.start, &start)?;
        let end = vertex(out, edge.end, &end)?;
        let curve = curve(out, "", &edge.curve).map_err(|error| format!("edge {index}: {error}"))?;
        Ok(out.add(&format!("EDGE_CURVE('',{start},{end},{curve},.T.)")))
    }

    fn vertex(&mut self, out: &mut Instances, index: usize) -> Result<Reference, String> {
        if let Some(&known) = self.vertices.get(&index) {
            return Ok(known);
        }
        let vertex = self.part.vertices.get(index);
        let vertex = vertex.ok_or_else(|| format!("an edge names vertex {index}, of which there is none"))?;
        let point = out.point(&vertex.point);
        let made = out.add(&format!("VERTEX_POINT('',{point})"));
        self.vertices.insert(index, made);
        Ok(made)
    }
}

/// The loop that a carrier has by itself, in a part of its own; `None` for an unbounded carrier.
fn by_itself(carrier: &Carrier) -> Result<Option<(PartDescription, LoopDescription)>, nurbs_core::Error> {
    let boundary = match carrier {
        Carrier::Nurbs(surface) => natural::of_spline(&*shape::clamped(surface)?)?,
        Carrier::Sphere { frame, radius } => natural::of_analytic(&Sphere::new(*frame, *radius)?.into())?,
        Carrier::Torus { frame, major_radius, minor_radius } => {
            natural::of_analytic(&Torus::new(*frame, *major_radius, *minor_radius)?.into())?
        }
        Carrier::Plane { .. } | Carrier::Cylinder { .. } | Carrier::Cone { .. } => return Ok(None),
    };
    let mut part = PartDescription::default();
    Ok(boundary.add_to(&mut part, 0).map(|found| (part, found)))
}

/// The surface of a face.
fn carrier(out: &mut Instances, carrier: &Carrier) -> Result<Reference, nurbs_core::Error> {
    Ok(match carrier {
        Carrier::Plane { frame } => {
            let place = out.placement(frame);
            out.add(&format!("PLANE('',{place})"))
        }
        Carrier::Cylinder { frame, radius } => {
            let place = out.placement(frame);
            out.add(&format!("CYLINDRICAL_SURFACE('',{place},{})", real(*radius)))
        }
        Carrier::Cone { frame, radius, half_angle } => {
            // The angle must be positive: a cone that narrows widens along the opposite axis.
            let frame =
                if *half_angle < 0.0 { Frame::new(frame.origin(), -frame.z(), frame.x())? } else { *frame };
            let place = out.placement(&frame);
            out.add(&format!("CONICAL_SURFACE('',{place},{},{})", real(*radius), real(half_angle.abs())))
        }
        Carrier::Sphere { frame, radius } => {
            let place = out.placement(frame);
            out.add(&format!("SPHERICAL_SURFACE('',{place},{})", real(*radius)))
        }
        Carrier::Torus { frame, major_radius, minor_radius } => {
            let place = out.placement(frame);
            let radii = format!("{},{}", real(major_radius.abs()), real(*minor_radius));
            if *major_radius >= *minor_radius {
                out.add(&format!("TOROIDAL_SURFACE('',{place},{radii})"))
            } else {
                let outer = flag(*major_radius >= 0.0);
                out.add(&format!("DEGENERATE_TOROIDAL_SURFACE('',{place},{radii},{outer})"))
            }
        }
        Carrier::Nurbs(surface) => spline(out, &*shape::clamped(surface)?),
    })
}

fn spline(out: &mut Instances, surface: &BsplineSurface) -> Reference {
    let n_v = surface.n_v();
    let mut rows = Vec::with_capacity(surface.n_u());
    for row in surface.control_points().chunks(n_v) {
        let row: Vec<Reference> = row.iter().map(|point| out.point(point)).collect();
        rows.push(list(&row));
    }
    let degrees = format!("{},{}", surface.degree_u(), surface.degree_v());
    let form = format!("{degrees},({}),.UNSPECIFIED.,.F.,.F.,.F.", rows.join(","));
    let [multiplicities_u, values_u] = knots(surface.knots_u());
    let [multiplicities_v, values_v] = knots(surface.knots_v());
    let knots = format!("{multiplicities_u},{multiplicities_v},{values_u},{values_v},.UNSPECIFIED.");
    match surface.weights() {
        None => out.add(&format!("B_SPLINE_SURFACE_WITH_KNOTS('',{form},{knots})")),
        Some(weights) => {
            let rows: Vec<String> = weights.chunks(n_v).map(reals).collect();
            let weights = rows.join(",");
            out.add(&format!(
                "(BOUNDED_SURFACE()B_SPLINE_SURFACE({form})B_SPLINE_SURFACE_WITH_KNOTS({knots})\
                 GEOMETRIC_REPRESENTATION_ITEM()RATIONAL_B_SPLINE_SURFACE(({weights}))REPRESENTATION_ITEM('')SURFACE())"
            ))
        }
    }
}
