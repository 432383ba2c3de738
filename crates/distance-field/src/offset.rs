//! The distance from offsets.

use crate::{DistanceField, Error, Hint, PrincipalFrame, Search};
use footpoint::Status;
use nalgebra::SVector;
use nurbs_core::Aabb;

/// The distance from the offset of a shape, the points at a signed distance `r` from it: where the axis of a cutter of radius
/// `r` runs that is to generate the shape (\[P05, sec. 4.5\]).
///
/// The foot of a query on the offset lies on the same normal, `r` away from the foot on the shape, and the radii of curvature
/// differ by `r`. Around an edge or corner the offset is part of a tube or sphere. Where the shape bends more strongly than a
/// circle of radius `r` on its side, the offset has a gap or a self-intersection, and queries have no usable frame; fits
/// leave such samples out.
///
/// ```
/// use distance_field::{AnalyticField, DistanceField, Hint, OffsetField, Search};
/// use nalgebra::Vector3;
/// use nurbs_core::{Frame, Sphere};
///
/// let sphere = AnalyticField::new(Sphere::new(Frame::WORLD, 2.0)?)?;
/// let frame = OffsetField::new(sphere, 0.5)?.frame(&Vector3::new(0.0, 3.0, 0.0), Search::Global, &Hint::NONE);
/// assert!((frame.distance - 0.5).abs() < 1e-15 && (frame.curvatures[0] + 1.0 / 2.5).abs() < 1e-15);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct OffsetField<F> {
    field: F,
    radius: f64,
}

impl<F> OffsetField<F> {
    /// The offset of a shape at a signed distance: positive on the side of the normal, and for shapes without sides.
    ///
    /// # Errors
    /// [`Error::Option`] for a distance that is not finite.
    pub fn new(field: F, distance: f64) -> Result<Self, Error> {
        if !distance.is_finite() {
            return Err(Error::Option { option: "distance", value: distance, what: "a finite length" });
        }
        Ok(Self { field, radius: distance })
    }

    fn moved<const D: usize>(&self, mut frame: PrincipalFrame<D>) -> PrincipalFrame<D> {
        let r = self.radius;
        if r == 0.0 || !frame.is_finite() {
            return frame;
        }
        let smooth = frame.tangent_dimension;
        // An edge or corner has an offset only on the side on which the query sees it.
        if smooth < D - 1 && r * frame.distance < 0.0 {
            return PrincipalFrame::invalid(Status::Diverged);
        }
        for i in 0..D - 1 {
            if i >= smooth {
                frame.curvatures[i] = -1.0 / r;
                continue;
            }
            let stretch = 1.0 - r * frame.curvatures[i];
            if stretch <= 0.0 {
                return PrincipalFrame::invalid(Status::Diverged);
            }
            frame.curvatures[i] /= stretch;
        }
        frame.tangent_dimension = D - 1;
        frame.foot += frame.normal() * r;
        frame.distance -= r;
        frame
    }
}

impl<const D: usize, F: DistanceField<D>> DistanceField<D> for OffsetField<F> {
    fn frame(&self, x: &SVector<f64, D>, search: Search, hint: &Hint) -> PrincipalFrame<D> {
        self.moved(self.field.frame(x, search, hint))
    }

    fn frames(&self, points: &[SVector<f64, D>], search: Search, hints: &[Hint]) -> Vec<PrincipalFrame<D>> {
        let mut frames = self.field.frames(points, search, hints);
        frames.iter_mut().for_each(|frame| *frame = self.moved(*frame));
        frames
    }

    fn bounding_box(&self) -> Aabb<D> {
        self.field.bounding_box().inflated(self.radius.abs())
    }
}
