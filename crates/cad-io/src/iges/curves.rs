//! Curves: lines, arcs, conics, polylines, splines and composites of them.

use super::conic;
use super::directory::Entry;
use super::fault::Fault;
use super::file::{Cursor, File};
use super::motion::Motion;
use super::power;
use crate::edges;
use brep_core::description::EdgeCurve;
use nalgebra::Vector3;
use nurbs_core::{BsplineCurve, Error, Frame, Interval, KnotVector, ParametricCurve};
use std::f64::consts::TAU;
use std::sync::Arc;

/// Share of the size of an arc up to which its ends count as one point: files give them with 9 digits or more.
const CLOSED: f64 = 1e-9;

/// A piece of a curve, to be passed along in one of its directions.
#[derive(Clone, Debug)]
pub(crate) struct Piece {
    /// The curve.
    pub(crate) curve: EdgeCurve,
    /// Parameters of start and end, increasing.
    pub(crate) range: [f64; 2],
    /// Passed along from the start to the end.
    pub(crate) forward: bool,
    /// Directory entry that it comes from.
    pub(crate) source: u64,
}

impl Piece {
    /// The points where it begins and ends, in the direction in which it is passed along.
    pub(crate) fn ends(&self) -> [Vector3<f64>; 2] {
        let [start, end] = self.range.map(|t| self.curve.point(t));
        if self.forward { [start, end] } else { [end, start] }
    }

    /// Largest extent in one coordinate, or a bound of it, and the largest coordinate.
    pub(crate) fn size(&self) -> [f64; 2] {
        let [a, b] = self.ends();
        let around = |centre: Vector3<f64>, radius: f64| {
            // A small arc of a large circle is as small as its chord and its sagitta.
            let angle = (self.range[1] - self.range[0]).abs().min(TAU);
            [(radius * angle).min(2.0 * radius), centre.amax() + radius]
        };
        match &self.curve {
            EdgeCurve::Line { .. } => [(b - a).amax(), a.amax().max(b.amax())],
            EdgeCurve::Circle { frame, radius } => around(frame.origin(), *radius),
            EdgeCurve::Ellipse { frame, semi_axes } => around(frame.origin(), semi_axes[0].max(semi_axes[1])),
            EdgeCurve::Nurbs(curve) => {
                let points = curve.control_points();
                let extent = points.iter().map(|p| (p - points[0]).amax()).fold(0.0, f64::max);
                [2.0 * extent, points.iter().map(Vector3::amax).fold(0.0, f64::max)]
            }
        }
    }

    /// The piece as a B-spline in the direction in which it is passed along.
    pub(crate) fn nurbs(&self) -> Result<BsplineCurve<3>, Error> {
        let curve = edges::nurbs(&self.curve, self.range)?;
        if self.forward { Ok(curve) } else { curve.reversed() }
    }
}

/// Whether the type is one of curves that are read.
pub(crate) const fn is_curve(kind: u32) -> bool {
    matches!(kind, 100 | 102 | 104 | 106 | 110 | 112 | 126)
}

/// Reads a curve in the coordinates of the model; a composite has several pieces. Also gives its name.
pub(crate) fn read(
    file: &File<'_>,
    entry: &Entry,
    parent: Option<&Motion>,
    depth: usize,
) -> Result<(Vec<Piece>, String), Fault> {
    let mut values = file.record(entry, depth)?;
    let motion = Motion::of(file, entry, parent, values.depth())?;
    let invalid = |error: Error| Fault::of(entry, format!("the curve is not valid: {error}"));
    let (curve, range) = match entry.kind {
        102 => {
            let pieces = composite(file, &mut values, motion.as_ref())?;
            return Ok((pieces, values.name(entry)));
        }
        100 => arc(&mut values)?,
        104 => conic::read(entry.form, &mut values)?,
        106 => polyline(entry, &mut values)?,
        110 => line(entry, &mut values)?,
        112 => power::curve(&mut values)?,
        126 => spline(&mut values)?,
        kind => {
            let what = format!("entity {} of type {kind} stands where a curve is needed", entry.sequence);
            let advice = "export the part with curves of type 100, 102, 104, 106, 110, 112 or 126";
            return Err(Fault::of(entry, what).unsupported(advice));
        }
    };
    let (curve, range) = match &motion {
        Some(motion) => motion.curve(&curve, range).map_err(invalid)?,
        None => (curve, range),
    };
    let piece = Piece { curve, range, forward: true, source: u64::from(entry.sequence) };
    Ok((vec![piece], values.name(entry)))
}

fn composite(file: &File<'_>, values: &mut Cursor<'_>, motion: Option<&Motion>) -> Result<Vec<Piece>, Fault> {
    let count = values.count("number of curves")?;
    let mut pieces = Vec::new();
    for member in values.pointers(count, "pointer to a curve")? {
        // Points between the curves carry no geometry of their own.
        if !matches!(member.kind, 116 | 132) {
            pieces.extend(read(file, member, motion, values.depth())?.0);
        }
    }
    if pieces.is_empty() {
        return Err(values.invalid("the composite curve has no curves"));
    }
    orient(&mut pieces);
    Ok(pieces)
}

/// Turns pieces round that are written against the direction of their loop: each shall begin where the one before ends.
pub(crate) fn orient(pieces: &mut [Piece]) {
    for i in 1..pieces.len() {
        let (before, rest) = pieces.split_at_mut(i);
        let (first, next) = (&mut before[i - 1], &mut rest[0]);
        let ([a, b], [c, d]) = (first.ends(), next.ends());
        let straight = (c - b).norm();
        let turned = (d - b).norm();
        // The first one has no predecessor: its other end may be the one that meets the second.
        let (first_turned, both_turned) = ((c - a).norm(), (d - a).norm());
        let size = first.size()[0].max(next.size()[0]);
        if straight <= 1e-6 * size {
            continue;
        }
        let clearly = |other: f64| other < 0.1 * straight;
        if clearly(turned) {
            next.forward = !next.forward;
        } else if i == 1 && clearly(first_turned) {
            first.forward = !first.forward;
        } else if i == 1 && clearly(both_turned) {
            first.forward = !first.forward;
            next.forward = !next.forward;
        }
    }
}

/// Type 110: the line from one point to another.
fn line(entry: &Entry, values: &mut Cursor<'_>) -> Result<(EdgeCurve, [f64; 2]), Fault> {
    let start = Vector3::from(values.reals::<3>("start of the line")?);
    let end = Vector3::from(values.reals::<3>("end of the line")?);
    if entry.form != 0 {
        let what = format!("the line is unbounded (form {})", entry.form);
        return Err(values.fault(what).unsupported("export it as a bounded line"));
    }
    Ok((EdgeCurve::Line { origin: start, direction: end - start }, [0.0, 1.0]))
}

/// Type 100: an arc in a plane of constant z, counter-clockwise from one point to another.
fn arc(values: &mut Cursor<'_>) -> Result<(EdgeCurve, [f64; 2]), Fault> {
    let z = values.real("z of the arc")?;
    let [x, y, x1, y1, x2, y2] = values.reals("centre, start and end of the arc")?;
    let (start, end) = ([x1 - x, y1 - y], [x2 - x, y2 - y]);
    let radius = start[0].hypot(start[1]);
    if !(radius > 0.0 && radius.is_finite()) {
        return Err(
            values.invalid(format!("the radius of the arc is {radius}; it must be positive and finite"))
        );
    }
    let gap = (x2 - x1).hypot(y2 - y1);
    let other = end[0].hypot(end[1]);
    if (other - radius).abs() > 1e-3 * radius {
        let what = format!("the start of the arc is {radius} away from its centre, its end {other}");
        return Err(values.invalid(what));
    }
    let sweep = if gap <= CLOSED * radius {
        TAU
    } else {
        (start[0] * end[1] - start[1] * end[0]).atan2(start[0] * end[0] + start[1] * end[1]).rem_euclid(TAU)
    };
    // The parameter of the file: the angle from the x axis of the plane of the arc.
    let from = start[1].atan2(start[0]).rem_euclid(TAU);
    let frame = Frame::new(Vector3::new(x, y, z), Vector3::z(), Vector3::x());
    let frame = frame.map_err(|error| values.invalid(error))?;
    Ok((EdgeCurve::Circle { frame, radius }, [from, from + sweep]))
}

/// Type 106, forms 11 to 13 and 63: points joined by lines.
fn polyline(entry: &Entry, values: &mut Cursor<'_>) -> Result<(EdgeCurve, [f64; 2]), Fault> {
    let flag = values.integer("interpretation flag")?;
    let count = values.count("number of points")?;
    if !matches!(entry.form, 11..=13 | 63) {
        let what = format!("copious data of form {} are no curve", entry.form);
        return Err(values.fault(what).unsupported("export polylines as forms 11 to 13"));
    }
    let z = if flag == 1 { values.real("common z")? } else { 0.0 };
    let mut points: Vec<Vector3<f64>> = Vec::with_capacity(count);
    for _ in 0..count {
        let [x, y] = values.reals("point")?;
        let z = if flag == 1 { z } else { values.real("point")? };
        if flag == 3 {
            values.reals::<3>("vector at a point")?;
        }
        let point = Vector3::new(x, y, z);
        if points.last() != Some(&point) {
            points.push(point);
        }
    }
    let Some(&first) = points.first() else { return Err(values.invalid("the polyline has no points")) };
    // A polyline of form 63 is closed even where its last point does not repeat the first.
    if points.len() == 1 || (entry.form == 63 && points.last() != Some(&first)) {
        points.push(first);
    }
    let last = points.len() - 1;
    let mut knots: Vec<f64> = (0..points.len()).map(|i| i as f64).collect();
    knots.insert(0, 0.0);
    knots.push(last as f64);
    let curve = KnotVector::new(1, knots).and_then(|knots| BsplineCurve::new(knots, points, None));
    let curve = curve.map_err(|error| values.invalid(error))?;
    Ok((EdgeCurve::Nurbs(Arc::new(curve)), [0.0, last as f64]))
}

/// Type 126: a rational B-spline curve.
fn spline(values: &mut Cursor<'_>) -> Result<(EdgeCurve, [f64; 2]), Fault> {
    let upper = values.count("upper index of the control points")?;
    let degree = values.count("degree")?;
    for name in ["planar flag", "closed flag", "polynomial flag", "periodic flag"] {
        values.integer(name)?;
    }
    let knots = values.list(upper + degree + 2, "knots")?;
    let weights = values.list(upper + 1, "weights")?;
    let mut points = Vec::with_capacity(upper + 1);
    for _ in 0..=upper {
        points.push(Vector3::from(values.reals::<3>("control points")?));
    }
    let curve = KnotVector::new(degree, knots)
        .and_then(|knots| BsplineCurve::new(knots, points, rational(weights)))
        .map_err(|error| values.invalid(format!("the B-spline is not valid: {error}")))?;
    let [start, end] = if values.is_ended() { [0.0; 2] } else { values.reals("parameter range")? };
    let range = within(curve.domain(), [start, end]).map_err(|what| values.invalid(what))?;
    // The normal of planar curves, which files may leave out.
    if !values.is_ended() {
        values
            .reals::<3>("normal of the plane")
            .or_else(|fault| if values.is_ended() { Ok([0.0; 3]) } else { Err(fault) })?;
    }
    Ok((EdgeCurve::Nurbs(Arc::new(curve)), range))
}

/// The weights, unless all are 1.
pub(crate) fn rational(weights: Vec<f64>) -> Option<Vec<f64>> {
    Some(weights).filter(|weights| weights.iter().any(|&weight| weight != 1.0))
}

/// The part of a domain that a range asks for; the whole domain for `[0, 0]`, with which writers leave the range open.
pub(crate) fn within(domain: Interval, [start, end]: [f64; 2]) -> Result<[f64; 2], String> {
    if start == 0.0 && end == 0.0 {
        return Ok([domain.start(), domain.end()]);
    }
    let clamped = [start.max(domain.start()), end.min(domain.end())];
    if clamped[0] < clamped[1] {
        return Ok(clamped);
    }
    Err(format!(
        "the parameter range [{start}, {end}] is empty or outside the knots [{}, {}]",
        domain.start(),
        domain.end()
    ))
}
