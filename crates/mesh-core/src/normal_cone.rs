//! Cones of normals over the nodes of a hierarchy: which parts of a mesh may face a direction.

use nalgebra::Vector3;
use std::f64::consts::PI;

/// Angle that rounding may take from a cone.
const SLACK: f64 = 1e-6;

/// A cone that holds unit normals: those within `angle` of `axis`; all when that is at least π, none when it is negative.
#[derive(Debug, Clone, Copy)]
pub(crate) struct NormalCone {
    axis: Vector3<f64>,
    angle: f64,
}

impl NormalCone {
    /// No normal at all.
    pub(crate) const EMPTY: Self = Self { axis: Vector3::new(0.0, 0.0, 0.0), angle: -1.0 };

    /// The normal of a triangle; a triangle without area has none.
    pub(crate) fn of(normal: &Vector3<f64>) -> Self {
        if *normal == Vector3::zeros() { Self::EMPTY } else { Self { axis: *normal, angle: 0.0 } }
    }

    /// The smallest cone around two cones.
    pub(crate) fn merged(&self, other: &Self) -> Self {
        if self.angle < 0.0 || other.angle >= PI {
            return *other;
        }
        if other.angle < 0.0 || self.angle >= PI {
            return *self;
        }
        let between = angle(&self.axis, &other.axis);
        if between + other.angle <= self.angle {
            return *self;
        }
        if between + self.angle <= other.angle {
            return *other;
        }
        let half = 0.5 * (between + self.angle + other.angle) + SLACK;
        // From the first axis towards the second one.
        let across = other.axis - self.axis * self.axis.dot(&other.axis);
        match across.try_normalize(0.0) {
            Some(across) if half < PI => {
                let (sine, cosine) = (half - self.angle).sin_cos();
                Self { axis: self.axis * cosine + across * sine, angle: half }
            }
            // Opposite axes have no plane in common.
            _ => Self { axis: self.axis, angle: PI },
        }
    }

    /// Whether a normal of the cone may lie within `most` of a unit direction.
    pub(crate) fn may_face(&self, direction: &Vector3<f64>, most: f64) -> bool {
        self.angle >= PI
            || self.angle >= 0.0 && angle(&self.axis, direction) <= self.angle + most + 2.0 * SLACK
    }
}

/// The angle between two vectors of length 1, well conditioned everywhere.
fn angle(a: &Vector3<f64>, b: &Vector3<f64>) -> f64 {
    a.cross(b).norm().atan2(a.dot(b))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        /// No merge, in whatever order, leaves out one of its normals.
        #[test]
        fn cones_hold_what_was_put_into_them(
            values in prop::collection::vec(prop::array::uniform3(-1.0..1.0f64), 1..20),
            direction in prop::array::uniform3(-1.0..1.0f64),
            most in 0.0..3.0f64,
        ) {
            let unit = |v: [f64; 3]| Vector3::from(v).try_normalize(1e-3);
            let normals: Vec<Vector3<f64>> = values.into_iter().filter_map(unit).collect();
            let direction = unit(direction).unwrap_or_else(Vector3::x);
            let left = normals.iter().fold(NormalCone::EMPTY, |cone, n| cone.merged(&NormalCone::of(n)));
            let right = normals.iter().rev().fold(NormalCone::EMPTY, |cone, n| NormalCone::of(n).merged(&cone));
            for cone in [left, right, left.merged(&right)] {
                let faces = normals.iter().any(|n| n.dot(&direction) >= most.cos());
                prop_assert!(!faces || cone.may_face(&direction, most));
            }
        }
    }

    #[test]
    fn a_narrow_cone_is_refused() {
        let tilted = Vector3::new(0.1, 0.0, 1.0).normalize();
        let cone = NormalCone::of(&Vector3::z()).merged(&NormalCone::of(&tilted));
        assert!(cone.may_face(&Vector3::z(), 0.1) && !cone.may_face(&-Vector3::z(), 1.0));
        assert!(!NormalCone::EMPTY.may_face(&Vector3::z(), 3.0));
        assert!(
            NormalCone::of(&Vector3::z())
                .merged(&NormalCone::of(&-Vector3::z()))
                .may_face(&Vector3::x(), 0.1)
        );
    }
}
