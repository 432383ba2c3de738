//! Motions that the points of a scan leave free, though the model would fix them.

use crate::start::{OrientedPoints, thin_evenly};
use crate::{FreeMotion, rotation};
use distance_field::{DistanceField, Search};
use nalgebra::Vector3;

/// Samples of the model that are moved.
const SAMPLES: usize = 3000;
/// How far along a direction, as shares of the size of the model.
const SHIFTS: [f64; 4] = [-0.1, -0.03, 0.03, 0.1];
/// How far about an axis, radians.
const TURNS: [f64; 5] = [0.1, 0.5, 1.3, 2.9, 4.4];
/// Distance from the model, as a share of its size, that is none.
const NONE: f64 = 1e-3;
/// Share of the samples that leave the model, at least, where it fixes a motion.
const LEAVING: f64 = 5e-4;

impl FreeMotion<3> {
    /// Whether the model itself fixes a motion that points leave free, so that more points of it would tell: those of a shaft away from its
    /// keyway and its ends leave open what a shaft without them has none of.
    ///
    /// `samples` are points spread evenly over the model. Those that leave it over its boundary do not count: an open model ends somewhere,
    /// and that fixes nothing. Growth is not judged.
    #[must_use]
    pub fn is_fixed_by(&self, field: &dyn DistanceField<3>, samples: &OrientedPoints) -> bool {
        let size = field.bounding_box().diagonal();
        let points: Vec<Vector3<f64>> =
            thin_evenly(samples.len(), SAMPLES).into_iter().map(|i| samples.points()[i]).collect();
        let leaves = |motion: &dyn Fn(&Vector3<f64>) -> Vector3<f64>| {
            let moved: Vec<Vector3<f64>> = points.iter().map(motion).collect();
            let frames = field.frames(&moved, Search::Global, &[]);
            let off = frames.iter().filter(|frame| !frame.on_boundary && frame.distance.abs() > NONE * size);
            off.count() as f64 > LEAVING * points.len() as f64
        };
        let turned = |axis: &Vector3<f64>, point: &Vector3<f64>, pitch: f64, angle: f64| {
            let turn = rotation::exponential::<3>(&(axis * angle)).0;
            let (axis, point) = (*axis, *point);
            move |x: &Vector3<f64>| turn * (x - point) + point + axis * (pitch * angle)
        };
        match self {
            Self::Translation { direction } => {
                SHIFTS.iter().any(|shift| leaves(&|x| x + direction * (shift * size)))
            }
            Self::Rotation { axis, point } => {
                TURNS.iter().any(|angle| leaves(&turned(axis, point, 0.0, *angle)))
            }
            Self::Helical { axis, point, pitch } => {
                let most = if *pitch == 0.0 { f64::INFINITY } else { SHIFTS[3] * size / pitch.abs() };
                TURNS.iter().any(|angle| leaves(&turned(axis, point, *pitch, angle.min(most))))
            }
            Self::Growth { .. } => false,
        }
    }
}
