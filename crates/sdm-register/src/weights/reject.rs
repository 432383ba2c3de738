//! Points that are left out for where their foot is.

use distance_field::PrincipalFrame;
use nalgebra::SVector;

/// Rules by which a point is left out of a step, whatever the kernel. All are off by default.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(default))]
pub struct Rejection {
    /// Largest distance that counts, in the model's unit.
    pub abs_distance: Option<f64>,
    /// Largest angle between the normal of a point and that of the shape, radians; only for points with a normal.
    pub normal_angle: Option<f64>,
    /// Whether the sides of the normals count: if not (default), a normal and its opposite are the same.
    pub oriented_normals: bool,
    /// Whether points whose foot is on a boundary of the shape are left out.
    pub boundary: bool,
}

impl Rejection {
    /// The same rules with a largest distance.
    #[must_use]
    pub fn with_abs_distance(self, distance: f64) -> Self {
        Self { abs_distance: Some(distance), ..self }
    }

    /// The same rules with a largest angle between normals.
    #[must_use]
    pub fn with_normal_angle(self, angle: f64) -> Self {
        Self { normal_angle: Some(angle), ..self }
    }

    /// The same rules with or without the points at boundaries.
    #[must_use]
    pub fn with_boundary(self, boundary: bool) -> Self {
        Self { boundary, ..self }
    }

    /// Whether a point stays.
    pub(crate) fn keeps<const D: usize>(
        &self,
        frame: &PrincipalFrame<D>,
        normal: Option<&SVector<f64, D>>,
    ) -> bool {
        if self.boundary && frame.on_boundary {
            return false;
        }
        if self.abs_distance.is_some_and(|limit| frame.distance.abs() > limit) {
            return false;
        }
        let angle = self.normal_angle.zip(normal.filter(|n| n.norm_squared() > 0.0));
        angle.is_none_or(|(limit, normal)| {
            let cosine = normal.dot(&frame.normal());
            let cosine = if self.oriented_normals { cosine } else { cosine.abs() };
            cosine >= limit.cos()
        })
    }
}
