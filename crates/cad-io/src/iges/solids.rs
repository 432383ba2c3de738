//! Solids and shells (types 186 and 514), faces (510), loops (508), edges (504) and vertices (502).

use super::curves::{self, Piece};
use super::directory::Entry;
use super::fault::Fault;
use super::file::File;
use super::motion::Motion;
use super::surfaces::{self, Bounds};
use crate::builder;
use brep_core::description::{
    EdgeDescription, EdgeUse, FaceDescription, LoopDescription, PartDescription, ShellDescription,
};
use nalgebra::Vector3;
use nurbs_core::BsplineCurve;
use std::collections::HashMap;
use std::sync::Arc;

/// Edges and vertices of a solid, which its faces share.
pub(crate) struct Shared<'f> {
    file: &'f File<'f>,
    /// Points of vertex lists, by directory entry.
    points: HashMap<u32, Vec<Vector3<f64>>>,
    /// Vertices that are in the part already.
    vertices: HashMap<(u32, usize), usize>,
    /// Rows of edge lists.
    rows: HashMap<u32, Vec<EdgeRow<'f>>>,
    /// Edges that are in the part already; a composite curve makes several of one.
    edges: HashMap<(u32, usize), Vec<usize>>,
    motion: Option<Motion>,
}

/// A row of an edge list.
#[derive(Clone, Copy)]
struct EdgeRow<'f> {
    curve: &'f Entry,
    start: (&'f Entry, usize),
    end: (&'f Entry, usize),
}

/// Reads a solid (186) or a shell of its own (514) into a part.
pub(crate) fn read<'f>(
    file: &'f File<'f>,
    entry: &'f Entry,
    part: &mut PartDescription,
) -> Result<(), Fault> {
    let motion = Motion::of(file, entry, None, 0)?;
    let mut shared = Shared {
        file,
        points: HashMap::new(),
        vertices: HashMap::new(),
        rows: HashMap::new(),
        edges: HashMap::new(),
        motion,
    };
    if entry.kind == 514 {
        return shared.shell(entry, true, entry.form == 1, 0, part);
    }
    let mut values = file.record(entry, 0)?;
    let outer = values.pointer("pointer to the shell")?;
    let outer_sense = values.integer("orientation flag")? != 0;
    let voids = values.count("number of void shells")?;
    let mut shells = vec![(outer, outer_sense)];
    for _ in 0..voids {
        shells.push((values.pointer("pointer to a void shell")?, values.integer("orientation flag")? != 0));
    }
    let depth = values.depth();
    let name = values.name(entry);
    let first = part.shells.len();
    for (shell, sense) in shells {
        shared.shell(shell, sense, true, depth, part)?;
    }
    for shell in &mut part.shells[first..] {
        shell.name.clone_from(&name);
    }
    Ok(())
}

impl<'f> Shared<'f> {
    fn shell(
        &mut self,
        entry: &Entry,
        sense: bool,
        closed: bool,
        depth: usize,
        part: &mut PartDescription,
    ) -> Result<(), Fault> {
        let mut values = self.file.record(entry, depth)?;
        if entry.kind != 514 {
            return Err(values.invalid("a shell of a solid must be of type 514"));
        }
        let count = values.count("number of faces")?;
        let mut shell = ShellDescription { source: u64::from(entry.sequence), closed, ..Default::default() };
        for _ in 0..count {
            let face = values.pointer("pointer to a face")?;
            let agrees = values.integer("orientation flag")? != 0;
            let mut face = self.face(face, values.depth(), part)?;
            face.same_sense = (face.same_sense == agrees) == sense;
            part.faces.push(face);
            shell.faces.push(part.faces.len() - 1);
        }
        shell.name = values.name(entry);
        part.shells.push(shell);
        Ok(())
    }

    fn face(
        &mut self,
        entry: &Entry,
        depth: usize,
        part: &mut PartDescription,
    ) -> Result<FaceDescription, Fault> {
        let mut values = self.file.record(entry, depth)?;
        if entry.kind != 510 {
            return Err(values.invalid("a face of a shell must be of type 510"));
        }
        let surface = values.pointer("pointer to the surface")?;
        let count = values.count("number of loops")?;
        values.integer("outer loop flag")?;
        let loops = values.pointers(count, "pointer to a loop")?;
        let bounds = if count > 0 { Bounds::Loops } else { Bounds::Domain };
        let surface = surfaces::read(self.file, surface, self.motion.as_ref(), bounds, values.depth())?;
        let keeps_parameters = surface.chart.is_carrier();
        let mut found = Vec::with_capacity(count);
        for boundary in loops {
            found.push(self.closed(boundary, keeps_parameters, values.depth(), part)?);
        }
        let name = values.name(entry);
        Ok(FaceDescription {
            name: if name.is_empty() { surface.name } else { name },
            source: u64::from(entry.sequence),
            carrier: surface.carrier,
            same_sense: surface.same_sense,
            loops: found,
        })
    }

    /// Type 508: edges and vertices in order.
    fn closed(
        &mut self,
        entry: &Entry,
        keeps_parameters: bool,
        depth: usize,
        part: &mut PartDescription,
    ) -> Result<LoopDescription, Fault> {
        let mut values = self.file.record(entry, depth)?;
        if entry.kind != 508 {
            return Err(values.invalid("a loop of a face must be of type 508"));
        }
        let count = values.count("number of edges")?;
        let (mut uses, mut vertex) = (Vec::new(), None);
        for _ in 0..count {
            let is_vertex = values.integer("type of an edge")? == 1;
            let list = values.pointer("pointer to a list")?;
            let index = values.index("index in a list")?;
            let forward = values.integer("orientation flag")? != 0;
            let counterparts = values.count("number of curves in parameters")?;
            let mut flat = Vec::with_capacity(counterparts);
            for _ in 0..counterparts {
                values.integer("isoparametric flag")?;
                flat.push(values.pointer("pointer to a curve in parameters")?);
            }
            let depth = values.depth();
            if is_vertex {
                vertex = Some(self.vertex(entry, (list, index), depth, part)?);
                continue;
            }
            let edges = self.edge(entry, list, index, depth, part)?;
            let pcurve = match (flat[..].first(), &edges[..]) {
                (Some(counterpart), [_]) if keeps_parameters && flat.len() == 1 => {
                    let (pieces, _) = curves::read(self.file, counterpart, None, depth)?;
                    in_direction(&pieces, forward)
                }
                _ => None,
            };
            let use_of = |&edge: &usize| EdgeUse { edge, forward, pcurve: pcurve.clone() };
            if forward {
                uses.extend(edges.iter().map(use_of));
            } else {
                uses.extend(edges.iter().rev().map(use_of));
            }
        }
        match vertex {
            // A vertex among edges is a pole, which bounds nothing.
            Some(vertex) if uses.is_empty() => Ok(LoopDescription::Vertex(vertex)),
            _ if uses.is_empty() => Err(values.invalid("the loop has no edges")),
            _ => Ok(LoopDescription::Edges(uses)),
        }
    }

    /// The edges of the part that a row of an edge list makes.
    fn edge(
        &mut self,
        from: &Entry,
        list: &'f Entry,
        index: usize,
        depth: usize,
        part: &mut PartDescription,
    ) -> Result<Vec<usize>, Fault> {
        if let Some(known) = self.edges.get(&(list.sequence, index)) {
            return Ok(known.clone());
        }
        let row = self.row(from, list, index, depth)?;
        let (pieces, _) = curves::read(self.file, row.curve, self.motion.as_ref(), depth)?;
        let start = self.vertex(list, row.start, depth, part)?;
        let end = self.vertex(list, row.end, depth, part)?;
        let last = pieces.len().saturating_sub(1);
        let mut made = Vec::with_capacity(pieces.len());
        let mut enter = start;
        for (i, piece) in pieces.into_iter().enumerate() {
            let leave =
                if i == last { end } else { builder::add_vertex(part, piece.ends()[1], piece.source) };
            // An edge must run along its curve: one that was turned round is written anew.
            let (curve, range) = if piece.forward {
                (piece.curve, piece.range)
            } else {
                let turned =
                    piece.nurbs().map_err(|error| Fault::of(list, format!("edge {index}: {error}")))?;
                let domain = nurbs_core::ParametricCurve::domain(&turned);
                let range = [domain.start(), domain.end()];
                (brep_core::description::EdgeCurve::Nurbs(Arc::new(turned)), range)
            };
            part.edges.push(EdgeDescription {
                source: piece.source,
                curve,
                range,
                start: Some(enter),
                end: Some(leave),
            });
            made.push(part.edges.len() - 1);
            enter = leave;
        }
        self.edges.insert((list.sequence, index), made.clone());
        Ok(made)
    }

    /// Type 504: a row, counted from 1.
    fn row(
        &mut self,
        from: &Entry,
        list: &'f Entry,
        index: usize,
        depth: usize,
    ) -> Result<EdgeRow<'f>, Fault> {
        if list.kind != 504 {
            let what = format!("it names entity {} of type {} as a list of edges", list.sequence, list.kind);
            return Err(Fault::of(from, what));
        }
        if !self.rows.contains_key(&list.sequence) {
            let mut values = self.file.record(list, depth)?;
            let count = values.count("number of edges")?;
            let mut rows = Vec::with_capacity(count);
            for _ in 0..count {
                let curve = values.pointer("pointer to a curve")?;
                let start = (values.pointer("pointer to a vertex list")?, values.index("index of a vertex")?);
                let end = (values.pointer("pointer to a vertex list")?, values.index("index of a vertex")?);
                rows.push(EdgeRow { curve, start, end });
            }
            self.rows.insert(list.sequence, rows);
        }
        let rows = self.rows.get(&list.sequence).map_or(&[][..], Vec::as_slice);
        index.checked_sub(1).and_then(|index| rows.get(index)).copied().ok_or_else(|| {
            let what = format!("it names edge {index} of entity {}, which has {}", list.sequence, rows.len());
            Fault::of(from, what)
        })
    }

    /// Type 502: the vertex of the part for a point of a vertex list, counted from 1.
    fn vertex(
        &mut self,
        from: &Entry,
        (list, index): (&Entry, usize),
        depth: usize,
        part: &mut PartDescription,
    ) -> Result<usize, Fault> {
        if let Some(&known) = self.vertices.get(&(list.sequence, index)) {
            return Ok(known);
        }
        if list.kind != 502 {
            let what =
                format!("it names entity {} of type {} as a list of vertices", list.sequence, list.kind);
            return Err(Fault::of(from, what));
        }
        if !self.points.contains_key(&list.sequence) {
            let mut values = self.file.record(list, depth)?;
            let motion = Motion::of(self.file, list, self.motion.as_ref(), values.depth())?;
            let count = values.count("number of vertices")?;
            let mut points = Vec::with_capacity(count);
            for _ in 0..count {
                let point = Vector3::from(values.reals::<3>("vertex")?);
                points.push(motion.map_or(point, |motion| motion.point(&point)));
            }
            self.points.insert(list.sequence, points);
        }
        let points = self.points.get(&list.sequence).map_or(&[][..], Vec::as_slice);
        let Some(&point) = index.checked_sub(1).and_then(|index| points.get(index)) else {
            let what =
                format!("it names vertex {index} of entity {}, which has {}", list.sequence, points.len());
            return Err(Fault::of(from, what));
        };
        let vertex = builder::add_vertex(part, point, u64::from(list.sequence));
        self.vertices.insert((list.sequence, index), vertex);
        Ok(vertex)
    }
}

/// A curve in parameters, which runs along its loop, in the direction of its edge.
fn in_direction(pieces: &[Piece], forward: bool) -> Option<Arc<BsplineCurve<2>>> {
    let [piece] = pieces else { return None };
    let (knots, points, weights) = piece.nurbs().ok()?.into_parts();
    let curve = BsplineCurve::new(knots, points.iter().map(|point| point.xy()).collect(), weights).ok()?;
    let curve = if forward { curve } else { curve.reversed().ok()? };
    Some(Arc::new(curve))
}
