//! What is kept of the surface around a point of a cloud.

use crate::local_geometry::{LocalGeometry, of_point, of_principal};
use mesh_core::{CurvatureFrame, Neighbour};
use nalgebra::{Point3, Vector3};

/// Neighbours of a point that are kept: enough for most queries within the spacing.
const KEPT: usize = 11;

/// Points around one point, itself included.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Around {
    /// The nearest ones; where there are fewer, the last one again.
    indices: [u32; KEPT],
    /// Whether the cloud does not go on in all directions.
    pub(crate) border: bool,
    /// Whether the neighbours span a plane.
    pub(crate) spans_plane: bool,
    /// All points nearer than this are among the neighbours.
    radius: f64,
    /// The distance within which the point has some six neighbours; 0 for a point that is not finite.
    pub(crate) spacing: f64,
}

impl Around {
    /// Of the nearest points, nearest first; nothing is near a point without any.
    pub(crate) fn new(near: &[Neighbour], border: bool, spans_plane: bool) -> Self {
        let Some(last) = near.get(..KEPT).unwrap_or(near).last() else {
            return Self { border, spans_plane, ..Self::default() };
        };
        let mut indices = [0; KEPT];
        let mut fits = true;
        for (k, index) in indices.iter_mut().enumerate() {
            let found = u32::try_from(near.get(k).unwrap_or(last).index);
            fits &= found.is_ok();
            *index = found.unwrap_or_default();
        }
        let radius = if near.len() > KEPT && fits { last.distance() } else { 0.0 };
        let spacing = near.get(6).or(near.last()).map_or(0.0, Neighbour::distance);
        Self { indices, border, spans_plane, radius, spacing }
    }

    /// The point nearest to `x` among those around a point at this distance, if it is surely the nearest of all.
    pub(crate) fn nearest(&self, points: &[Point3<f64>], x: &Vector3<f64>, distance: f64) -> Option<usize> {
        // Nearer points lie within twice the distance.
        if 2.0 * distance * (1.0 + 1e-9) >= self.radius {
            return None;
        }
        let squared = |index: u32| {
            let d = x - points[index as usize].coords;
            d.x * d.x + d.y * d.y + d.z * d.z
        };
        let nearest = self.indices.map(|index| (squared(index), index)).into_iter();
        let nearest = nearest.reduce(|best, other| {
            if other.0 < best.0 || other.0 == best.0 && other.1 < best.1 { other } else { best }
        });
        nearest.map(|(_, index)| index as usize)
    }
}

/// The surface at one point; meaningless where the neighbours span no plane.
#[derive(Clone, Copy, Debug)]
struct Patch {
    normal: Vector3<f64>,
    /// The direction of the first curvature. That of the second one makes up a right-handed frame with the normal.
    direction: Vector3<f64>,
    curvatures: [f64; 2],
}

/// What is kept of a point: two lines of a cache that are fetched together, since queries wait for memory.
#[derive(Clone, Copy, Debug)]
#[repr(align(128))]
pub(crate) struct Site {
    pub(crate) around: Around,
    patch: Patch,
}

impl Site {
    pub(crate) fn new(around: Around, frame: Option<&CurvatureFrame>) -> Self {
        let (normal, direction, curvatures) = match frame {
            Some(frame) => (frame.normal, frame.directions[0], frame.curvatures),
            None => (Vector3::zeros(), Vector3::zeros(), [0.0; 2]),
        };
        Self { around, patch: Patch { normal, direction, curvatures } }
    }

    /// The geometry at the point, which a residual leads away from.
    #[inline]
    pub(crate) fn geometry(&self, residual: &Vector3<f64>) -> LocalGeometry<3> {
        if !self.around.spans_plane {
            return of_point(residual, None);
        }
        let Patch { normal, direction, curvatures } = &self.patch;
        of_principal(&[*direction, normal.cross(direction)], normal, *curvatures, 0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_site_fills_two_lines_of_a_cache() {
        assert_eq!((size_of::<Around>(), size_of::<Site>()), (64, 128));
    }
}
