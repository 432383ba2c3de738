//! The foot of a query on the quadric that osculates a shape at a known foot.

use crate::PrincipalFrame;
use crate::local_geometry::{of_bend, of_point};
use nalgebra::{SMatrix, SVector};

/// Rounds of the fixed point iteration for the place on the quadric: each gains the square of the slope.
const ROUNDS: usize = 3;
/// `1 − dκ` is kept above this: beyond lies the centre of curvature.
const BEFORE_CENTRE: f64 = 0.1;

/// The frame that `x` has when the shape is replaced by the quadric `z = ½ Σ κᵢ ξᵢ²` over the tangent plane of a frame
/// (a parabola over the tangent, a point), with the foot kept within `reach` of the old one.
///
/// Exact up to the third order of the distance from the query that the frame belongs to.
pub(crate) fn frame_nearby<const D: usize>(
    frame: &PrincipalFrame<D>,
    x: &SVector<f64, D>,
    reach: f64,
) -> PrincipalFrame<D> {
    let (count, last) = (frame.tangent_dimension, D - 1);
    let local = frame.axes.tr_mul(&(x - frame.foot));
    let mut place = SVector::<f64, D>::zeros();
    for _ in 0..ROUNDS {
        let height = local[last] - place[last];
        let mut sum = 0.0;
        for i in 0..count {
            let factor = (1.0 - height * frame.curvatures[i]).max(BEFORE_CENTRE);
            place[i] = (local[i] / factor).clamp(-reach, reach);
            sum += 0.5 * frame.curvatures[i] * place[i] * place[i];
        }
        place[last] = sum;
    }
    let foot = frame.foot + frame.axes * place;
    let residual = x - foot;
    let normal = frame.axes.column(last).into_owned();
    let mut out = PrincipalFrame { foot, ..*frame };
    if count == last {
        // A hypersurface: its normal has turned.
        let mut slope = normal;
        for i in 0..count {
            slope -= frame.axes.column(i) * (frame.curvatures[i] * place[i]);
        }
        let turned = slope.normalize();
        out.axes = turned_axes(&frame.axes, &turned);
        out.distance = residual.dot(&turned);
    } else {
        let geometry = if count == 0 {
            of_point(&residual, Some(&normal))
        } else {
            let bend = normal * frame.curvatures[0];
            let tangent = (frame.axes.column(0) + bend * place[0]).normalize();
            of_bend(&tangent, &(bend - tangent * tangent.dot(&bend)), &residual, Some(&normal))
        };
        out.axes = geometry.axes;
        out.curvatures = geometry.curvatures;
        out.distance = geometry.distance;
    }
    out
}

/// The axes made normal to a last axis that has turned a little.
fn turned_axes<const D: usize>(axes: &SMatrix<f64, D, D>, normal: &SVector<f64, D>) -> SMatrix<f64, D, D> {
    let mut out = *axes;
    out.set_column(D - 1, normal);
    for i in 0..D - 1 {
        let mut axis = axes.column(i).into_owned();
        axis -= normal * normal.dot(&axis);
        for j in 0..i {
            let other = out.column(j).into_owned();
            axis -= other * other.dot(&axis);
        }
        out.set_column(i, &axis.normalize());
    }
    out
}
