//! Poses in the plane from which a registration without a guess may start.

use crate::commands::register::field::RegistrationField;
use industrial_geometry::mesh::nalgebra::{Matrix3, Vector3};
use industrial_geometry::nurbs::Aabb;
use industrial_geometry::register::Pose;
use std::f64::consts::TAU;

/// Rotations that are looked at, and the places of the centre of the points for each: that of the model, and around it.
const ROTATIONS: u16 = 72;
const PLACES: [[f64; 2]; 5] = [[0.0, 0.0], [0.25, 0.0], [-0.25, 0.0], [0.0, 0.25], [0.0, -0.25]];
/// Points by which they are compared.
const POINTS: usize = 500;
/// Poses that are given back.
const MOST: usize = 8;

/// Rotations about z that carry the centre of the points to that of the model or near it, the best first.
pub(crate) fn poses(field: &RegistrationField, points: &[Vector3<f64>], scale: bool) -> Vec<Pose<3>> {
    let finite: Vec<Vector3<f64>> =
        points.iter().filter(|x| x.iter().all(|c| c.is_finite())).copied().collect();
    let Some(bounds) = Aabb::of_points(&finite) else { return Vec::new() };
    let some: Vec<Vector3<f64>> =
        finite.iter().step_by(finite.len().div_ceil(POINTS).max(1)).copied().collect();
    let growth = if scale { field.relative_size(points) } else { 1.0 };
    let mut scored = Vec::new();
    for step in 0..ROTATIONS {
        let (sine, cosine) = (TAU * f64::from(step) / f64::from(ROTATIONS)).sin_cos();
        let rotation = Matrix3::new(cosine, -sine, 0.0, sine, cosine, 0.0, 0.0, 0.0, 1.0);
        for [x, y] in PLACES {
            let offset = Vector3::new(x, y, 0.0) * field.diagonal();
            let pose = Pose {
                scale: growth,
                rotation,
                source_origin: bounds.centre(),
                target_origin: field.centre() + offset,
            };
            let moved: Vec<Vector3<f64>> = some.iter().map(|x| pose.apply(x)).collect();
            // Robust against points that lie nowhere, and against large ones: the mean of the square roots.
            let distances = field.distances(&moved);
            let score = distances.iter().map(|d| d.sqrt()).sum::<f64>() / distances.len().max(1) as f64;
            scored.push((score, pose));
        }
    }
    scored.sort_by(|one, other| one.0.total_cmp(&other.0));
    scored.into_iter().take(MOST).map(|(_, pose)| pose).collect()
}
