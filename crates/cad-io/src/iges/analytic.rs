//! Unbounded analytic surfaces of solids: plane, cylinder, cone, sphere and torus (types 190 to 198).

use super::directory::Entry;
use super::fault::Fault;
use super::file::{Cursor, File};
use brep_core::description::Carrier;
use nalgebra::Vector3;
use nurbs_core::Frame;

/// Reads one; its normal is that of its parameters.
pub(crate) fn read(file: &File<'_>, entry: &Entry, values: &mut Cursor<'_>) -> Result<Carrier, Fault> {
    let origin = values.pointer("pointer to a point")?;
    let origin = coordinates(file, values, origin, 116)?;
    let carrier = match entry.kind {
        190 => Carrier::Plane { frame: frame(file, entry, values, origin)? },
        192 => {
            let axis = axis(file, values)?;
            let radius = positive(values, "radius")?;
            Carrier::Cylinder { frame: with_reference(file, entry, values, origin, axis)?, radius }
        }
        194 => {
            let axis = axis(file, values)?;
            let radius = values.real("radius")?;
            let degrees = values.real("semi-angle in degrees")?;
            if !(radius >= 0.0 && degrees > 0.0 && degrees < 90.0) {
                let what = format!("a cone of radius {radius} and semi-angle {degrees}° does not exist");
                return Err(values.invalid(what));
            }
            let frame = with_reference(file, entry, values, origin, axis)?;
            Carrier::Cone { frame, radius, half_angle: degrees.to_radians() }
        }
        196 => {
            let radius = positive(values, "radius")?;
            let frame = if entry.form == 1 {
                frame(file, entry, values, origin)?
            } else {
                Frame::from_axis(origin, Vector3::z()).map_err(|error| values.invalid(error))?
            };
            Carrier::Sphere { frame, radius }
        }
        _ => {
            let axis = axis(file, values)?;
            let major_radius = positive(values, "major radius")?;
            let minor_radius = positive(values, "minor radius")?;
            let frame = with_reference(file, entry, values, origin, axis)?;
            Carrier::Torus { frame, major_radius, minor_radius }
        }
    };
    Ok(carrier)
}

/// Axis and, with form 1, reference direction.
fn frame(
    file: &File<'_>,
    entry: &Entry,
    values: &mut Cursor<'_>,
    origin: Vector3<f64>,
) -> Result<Frame, Fault> {
    let axis = axis(file, values)?;
    with_reference(file, entry, values, origin, axis)
}

fn axis(file: &File<'_>, values: &mut Cursor<'_>) -> Result<Vector3<f64>, Fault> {
    let axis = values.pointer("pointer to the axis")?;
    coordinates(file, values, axis, 123)
}

/// The reference direction of form 1; without it any will do.
fn with_reference(
    file: &File<'_>,
    entry: &Entry,
    values: &mut Cursor<'_>,
    origin: Vector3<f64>,
    axis: Vector3<f64>,
) -> Result<Frame, Fault> {
    let made = if entry.form == 1 {
        let reference = values.pointer("pointer to the reference direction")?;
        Frame::new(origin, axis, coordinates(file, values, reference, 123)?)
    } else {
        Frame::from_axis(origin, axis)
    };
    made.map_err(|error| values.invalid(error))
}

/// The coordinates of a point (type 116) or direction (type 123).
fn coordinates(
    file: &File<'_>,
    values: &Cursor<'_>,
    entry: &Entry,
    kind: u32,
) -> Result<Vector3<f64>, Fault> {
    if entry.kind != kind {
        let what = format!("entity {} is of type {}, not {kind}", entry.sequence, entry.kind);
        return Err(values.invalid(what));
    }
    Ok(Vector3::from(file.record(entry, values.depth())?.reals::<3>("coordinate")?))
}

fn positive(values: &mut Cursor<'_>, name: &str) -> Result<f64, Fault> {
    let value = values.real(name)?;
    if value > 0.0 {
        return Ok(value);
    }
    Err(values.invalid(format!("the {name} is {value}; it must be positive")))
}
