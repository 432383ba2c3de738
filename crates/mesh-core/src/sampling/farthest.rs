//! Farthest point sampling.

use nalgebra::Point3;

use crate::BoundingBox;
use crate::bounds::is_finite;

/// Indices of up to `count` points, each the farthest from all that were chosen before it.
///
/// The first is the farthest from the centre of the bounding box; of equally far points the one of the smallest index
/// is chosen. Points that are not finite are never chosen, and points at the position of a chosen one neither, so
/// that fewer than `count` may be found. Takes O(n · count).
#[must_use]
pub fn farthest_points(points: &[Point3<f64>], count: usize) -> Vec<usize> {
    let Some(bounds) = BoundingBox::of(points) else { return Vec::new() };
    // Coordinates relative to the centre in units of the size, so that squares neither overflow nor underflow.
    let (centre, size) = (bounds.centre(), 0.5 * bounds.extent().amax());
    let size = if size > 0.0 && size.is_finite() { size } else { 1.0 };
    let (indices, positions): (Vec<usize>, Vec<[f64; 3]>) = (points.iter().enumerate())
        .filter(|(_, point)| is_finite(point))
        .map(|(index, point)| (index, <[f64; 3]>::from((point - centre) / size)))
        .unzip();
    let mut chosen = Vec::with_capacity(count.min(indices.len()));
    let mut distances = vec![f64::INFINITY; positions.len()];
    let mut latest = [0.0; 3];
    while chosen.len() < count {
        let mut farthest = (0.0, None);
        for (place, (position, distance)) in positions.iter().zip(&mut distances).enumerate() {
            let [x, y, z] = [position[0] - latest[0], position[1] - latest[1], position[2] - latest[2]];
            let distance_sq = x * x + y * y + z * z;
            // Distances from the centre serve for the first choice only.
            let now = if chosen.is_empty() { distance_sq } else { distance.min(distance_sq) };
            if !chosen.is_empty() {
                *distance = now;
            }
            if now > farthest.0 || farthest.1.is_none() && chosen.is_empty() {
                farthest = (now, Some(place));
            }
        }
        let Some(place) = farthest.1 else { break };
        chosen.push(indices[place]);
        latest = positions[place];
    }
    chosen
}
