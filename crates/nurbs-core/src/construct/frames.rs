//! Rotation minimising frames.

use crate::{Error, ParametricCurve};
use nalgebra::Vector3;

/// A right-handed orthonormal frame at a point of a path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PathFrame {
    /// Parameter of the path.
    pub parameter: f64,
    /// Point of the path.
    pub point: Vector3<f64>,
    /// Unit tangent.
    pub tangent: Vector3<f64>,
    /// First unit vector normal to the path.
    pub normal: Vector3<f64>,
    /// Second one, `tangent × normal`.
    pub binormal: Vector3<f64>,
}

impl PathFrame {
    /// Where a point goes that moves rigidly with the frame from `self` to `to`.
    #[must_use]
    pub fn carry(&self, to: &Self, point: &Vector3<f64>) -> Vector3<f64> {
        let d = point - self.point;
        to.point
            + to.tangent * d.dot(&self.tangent)
            + to.normal * d.dot(&self.normal)
            + to.binormal * d.dot(&self.binormal)
    }
}

/// Frames at the given parameters of a path that turn about its tangent as little as possible, by double
/// reflection ([WJZL08, sec. 4]; the error falls with the fourth power of the parameter steps).
///
/// The first normal is the part of `reference` normal to the path, or, without one, the principal normal,
/// or where the path is straight some normal direction that only depends on the tangent.
///
/// # Errors
/// [`Error::Argument`] when there are no parameters, the path has no tangent at one of them, or the
/// reference direction is zero, not finite or tangent to the path.
pub fn rotation_minimizing_frames<C: ParametricCurve<3> + ?Sized>(
    path: &C,
    parameters: &[f64],
    reference: Option<&Vector3<f64>>,
) -> Result<Vec<PathFrame>, Error> {
    let Some(&first) = parameters.first() else {
        return Err(Error::argument("no parameters for the frames of a path; give at least one"));
    };
    let mut normal = start_normal(path, first, reference)?;
    let mut frames: Vec<PathFrame> = Vec::with_capacity(parameters.len());
    for &parameter in parameters {
        let jet = path.jet(parameter);
        let tangent = jet.unit_tangent().ok_or_else(|| singular(parameter))?;
        if let Some(last) = frames.last() {
            normal = double_reflection(last, &jet.point, &tangent);
        }
        // Rounding must not build up over thousands of steps.
        normal = (normal - tangent * tangent.dot(&normal)).normalize();
        let binormal = tangent.cross(&normal);
        frames.push(PathFrame { parameter, point: jet.point, tangent, normal, binormal });
    }
    Ok(frames)
}

fn singular(parameter: f64) -> Error {
    Error::argument(format!(
        "the path has no tangent at parameter {parameter}; split it there or choose a regular path"
    ))
}

fn start_normal<C: ParametricCurve<3> + ?Sized>(
    path: &C,
    parameter: f64,
    reference: Option<&Vector3<f64>>,
) -> Result<Vector3<f64>, Error> {
    let jet = path.jet(parameter);
    let tangent = jet.unit_tangent().ok_or_else(|| singular(parameter))?;
    let given = match (reference, jet.frenet_frame()) {
        (Some(direction), _) => direction.unscale(direction.amax()),
        (None, Some(frame)) => frame.normal,
        (None, None) => {
            let mut axis = Vector3::zeros();
            axis[tangent.iamin()] = 1.0;
            axis
        }
    };
    let normal = given - tangent * tangent.dot(&given);
    let length = normal.norm();
    if length > 1e-9 {
        return Ok(normal / length);
    }
    let what = format!("the reference direction {given:?} has no part normal to the path at its start");
    Err(Error::argument(what))
}

/// The normal after the step from `last` to `point`: reflected in the plane between the points, and
/// then in the one that takes the reflected tangent to the new one ([WJZL08, table I]).
fn double_reflection(last: &PathFrame, point: &Vector3<f64>, tangent: &Vector3<f64>) -> Vector3<f64> {
    let reflect = |vector: &Vector3<f64>, mirror: &Vector3<f64>| {
        let squared = mirror.norm_squared();
        // No step, or no turn: nothing to reflect in.
        if squared > 0.0 { vector - mirror * (2.0 / squared * mirror.dot(vector)) } else { *vector }
    };
    let step = point - last.point;
    let normal = reflect(&last.normal, &step);
    let carried = reflect(&last.tangent, &step);
    reflect(&normal, &(tangent - carried))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Frame, Helix};

    #[test]
    fn a_helix_turns_its_frame_by_minus_the_torsion() {
        let helix = Helix::new(Frame::WORLD, 2.0, 3.0, 1.5).unwrap();
        let mut errors = Vec::new();
        for n in [40, 80] {
            let parameters: Vec<f64> = (0..=n).map(|i| helix.domain().lerp(i as f64 / n as f64)).collect();
            let frames = rotation_minimizing_frames(&helix, &parameters, None).unwrap();
            let (first, last) = (&frames[0], &frames[n]);
            let frenet = |f: &PathFrame| helix.jet(f.parameter).frenet_frame().unwrap();
            assert!((first.normal - frenet(first).normal).norm() < 1e-14);
            // Against the Frenet frame, which turns by ∫ τ ds, the frame stays behind by that angle.
            let frame = frenet(last);
            let angle = last.normal.dot(&frame.binormal()).atan2(last.normal.dot(&frame.normal));
            let expected = -helix.torsion() * helix.length();
            let off = (angle - expected).rem_euclid(std::f64::consts::TAU);
            errors.push(off.min(std::f64::consts::TAU - off));
        }
        assert!(errors[0] < 1e-3 && errors[1] < errors[0] / 12.0, "{errors:?}");
    }
}
