//! Motions that the shape does not fix, by name.

use crate::Velocity;
use crate::eigen::Eigen;
use crate::motion::rotations;
use nalgebra::{DMatrix, SVector, Vector3};
use std::fmt;

/// Share of a velocity below which its rotation counts as none, and its pitch.
const NONE: f64 = 1e-6;

/// A motion that slides the shape along itself as far as the cloud can tell.
///
/// A plane leaves two translations and a rotation, a sphere three rotations about its centre, a cylinder a translation
/// and a rotation, a surface of revolution one rotation, a helical surface one helical motion.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(tag = "kind", rename_all = "snake_case"))]
pub enum FreeMotion<const D: usize> {
    /// Along a unit direction.
    Translation {
        /// The direction.
        #[cfg_attr(feature = "serde", serde(serialize_with = "crate::report::as_slice"))]
        direction: SVector<f64, D>,
    },
    /// About an axis in space, or a point in the plane.
    Rotation {
        /// Unit direction of the axis; `z` for the plane.
        #[cfg_attr(feature = "serde", serde(serialize_with = "crate::report::as_slice"))]
        axis: Vector3<f64>,
        /// The point of the axis next to the centre of the cloud, in the model's coordinates.
        #[cfg_attr(feature = "serde", serde(serialize_with = "crate::report::as_slice"))]
        point: SVector<f64, D>,
    },
    /// Along a helix.
    Helical {
        /// Unit direction of the axis.
        #[cfg_attr(feature = "serde", serde(serialize_with = "crate::report::as_slice"))]
        axis: Vector3<f64>,
        /// The point of the axis next to the centre of the cloud, in the model's coordinates.
        #[cfg_attr(feature = "serde", serde(serialize_with = "crate::report::as_slice"))]
        point: SVector<f64, D>,
        /// Translation along the axis per radian.
        pitch: f64,
    },
    /// The size cannot be told: growth from a point.
    Growth {
        /// The point that stays, in the model's coordinates.
        #[cfg_attr(feature = "serde", serde(serialize_with = "crate::report::as_slice"))]
        point: SVector<f64, D>,
    },
}

impl<const D: usize> FreeMotion<D> {
    /// The velocity fields of a space of free motions, by name: its translations first, then one motion for each
    /// rotation that is left. `origin` is that of the fields, `length` the size of the cloud.
    pub(crate) fn name_all(fields: &[Velocity<D>], origin: &SVector<f64, D>, length: f64) -> Vec<Self> {
        let mut named = Vec::new();
        // Combinations without a rotation are the null space of the Gram matrix of the rotations (and growths).
        let turn = |v: &Velocity<D>| v.rotation.insert_row(3, v.growth);
        let gram =
            DMatrix::from_fn(fields.len(), fields.len(), |i, j| turn(&fields[i]).dot(&turn(&fields[j])));
        let eigen = Eigen::new(gram);
        let combine = |k: usize| {
            fields.iter().zip(eigen.vectors.column(k).iter()).fold(
                Velocity::zero(),
                |sum: Velocity<D>, (v, &f)| Velocity {
                    translation: sum.translation + v.translation * f,
                    rotation: sum.rotation + v.rotation * f,
                    growth: sum.growth + v.growth * f,
                },
            )
        };
        let turns = |k: &usize| eigen.values[*k] > NONE * NONE;
        let mut directions: Vec<SVector<f64, D>> = Vec::new();
        for k in (0..fields.len()).filter(|k| !turns(k)) {
            let mut direction = combine(k).translation;
            for other in &directions {
                direction -= other * other.dot(&direction);
            }
            if let Some(direction) = direction.try_normalize(0.0) {
                directions.push(direction);
                named.push(Self::Translation { direction });
            }
        }
        for k in (0..fields.len()).filter(turns) {
            let mut v = combine(k);
            for direction in &directions {
                v.translation -= direction * direction.dot(&v.translation);
            }
            named.push(Self::name(&v, origin, length));
        }
        named
    }

    /// One field with a rotation or growth.
    fn name(v: &Velocity<D>, origin: &SVector<f64, D>, length: f64) -> Self {
        let square = v.rotation.norm_squared();
        if square < v.growth * v.growth {
            return Self::Growth { point: origin - v.translation / v.growth };
        }
        if rotations(D) == 1 {
            // v(x) = c̄ + ω (−x₂, x₁) vanishes at (−c̄₂, c̄₁)/ω.
            let mut point = *origin;
            point[0] -= v.translation[1] / v.rotation.x;
            point[1] += v.translation[0] / v.rotation.x;
            return Self::Rotation { axis: Vector3::z(), point };
        }
        let axis = v.rotation / square.sqrt();
        let translation = Vector3::from_fn(|i, _| v.translation[i]);
        let from_origin = v.rotation.cross(&translation) / square;
        let point = SVector::from_fn(|i, _| origin[i] + from_origin[i]);
        let pitch = v.pitch().unwrap_or(0.0);
        if pitch.abs() <= NONE * length {
            Self::Rotation { axis, point }
        } else {
            Self::Helical { axis, point, pitch }
        }
    }
}

/// `(x, y, z)` with six digits.
fn list<const N: usize>(f: &mut fmt::Formatter<'_>, v: &SVector<f64, N>) -> fmt::Result {
    f.write_str("(")?;
    for (i, c) in v.iter().enumerate() {
        // No sign before a zero.
        let c = if c.abs() < 5e-7 { 0.0 } else { *c };
        write!(f, "{}{c:.6}", if i > 0 { ", " } else { "" })?;
    }
    f.write_str(")")
}

impl<const D: usize> fmt::Display for FreeMotion<D> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Translation { direction } => {
                f.write_str("translation along ")?;
                list(f, direction)
            }
            Self::Rotation { axis, point } => {
                f.write_str("rotation about ")?;
                if D == 3 {
                    f.write_str("axis ")?;
                    list(f, axis)?;
                    f.write_str(" through ")?;
                }
                list(f, point)
            }
            Self::Helical { axis, point, pitch } => {
                f.write_str("helical motion about axis ")?;
                list(f, axis)?;
                f.write_str(" through ")?;
                list(f, point)?;
                write!(f, " with pitch {pitch:.6}")
            }
            Self::Growth { point } => {
                f.write_str("growth from ")?;
                list(f, point)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn turn(axis: Vector3<f64>, point: Vector3<f64>, pitch: f64) -> Velocity<3> {
        Velocity { translation: axis * pitch - axis.cross(&point), rotation: axis, growth: 0.0 }
    }

    fn slide(direction: Vector3<f64>) -> Velocity<3> {
        Velocity { translation: direction, ..Velocity::zero() }
    }

    #[test]
    fn the_classical_shapes() {
        let origin = Vector3::new(10.0, 0.0, 0.0);
        let names = |fields: &[Velocity<3>]| {
            FreeMotion::name_all(fields, &origin, 1.0)
                .iter()
                .map(ToString::to_string)
                .collect::<Vec<_>>()
                .join("; ")
        };
        let point = Vector3::new(1.0, 2.0, 0.0);
        assert_eq!(
            names(&[turn(Vector3::z(), point, 0.0)]),
            "rotation about axis (0.000000, 0.000000, 1.000000) through (11.000000, 2.000000, 0.000000)"
        );
        assert!(names(&[turn(Vector3::z(), point, 0.5)]).ends_with("with pitch 0.500000"));
        // A cylinder, given by two helical motions.
        let cylinder = names(&[turn(Vector3::z(), point, 0.5), turn(Vector3::z(), point, -1.0)]);
        assert!(
            cylinder.starts_with("translation along") && cylinder.contains("; rotation about"),
            "{cylinder}"
        );
        let plane = [slide(Vector3::x()), slide(Vector3::y() * 3.0), turn(Vector3::z(), point, 0.0)];
        let plane = names(&plane);
        assert_eq!((plane.matches("translation").count(), plane.matches("rotation").count()), (2, 1));
        let sphere = [Vector3::x(), Vector3::y(), Vector3::z()].map(|axis| turn(axis, point, 0.0));
        assert_eq!(names(&sphere).matches("through").count(), 3);
        let in_plane =
            Velocity::<2> { translation: SVector::from([2.0, -1.0]), rotation: Vector3::x(), growth: 0.0 };
        let named = FreeMotion::name_all(&[in_plane], &SVector::zeros(), 1.0);
        assert_eq!(named, [FreeMotion::Rotation { axis: Vector3::z(), point: SVector::from([1.0, 2.0]) }]);
        assert!(in_plane.at(&SVector::from([1.0, 2.0])).norm() < 1e-15);
    }
}
