//! Trimmed surfaces (types 144 and 143), their boundaries (142 and 141), and planes with a boundary (108).

use super::chart::Chart;
use super::curves::{self, Piece};
use super::directory::Entry;
use super::fault::Fault;
use super::file::{Cursor, File};
use super::motion::Motion;
use super::surfaces::{self, Bounds, Surface};
use crate::builder::{self, Stretch};
use crate::natural;
use brep_core::description::{Carrier, FaceDescription, LoopDescription, PartDescription};
use nurbs_core::BsplineCurve;
use std::sync::Arc;

/// Share of its coordinates up to which a curve counts as a point.
const POINT: f64 = 1e-12;
/// Share of the resolution of the file up to which a curve counts as a point.
const POINT_BY_RESOLUTION: f64 = 1e-3;

/// Reads a face of its own into a part: 144, 143, a plane with a boundary, or a whole surface.
pub(crate) fn face(
    file: &File<'_>,
    entry: &Entry,
    part: &mut PartDescription,
) -> Result<FaceDescription, Fault> {
    match entry.kind {
        144 => trimmed(file, entry, part),
        143 => bounded(file, entry, part),
        108 => plane(file, entry, part),
        _ => {
            let surface = surfaces::read(file, entry, None, Bounds::Domain, 0)?;
            Ok(assemble(entry, surface, String::new(), Vec::new()))
        }
    }
}

fn assemble(entry: &Entry, surface: Surface, name: String, loops: Vec<LoopDescription>) -> FaceDescription {
    FaceDescription {
        name: if name.is_empty() { surface.name } else { name },
        source: u64::from(entry.sequence),
        carrier: surface.carrier,
        same_sense: surface.same_sense,
        loops,
    }
}

/// Type 144: a surface, an outer boundary or none, and holes.
fn trimmed(file: &File<'_>, entry: &Entry, part: &mut PartDescription) -> Result<FaceDescription, Fault> {
    let mut values = file.record(entry, 0)?;
    let motion = Motion::of(file, entry, None, values.depth())?;
    let surface = values.pointer("pointer to the surface")?;
    let has_outer = values.integer("outer boundary flag")? != 0;
    let holes = values.count("number of inner boundaries")?;
    let outer = values.optional("pointer to the outer boundary")?;
    let mut boundaries: Vec<&Entry> = Vec::new();
    if has_outer {
        boundaries.push(outer.ok_or_else(|| values.invalid("the pointer to the outer boundary is 0"))?);
    }
    boundaries.extend(values.pointers(holes, "pointer to an inner boundary")?);
    let bounds = if has_outer { Bounds::Loops } else { Bounds::Domain };
    let surface = surfaces::read(file, surface, motion.as_ref(), bounds, values.depth())?;
    let mut loops = Vec::with_capacity(boundaries.len());
    if !has_outer
        && holes > 0
        && let Carrier::Nurbs(carrier) = &surface.carrier
    {
        // The boundary of the surface itself, which is understood only as long as there are no holes.
        let boundary = natural::of_spline(carrier)
            .map_err(|error| Fault::of(entry, format!("the surface is not valid: {error}")))?;
        loops.extend(boundary.add_to(part, u64::from(entry.sequence)));
    }
    for boundary in boundaries {
        loops.push(on_surface(file, boundary, &surface, motion.as_ref(), values.depth(), part)?);
    }
    let name = values.name(entry);
    Ok(assemble(entry, surface, name, loops))
}

/// Type 142: a boundary as a curve in space, one in the parameters of the surface, or both.
fn on_surface(
    file: &File<'_>,
    entry: &Entry,
    surface: &Surface,
    motion: Option<&Motion>,
    depth: usize,
    part: &mut PartDescription,
) -> Result<LoopDescription, Fault> {
    let mut values = file.record(entry, depth)?;
    if entry.kind != 142 {
        return Err(values.invalid("a boundary of a trimmed surface must be a curve on a surface (type 142)"));
    }
    values.integer("creation flag")?;
    values.optional("pointer to the surface")?;
    let in_parameters = values.optional("pointer to the curve in parameters")?;
    let in_space = values.optional("pointer to the curve in space")?;
    let motion = Motion::of(file, entry, motion, values.depth())?;
    let flat = in_parameters.map(|curve| curves::read(file, curve, None, values.depth())).transpose()?;
    let flat = flat.map(|(pieces, _)| pieces);
    match (in_space, flat) {
        (Some(curve), flat) => {
            let (pieces, _) = curves::read(file, curve, motion.as_ref(), values.depth())?;
            Ok(closed(file, pieces, flat, surface, part))
        }
        (None, Some(flat)) => {
            let pieces = lifted(entry, &flat, &surface.chart)?;
            Ok(closed(file, pieces, Some(flat), surface, part))
        }
        (None, None) => Err(values.invalid("the boundary has a curve neither in space nor in parameters")),
    }
}

/// Curves in space from those in parameters.
fn lifted(entry: &Entry, flat: &[Piece], chart: &Chart) -> Result<Vec<Piece>, Fault> {
    let invalid = |error: nurbs_core::Error| Fault::of(entry, format!("the boundary is not valid: {error}"));
    let lift = |piece: &Piece| {
        let curve = in_plane(piece).and_then(|curve| chart.lift(&curve).transpose()).map_err(invalid)?;
        let Some(curve) = curve else {
            let what = "the boundary is a curve in the parameters of a surface that has none";
            let advice = "export the part with boundary curves in space";
            return Err(Fault::of(entry, what).unsupported(advice));
        };
        let domain = nurbs_core::ParametricCurve::domain(&curve);
        Ok(Piece {
            range: [domain.start(), domain.end()],
            curve: brep_core::description::EdgeCurve::Nurbs(Arc::new(curve)),
            forward: true,
            source: piece.source,
        })
    };
    flat.iter().map(lift).collect()
}

/// A curve in parameters, which files write as one in space with z = 0.
fn in_plane(piece: &Piece) -> Result<BsplineCurve<2>, nurbs_core::Error> {
    let (knots, points, weights) = piece.nurbs()?.into_parts();
    BsplineCurve::new(knots, points.iter().map(|point| point.xy()).collect(), weights)
}

/// A loop of pieces; those in parameters go with those in space where there are as many.
fn closed(
    file: &File<'_>,
    mut pieces: Vec<Piece>,
    flat: Option<Vec<Piece>>,
    surface: &Surface,
    part: &mut PartDescription,
) -> LoopDescription {
    curves::orient(&mut pieces);
    let keeps_parameters = matches!(surface.carrier, Carrier::Nurbs(_)) && surface.chart.is_carrier();
    let flat = flat.filter(|flat| keeps_parameters && flat.len() == pieces.len());
    let smallest = POINT_BY_RESOLUTION * file.global.resolution.unwrap_or(0.0);
    let is_point = |piece: &Piece| {
        let [extent, coordinate] = piece.size();
        extent <= smallest.max(POINT * coordinate)
    };
    let place = pieces.first().map(|piece| (piece.ends()[0], piece.source));
    let mut stretches = Vec::with_capacity(pieces.len());
    for (index, piece) in pieces.into_iter().enumerate() {
        if is_point(&piece) {
            continue;
        }
        // A piece that had to be turned round no longer tells in which direction its counterpart runs.
        let flat = flat.as_ref().filter(|_| piece.forward).and_then(|flat| flat.get(index));
        let pcurve = flat.and_then(|flat| in_plane(flat).ok()).map(Arc::new);
        let enter = piece.ends()[0];
        let Piece { curve, range, forward, source } = piece;
        stretches.push(Stretch { curve, range, forward, source, enter, pcurve });
    }
    match place {
        Some((point, source)) if stretches.is_empty() => {
            LoopDescription::Vertex(builder::add_vertex(part, point, source))
        }
        _ => builder::add_loop(part, stretches),
    }
}

/// Type 143: a surface and boundaries of type 141.
fn bounded(file: &File<'_>, entry: &Entry, part: &mut PartDescription) -> Result<FaceDescription, Fault> {
    let mut values = file.record(entry, 0)?;
    let motion = Motion::of(file, entry, None, values.depth())?;
    values.integer("type of boundaries")?;
    let surface = values.pointer("pointer to the surface")?;
    let count = values.count("number of boundaries")?;
    let boundaries = values.pointers(count, "pointer to a boundary")?;
    let bounds = if count > 0 { Bounds::Loops } else { Bounds::Domain };
    let surface = surfaces::read(file, surface, motion.as_ref(), bounds, values.depth())?;
    let mut loops = Vec::with_capacity(count);
    for boundary in boundaries {
        loops.push(boundary_of(file, boundary, &surface, motion.as_ref(), values.depth(), part)?);
    }
    let name = values.name(entry);
    Ok(assemble(entry, surface, name, loops))
}

/// Type 141: curves in space with their senses, and the same in parameters.
fn boundary_of(
    file: &File<'_>,
    entry: &Entry,
    surface: &Surface,
    motion: Option<&Motion>,
    depth: usize,
    part: &mut PartDescription,
) -> Result<LoopDescription, Fault> {
    let mut values: Cursor<'_> = file.record(entry, depth)?;
    if entry.kind != 141 {
        return Err(values.invalid("a boundary of a bounded surface must be of type 141"));
    }
    let motion = Motion::of(file, entry, motion, values.depth())?;
    values.integer("type of boundary")?;
    values.integer("preference")?;
    values.optional("pointer to the surface")?;
    let count = values.count("number of curves")?;
    let (mut pieces, mut flat) = (Vec::new(), Some(Vec::new()));
    for _ in 0..count {
        let curve = values.pointer("pointer to a curve")?;
        let sense = values.integer("sense of a curve")?;
        let counterparts = values.count("number of curves in parameters")?;
        let counterparts = values.pointers(counterparts, "pointer to a curve in parameters")?;
        let (mut found, _) = curves::read(file, curve, motion.as_ref(), values.depth())?;
        let mut in_parameters = Vec::new();
        for counterpart in counterparts {
            in_parameters.extend(curves::read(file, counterpart, None, values.depth())?.0);
        }
        if in_parameters.len() != found.len() {
            flat = None;
        }
        if let Some(flat) = &mut flat {
            flat.extend(in_parameters);
        }
        if sense == 2 {
            found.reverse();
            for piece in &mut found {
                piece.forward = !piece.forward;
            }
            // Counterparts run in the direction of the boundary, curves in their own.
            flat = None;
        }
        pieces.extend(found);
    }
    if pieces.is_empty() {
        return Err(values.invalid("the boundary has no curves"));
    }
    Ok(closed(file, pieces, flat, surface, part))
}

/// Type 108, form 1: a plane with one closed boundary curve.
fn plane(file: &File<'_>, entry: &Entry, part: &mut PartDescription) -> Result<FaceDescription, Fault> {
    let mut values = file.record(entry, 0)?;
    let boundary = surfaces::plane_boundary(&mut values)?;
    let Some(boundary) = boundary.filter(|_| entry.form == 1) else {
        let what =
            if entry.form == -1 { "the plane is a hole in another one" } else { "the plane has no boundary" };
        return Err(Fault::of(entry, what).unsupported("export it as a trimmed surface (type 144)"));
    };
    let surface = surfaces::read(file, entry, None, Bounds::Loops, 0)?;
    let motion = Motion::of(file, entry, None, values.depth())?;
    let (pieces, _) = curves::read(file, boundary, motion.as_ref(), values.depth())?;
    let loops = vec![closed(file, pieces, None, &surface, part)];
    Ok(assemble(entry, surface, String::new(), loops))
}
