//! Parts of a STEP file: shells, faces, loops, edges and vertices.

use super::keys::place;
use super::numbers::EntityNumbers;
use brep_core::description::{
    Converted, EdgeDescription, EdgeUse, FaceDescription, FreeCurve, LoopDescription, PartDescription,
    ShellDescription, Unread, VertexDescription,
};
use nalgebra::Vector3;
use nurbs_core::ParametricCurve;
use std::cell::RefCell;
use std::collections::HashMap;
use std::sync::Arc;
use step_io::model::{EntityKey, StepModel};
use step_io::scene::{
    Bound, Edge, Face, GeometricSet, Scene, SetElement, Shell, Solid, SurfaceModel, Vertex,
};
use step_io::{Orientation, scene::SurfaceKind};

/// What is known while a file is turned into descriptions.
pub(super) struct Reader<'m> {
    pub(super) scene: &'m Scene<'m>,
    pub(super) model: &'m StepModel,
    /// One unit of angle of the file in radians.
    pub(super) angle: f64,
    pub(super) numbers: &'m EntityNumbers,
    /// What is left out.
    pub(super) unread: RefCell<Vec<Unread>>,
    /// Faces on swept and offset surfaces.
    pub(super) converted: RefCell<Vec<Converted>>,
}

/// A part that is being built, with the places of its edges and vertices.
#[derive(Default)]
pub(super) struct PartBuilder {
    pub(super) part: PartDescription,
    edges: HashMap<EntityKey, usize>,
    vertices: HashMap<EntityKey, usize>,
    faces: HashMap<EntityKey, ()>,
}

impl<'m> Reader<'m> {
    /// Number of an entity in the file; 0 when it is not known.
    pub(super) fn number(&self, key: EntityKey) -> u64 {
        place(key).map_or(0, |(kind, index)| self.numbers.number(kind, index))
    }

    /// Notes that an entity is left out.
    pub(super) fn leave_out(&self, key: EntityKey, kind: &str, why: String) {
        let entry = Unread { source: self.number(key), kind: kind.to_owned(), why };
        let mut unread = self.unread.borrow_mut();
        if !unread.contains(&entry) {
            unread.push(entry);
        }
    }

    /// Adds the shells of a solid.
    pub(super) fn add_solid(&self, builder: &mut PartBuilder, solid: &Solid<'m>) {
        match solid.outer() {
            Some((shell, orientation)) => self.add_shell(builder, &shell, orientation, solid.name()),
            None => {
                let why = "its outer shell cannot be resolved".to_owned();
                self.leave_out(solid.key(), "MANIFOLD_SOLID_BREP", why);
            }
        }
        for (shell, orientation) in solid.voids() {
            self.add_shell(builder, &shell, orientation, solid.name());
        }
    }

    /// Adds the shells of a surface model.
    pub(super) fn add_surface_model(&self, builder: &mut PartBuilder, surfaces: &SurfaceModel<'m>) {
        for (shell, orientation) in surfaces.shells() {
            self.add_shell(builder, &shell, orientation, surfaces.name());
        }
    }

    fn add_shell(&self, builder: &mut PartBuilder, shell: &Shell<'m>, orientation: Orientation, owner: &str) {
        let name = if shell.name().is_empty() || shell.name() == "NONE" { owner } else { shell.name() };
        let mut description = ShellDescription {
            name: name.to_owned(),
            source: self.number(shell.key()),
            faces: Vec::new(),
            closed: shell.is_closed(),
        };
        for face in shell.faces() {
            // A face belongs to one shell; files repeat faces where shells are listed twice.
            if builder.faces.insert(face.key(), ()).is_some() {
                continue;
            }
            match self.face(builder, &face, orientation) {
                Ok(face) => {
                    description.faces.push(builder.part.faces.len());
                    builder.part.faces.push(face);
                }
                Err(why) => {
                    self.leave_out(face.key(), "ADVANCED_FACE", why);
                    // With a face missing it bounds nothing.
                    description.closed = false;
                }
            }
        }
        if !description.faces.is_empty() {
            builder.part.shells.push(description);
        }
    }

    fn face(
        &self,
        builder: &mut PartBuilder,
        face: &Face<'m>,
        shell: Orientation,
    ) -> Result<FaceDescription, String> {
        let surface = face.surface();
        let carrier = self.carrier(face).map_err(|why| {
            let kind = match surface.kind() {
                SurfaceKind::Other(kind) => kind,
                _ => place(surface.key()).map_or("surface", |(kind, _)| kind),
            };
            format!("its surface #{} ({kind}) cannot be used: {why}", self.number(surface.key()))
        })?;
        let mut loops = Vec::new();
        for bound in face.bounds() {
            if let Some(vertex) = bound.vertex() {
                loops.push(LoopDescription::Vertex(self.vertex(builder, &vertex)?));
                continue;
            }
            loops.push(LoopDescription::Edges(self.edge_loop(builder, &bound, shell)?));
        }
        let source = self.number(face.key());
        let converted = match surface.kind() {
            SurfaceKind::LinearExtrusion(_) => Some("extrusion"),
            SurfaceKind::Revolution(_) => Some("revolution"),
            SurfaceKind::Offset(_) => Some("offset"),
            _ => None,
        };
        self.converted.borrow_mut().extend(converted.map(|kind| Converted { face: source, kind }));
        Ok(FaceDescription {
            name: face.name().to_owned(),
            source,
            carrier,
            same_sense: (face.orientation() == Orientation::Forward) == (shell == Orientation::Forward),
            loops,
        })
    }

    fn edge_loop(
        &self,
        builder: &mut PartBuilder,
        bound: &Bound<'m>,
        shell: Orientation,
    ) -> Result<Vec<EdgeUse>, String> {
        let mut uses = Vec::new();
        for (edge, orientation) in bound.oriented_edges() {
            let index = self.edge(builder, &edge)?;
            let forward = orientation == Orientation::Forward;
            uses.push(EdgeUse { edge: index, forward, pcurve: None });
        }
        if uses.is_empty() {
            return Err(format!("its boundary #{} has no edges", self.number(bound.key())));
        }
        // Edges that the library does not resolve would leave a gap: found by the vertices that do not meet.
        let part = &builder.part;
        let ends = |u: &EdgeUse| {
            let edge = &part.edges[u.edge];
            if u.forward { [edge.start, edge.end] } else { [edge.end, edge.start] }
        };
        for (this, next) in uses.iter().zip(uses.iter().cycle().skip(1)) {
            let ([_, end], [start, _]) = (ends(this), ends(next));
            if end != start && !self.coincide(part, end, start) {
                return Err(format!(
                    "edge #{} of its boundary does not begin where edge #{} ends",
                    part.edges[next.edge].source, part.edges[this.edge].source
                ));
            }
        }
        // A face that is turned over has its loops the other way round.
        if bound.orientation() != shell {
            uses.reverse();
            uses.iter_mut().for_each(|u| u.forward = !u.forward);
        }
        Ok(uses)
    }

    /// Whether two vertices are at the same place up to the uncertainty of the file.
    fn coincide(&self, part: &PartDescription, a: Option<usize>, b: Option<usize>) -> bool {
        let (Some(a), Some(b)) = (a, b) else { return false };
        let [a, b] = [a, b].map(|i| part.vertices[i].point);
        let uncertainty = self.scene.units().precision.unwrap_or(0.0);
        (a - b).norm() <= uncertainty.max(1e-6 * a.amax().max(b.amax()))
    }

    fn edge(&self, builder: &mut PartBuilder, edge: &Edge<'m>) -> Result<usize, String> {
        if let Some(&index) = builder.edges.get(&edge.key()) {
            return Ok(index);
        }
        let ends = [edge.start(), edge.end()];
        let [start, end] = ends.map(|v| v.map(|v| self.vertex(builder, &v)).transpose());
        let (start, end) = (start?, end?);
        let (curve, range) = self
            .edge_curve(edge)
            .map_err(|why| format!("its edge #{} cannot be used: {why}", self.number(edge.key())))?;
        let index = builder.part.edges.len();
        let source = self.number(edge.key());
        builder.part.edges.push(EdgeDescription { source, curve, range, start, end });
        builder.edges.insert(edge.key(), index);
        Ok(index)
    }

    fn vertex(&self, builder: &mut PartBuilder, vertex: &Vertex<'m>) -> Result<usize, String> {
        if let Some(&index) = builder.vertices.get(&vertex.key()) {
            return Ok(index);
        }
        let point = vertex.point().map(|p| Vector3::from(p.xyz()));
        let source = self.number(vertex.key());
        let point = point
            .filter(|p| p.iter().all(|c| c.is_finite()))
            .ok_or_else(|| format!("its vertex #{source} has no finite point"))?;
        let index = builder.part.vertices.len();
        builder.part.vertices.push(VertexDescription { source, point });
        builder.vertices.insert(vertex.key(), index);
        Ok(index)
    }

    /// Adds the curves and surfaces of a set that belongs to no boundary.
    pub(super) fn add_set(&self, builder: &mut PartBuilder, set: &GeometricSet<'m>) {
        for element in set.elements() {
            match element {
                SetElement::Curve(curve) => match self.whole_curve(&curve) {
                    Ok(whole) => {
                        let range = [whole.domain().start(), whole.domain().end()];
                        builder.part.curves.push(FreeCurve {
                            name: set.name().to_owned(),
                            source: self.number(curve.key()),
                            curve: brep_core::description::EdgeCurve::Nurbs(Arc::new(whole)),
                            range,
                        });
                    }
                    Err(why) => self.leave_out(curve.key(), "curve", why),
                },
                SetElement::Other(key) => match self.bare_surface(key) {
                    Ok(carrier) => {
                        let source = self.number(key);
                        let face = builder.part.faces.len();
                        builder.part.faces.push(FaceDescription {
                            name: set.name().to_owned(),
                            source,
                            carrier,
                            same_sense: true,
                            loops: Vec::new(),
                        });
                        builder.part.shells.push(ShellDescription {
                            name: set.name().to_owned(),
                            source,
                            faces: vec![face],
                            closed: false,
                        });
                    }
                    Err(why) => self.leave_out(key, "element of a geometric set", why),
                },
                // Single points are no shape to measure against.
                _ => {}
            }
        }
    }
}
