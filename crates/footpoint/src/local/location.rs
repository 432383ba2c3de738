//! Where on its shape a parameter lies.

use super::axis::Axis;
use crate::Location;

/// The location of a parameter of a curve.
pub(crate) fn curve_location(axis: &Axis, t: f64) -> Location {
    if axis.at_end(t) {
        Location::Edge
    } else if axis.at_seam(t) {
        Location::Seam
    } else {
        Location::Interior
    }
}

/// The location of a parameter pair of a surface at which no edge is collapsed.
pub(crate) fn surface_location(axes: &[Axis; 2], parameter: [f64; 2]) -> Location {
    let ends = [0, 1].map(|k| axes[k].at_end(parameter[k]));
    let seams = [0, 1].map(|k| axes[k].at_seam(parameter[k]));
    match ends {
        [true, true] => Location::Corner,
        [true, false] | [false, true] => Location::Edge,
        _ if seams[0] || seams[1] => Location::Seam,
        _ => Location::Interior,
    }
}
