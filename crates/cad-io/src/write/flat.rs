//! Parts in their places: what formats without instances hold.

use crate::Error;
use brep_core::description::{Carrier, EdgeCurve, ModelDescription, PartDescription, Placement};
use nalgebra::Vector3;
use nurbs_core::Frame;
use std::borrow::Cow;
use std::sync::Arc;

/// The part of each instance in the coordinates of the model. Those that stand where they are keep every bit.
pub(crate) fn placed(model: &ModelDescription) -> Result<Vec<Cow<'_, PartDescription>>, Error> {
    let place = |instance: &brep_core::description::InstanceDescription| {
        let Some(part) = model.parts.get(instance.part) else {
            return Err(unwritable(
                "model",
                format!("an instance names part {}, of which there is none", instance.part),
            ));
        };
        if instance.placement == Placement::IDENTITY {
            return Ok(Cow::Borrowed(part));
        }
        let failed = |error: nurbs_core::Error| {
            unwritable(
                &format!("part \"{}\"", part.name),
                format!("its instance cannot be moved into place: {error}"),
            )
        };
        moved(part, &instance.placement).map(Cow::Owned).map_err(failed)
    };
    model.instances.iter().map(place).collect()
}

pub(crate) fn unwritable(what: &str, why: impl Into<String>) -> Error {
    Error::Unwritable { what: what.to_owned(), why: why.into() }
}

fn moved(part: &PartDescription, placement: &Placement) -> Result<PartDescription, nurbs_core::Error> {
    let mut part = part.clone();
    for vertex in &mut part.vertices {
        vertex.point = placement.point(&vertex.point);
    }
    for edge in &mut part.edges {
        edge.curve = curve(&edge.curve, placement)?;
    }
    for free in &mut part.curves {
        free.curve = curve(&free.curve, placement)?;
    }
    let mirrored = placement.rotation.determinant() < 0.0;
    for face in &mut part.faces {
        // The normal of a face is carried along; that of the parameters of a B-spline turns over in a mirror image.
        face.same_sense ^= mirrored && matches!(face.carrier, Carrier::Nurbs(_));
        face.carrier = carrier(&face.carrier, placement)?;
    }
    Ok(part)
}

fn curve(curve: &EdgeCurve, placement: &Placement) -> Result<EdgeCurve, nurbs_core::Error> {
    let linear = placement.rotation * placement.scale;
    // Frames of curves keep the sense in which the curve runs: `z` is normal to the images of `x` and `y`.
    let frame = |frame: &Frame| {
        let [x, y] = [frame.x(), frame.y()].map(|axis| placement.direction(&axis));
        Frame::new(placement.point(&frame.origin()), x.cross(&y), x)
    };
    Ok(match curve {
        EdgeCurve::Line { origin, direction } => {
            EdgeCurve::Line { origin: placement.point(origin), direction: linear * direction }
        }
        EdgeCurve::Circle { frame: at, radius } => {
            EdgeCurve::Circle { frame: frame(at)?, radius: radius * placement.scale }
        }
        EdgeCurve::Ellipse { frame: at, semi_axes } => {
            EdgeCurve::Ellipse { frame: frame(at)?, semi_axes: semi_axes.map(|axis| axis * placement.scale) }
        }
        EdgeCurve::Nurbs(curve) => {
            EdgeCurve::Nurbs(Arc::new(curve.transformed(&linear, &placement.translation)?))
        }
    })
}

fn carrier(carrier: &Carrier, placement: &Placement) -> Result<Carrier, nurbs_core::Error> {
    let scale = placement.scale;
    let direction = |axis: Vector3<f64>| placement.direction(&axis);
    let frame = |frame: &Frame| {
        Frame::new(placement.point(&frame.origin()), direction(frame.z()), direction(frame.x()))
    };
    Ok(match carrier {
        Carrier::Plane { frame: at } => Carrier::Plane { frame: frame(at)? },
        Carrier::Cylinder { frame: at, radius } => {
            Carrier::Cylinder { frame: frame(at)?, radius: radius * scale }
        }
        Carrier::Cone { frame: at, radius, half_angle } => {
            Carrier::Cone { frame: frame(at)?, radius: radius * scale, half_angle: *half_angle }
        }
        Carrier::Sphere { frame: at, radius } => {
            Carrier::Sphere { frame: frame(at)?, radius: radius * scale }
        }
        Carrier::Torus { frame: at, major_radius, minor_radius } => Carrier::Torus {
            frame: frame(at)?,
            major_radius: major_radius * scale,
            minor_radius: minor_radius * scale,
        },
        Carrier::Nurbs(surface) => {
            let linear = placement.rotation * scale;
            Carrier::Nurbs(Arc::new(surface.transformed(&linear, &placement.translation)?))
        }
    })
}
