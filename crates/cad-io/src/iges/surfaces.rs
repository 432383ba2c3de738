//! Surfaces: B-splines, planes, ruled surfaces, surfaces of revolution, tabulated cylinders, and the analytic types.

use super::analytic;
use super::chart::Chart;
use super::curves;
use super::directory::Entry;
use super::fault::Fault;
use super::file::{Cursor, File};
use super::motion::Motion;
use super::power;
use super::revolution;
use super::ruled;
use brep_core::description::Carrier;
use nalgebra::Vector3;
use nurbs_core::{BsplineSurface, Direction, Frame, Interval, KnotVector, ParametricSurface, construct};
use std::sync::Arc;

/// A surface as a carrier of faces.
#[derive(Clone, Debug)]
pub(crate) struct Surface {
    /// The carrier, in the coordinates of the model.
    pub(crate) carrier: Carrier,
    /// Its normal is that of the parameters of the file, `S_u × S_v`.
    pub(crate) same_sense: bool,
    /// The surface by the parameters of the file.
    pub(crate) chart: Chart,
    /// Name; may be empty.
    pub(crate) name: String,
}

/// Whether a face has loops, or is bounded by the domain of its surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Bounds {
    /// The loops bound it: the carrier may be larger, or unbounded.
    Loops,
    /// The surface itself bounds it.
    Domain,
}

/// Whether the type is one of surfaces that are read.
pub(crate) const fn is_surface(kind: u32) -> bool {
    matches!(kind, 108 | 114 | 118 | 120 | 122 | 128 | 190 | 192 | 194 | 196 | 198)
}

/// Reads a surface in the coordinates of the model.
pub(crate) fn read(
    file: &File<'_>,
    entry: &Entry,
    parent: Option<&Motion>,
    bounds: Bounds,
    depth: usize,
) -> Result<Surface, Fault> {
    let mut values = file.record(entry, depth)?;
    let motion = Motion::of(file, entry, parent, values.depth())?;
    let unsupported = || {
        let what =
            format!("entity {} of type {} stands where a surface is needed", entry.sequence, entry.kind);
        let advice = "export the part with surfaces of type 108, 114, 118, 120, 122 or 128";
        Fault::of(entry, what).unsupported(advice)
    };
    let invalid = |error: nurbs_core::Error| Fault::of(entry, format!("the surface is not valid: {error}"));
    let plain = |surface: BsplineSurface| {
        let surface = Arc::new(surface);
        (Carrier::Nurbs(Arc::clone(&surface)), true, Chart::Nurbs(surface))
    };
    let (carrier, same_sense, chart) = match entry.kind {
        128 => plain(spline(&mut values, bounds)?),
        114 => plain(power::surface(&mut values)?),
        118 => {
            let (surface, chart) = ruled::read(file, entry, &mut values)?;
            (Carrier::Nurbs(Arc::new(surface)), true, chart)
        }
        122 => tabulated(file, &mut values)?,
        120 => revolution::read(file, &mut values, bounds)?,
        108 => (plane(&mut values)?, true, Chart::None),
        190 | 192 | 194 | 196 | 198 if bounds == Bounds::Loops => {
            (analytic::read(file, entry, &mut values)?, true, Chart::None)
        }
        _ => return Err(unsupported()),
    };
    let name = values.name(entry);
    let Some(motion) = motion else { return Ok(Surface { carrier, same_sense, chart, name }) };
    let (moved, upright) = motion.carrier(&carrier).map_err(invalid)?;
    let same_sense = same_sense == upright;
    Ok(Surface { carrier: moved, same_sense, chart: chart.moved(motion), name })
}

/// Type 128: a rational B-spline surface; `u` runs fastest in the file.
fn spline(values: &mut Cursor<'_>, bounds: Bounds) -> Result<BsplineSurface, Fault> {
    let upper = [values.count("upper index in u")?, values.count("upper index in v")?];
    let degrees = [values.count("degree in u")?, values.count("degree in v")?];
    for name in ["closed flag", "closed flag", "polynomial flag", "periodic flag", "periodic flag"] {
        values.integer(name)?;
    }
    let knots_u = values.list(upper[0] + degrees[0] + 2, "knots in u")?;
    let knots_v = values.list(upper[1] + degrees[1] + 2, "knots in v")?;
    let (n_u, n_v) = (upper[0] + 1, upper[1] + 1);
    let count = n_u.saturating_mul(n_v);
    values.expect(count.saturating_mul(4), "weights and control points")?;
    let by_columns = values.list(count, "weights")?;
    let weights = (0..count).map(|k| by_columns[k / n_v + (k % n_v) * n_u]).collect();
    let mut points = vec![Vector3::zeros(); count];
    for j in 0..n_v {
        for i in 0..n_u {
            points[i * n_v + j] = Vector3::from(values.reals::<3>("control points")?);
        }
    }
    let make = || {
        let (knots_u, knots_v) =
            (KnotVector::new(degrees[0], knots_u)?, KnotVector::new(degrees[1], knots_v)?);
        BsplineSurface::new(knots_u, knots_v, points, curves::rational(weights))
    };
    let surface = make().map_err(|error| values.invalid(format!("the B-spline is not valid: {error}")))?;
    let [u0, u1, v0, v1] = if values.is_ended() { [0.0; 4] } else { values.reals("parameter ranges")? };
    if bounds == Bounds::Loops {
        return Ok(surface);
    }
    let [domain_u, domain_v] = surface.domain();
    let ranges =
        curves::within(domain_u, [u0, u1]).and_then(|u| Ok([u, curves::within(domain_v, [v0, v1])?]));
    let ranges = ranges.map_err(|what| values.invalid(what))?;
    let mut piece = surface;
    for (direction, domain, range) in
        [(Direction::U, domain_u, ranges[0]), (Direction::V, domain_v, ranges[1])]
    {
        let range = Interval::new(range[0], range[1]).map_err(|error| values.invalid(error))?;
        if range != domain {
            piece = piece.trimmed(direction, range).map_err(|error| values.invalid(error))?;
        }
    }
    Ok(piece)
}

/// Type 108: the plane `A x + B y + C z = D`.
fn plane(values: &mut Cursor<'_>) -> Result<Carrier, Fault> {
    let normal = Vector3::from(values.reals::<3>("coefficient of the plane")?);
    let level = values.real("coefficient of the plane")?;
    let square = normal.norm_squared();
    let origin = normal * (level / square);
    if !(square > 0.0 && origin.iter().all(|c| c.is_finite())) {
        return Err(
            values.invalid(format!("the normal ({}, {}, {}) has no direction", normal.x, normal.y, normal.z))
        );
    }
    let frame = Frame::from_axis(origin, normal).map_err(|error| values.invalid(error))?;
    Ok(Carrier::Plane { frame })
}

/// The closed curve that bounds a plane of form 1, and past it the display symbol of all planes.
pub(crate) fn plane_boundary<'f>(values: &mut Cursor<'f>) -> Result<Option<&'f Entry>, Fault> {
    values.reals::<4>("coefficient of the plane")?;
    let boundary = values.optional("pointer to the boundary")?;
    if !values.is_ended() {
        // Position and size of the symbol.
        values.reals::<4>("display symbol")?;
    }
    Ok(boundary)
}

/// Type 122: the surface that a curve sweeps along a vector.
fn tabulated(file: &File<'_>, values: &mut Cursor<'_>) -> Result<(Carrier, bool, Chart), Fault> {
    let directrix = values.pointer("pointer to the directrix")?;
    let end = Vector3::from(values.reals::<3>("end of the generatrix")?);
    let curve = ruled::single(file, values, directrix)?;
    let vector = end - curve.ends()[0];
    let made = curve.nurbs().and_then(|curve| construct::extrude(&curve, &vector));
    let surface = made.map_err(|error| values.invalid(format!("the surface is not valid: {error}")))?;
    let surface = Arc::new(surface);
    Ok((Carrier::Nurbs(Arc::clone(&surface)), true, Chart::Unit(surface)))
}
