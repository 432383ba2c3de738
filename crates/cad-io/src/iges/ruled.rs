//! Ruled surfaces (type 118).

use super::chart::Chart;
use super::curves::{self, Piece};
use super::directory::Entry;
use super::fault::Fault;
use super::file::{Cursor, File};
use nurbs_core::{ArcLength, BsplineCurve, BsplineSurface, Interval, construct};
use std::sync::Arc;

/// Where the lengths of the two curves are compared, as shares of their parameters.
const STATIONS: usize = 16;
/// Largest difference of the shares of the lengths with which rulings by length and by parameter are the same.
const SAME: f64 = 1e-9;

/// Reads the surface between two curves.
///
/// Rulings join points of equal parameter (form 1) or of equal length (form 0). Those of equal length are read where they
/// are those of equal parameter, as between lines and between arcs of one angle.
pub(crate) fn read(
    file: &File<'_>,
    entry: &Entry,
    values: &mut Cursor<'_>,
) -> Result<(BsplineSurface, Chart), Fault> {
    let first = values.pointer("pointer to the first curve")?;
    let second = values.pointer("pointer to the second curve")?;
    let crossed = values.integer("direction flag")? == 1;
    values.integer("developable flag")?;
    let invalid =
        |error: nurbs_core::Error| Fault::of(entry, format!("the ruled surface is not valid: {error}"));
    let rail = |curve: Piece| curve.nurbs()?.reparameterized(Interval::UNIT);
    let first = rail(single(file, values, first)?).map_err(invalid)?;
    let mut second = rail(single(file, values, second)?).map_err(invalid)?;
    if crossed {
        second = second.reversed().map_err(invalid)?;
    }
    if entry.form == 0 && !same_lengths(&first, &second) {
        let what =
            "the rulings join points of equal arc length (form 0), which are not those of equal parameter";
        return Err(Fault::of(entry, what).unsupported("export the surface as a B-spline (type 128)"));
    }
    let surface = construct::ruled(&first, &second).map_err(invalid)?;
    let chart = Chart::Unit(Arc::new(surface.clone()));
    Ok((surface, chart))
}

/// Whether both curves have gone the same share of their length at each parameter.
fn same_lengths(first: &BsplineCurve<3>, second: &BsplineCurve<3>) -> bool {
    let [first, second] = [ArcLength::new(first, SAME), ArcLength::new(second, SAME)];
    let [all, other] = [first.total().value, second.total().value];
    (1..STATIONS).all(|i| {
        let t = i as f64 / STATIONS as f64;
        // A rail that is a point has every share.
        all == 0.0 || other == 0.0 || (first.at(t) / all - second.at(t) / other).abs() <= SAME
    })
}

/// The curve that a pointer names, where only a curve in one piece makes sense.
pub(crate) fn single(file: &File<'_>, values: &Cursor<'_>, entry: &Entry) -> Result<Piece, Fault> {
    let (mut pieces, _) = curves::read(file, entry, None, values.depth())?;
    match (pieces.pop(), pieces.is_empty()) {
        (Some(piece), true) => Ok(piece),
        _ => {
            let what = format!(
                "the surface is swept by a composite curve of several pieces (entity {})",
                entry.sequence
            );
            Err(values.fault(what).unsupported("export the surface as a B-spline (type 128)"))
        }
    }
}
