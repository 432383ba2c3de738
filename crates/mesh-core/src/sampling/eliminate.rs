//! Thinning points out evenly.

use std::collections::BinaryHeap;

use nalgebra::Point3;

use crate::{CloudIndex, Error};

/// Exponent of the weights, and the factor of the distance below which weights no longer grow ([Yu15, sec. 3.1]).
const ALPHA: i32 = 8;
const BETA: f64 = 0.65;
const GAMMA: f64 = 1.5;

/// Indices of `count` out of points on a surface of the given area that keep as far from each other as so many can.
///
/// The point that crowds its neighbours most is eliminated until `count` are left (\[Yu15\]). Of equally crowded points the
/// one of the largest index goes first. The indices ascend. Points that are not finite are never among them, so that
/// fewer than `count` may be left.
///
/// # Errors
/// [`Error::OutOfRange`] if the area is not positive and finite, [`Error::TooMany`] beyond 32-bit indices.
pub fn eliminate_samples(points: &[Point3<f64>], count: usize, area: f64) -> Result<Vec<usize>, Error> {
    if !(area > 0.0 && area.is_finite()) {
        return Err(Error::OutOfRange { what: "area", value: area, least: f64::MIN_POSITIVE });
    }
    let index = CloudIndex::new(points)?;
    let finite: Vec<bool> = points.iter().map(crate::bounds::is_finite).collect();
    if index.len() <= count {
        return Ok((0..points.len()).filter(|&i| finite[i]).collect());
    }
    if count == 0 {
        return Ok(Vec::new());
    }
    // Radius of disks in the densest packing of `count` of them.
    let largest = (area / (2.0 * 3f64.sqrt() * count as f64)).sqrt();
    let least = largest * (1.0 - (count as f64 / index.len() as f64).powf(GAMMA)) * BETA;
    let weight =
        |distance: f64| (1.0 - distance.clamp(2.0 * least, 2.0 * largest) / (2.0 * largest)).powi(ALPHA);
    let neighbours = index.map_within(points, 2.0 * largest, |i, near| {
        (near.iter().filter(|other| other.index != i))
            .map(|other| (other.index, weight(other.distance())))
            .collect::<Vec<_>>()
    });
    let mut weights: Vec<f64> =
        neighbours.iter().map(|near| near.iter().map(|(_, weight)| weight).sum()).collect();
    // Not negative, so their bits order them. Entries that are out of date are passed over.
    let mut heap: BinaryHeap<(u64, usize)> =
        (0..points.len()).filter(|&i| finite[i]).map(|i| (weights[i].to_bits(), i)).collect();
    let mut kept = finite;
    let mut left = index.len();
    while left > count {
        let Some((bits, worst)) = heap.pop() else { break };
        if !kept[worst] || bits != weights[worst].to_bits() {
            continue;
        }
        kept[worst] = false;
        left -= 1;
        for &(other, weight) in neighbours[worst].iter().filter(|(other, _)| kept[*other]) {
            let less = (weights[other] - weight).max(0.0);
            if less.to_bits() != weights[other].to_bits() {
                weights[other] = less;
                heap.push((less.to_bits(), other));
            }
        }
    }
    Ok((0..points.len()).filter(|&i| kept[i]).collect())
}
