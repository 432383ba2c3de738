//! Whether points lie about a curve, or are too wide or too structured for that.

use super::stop::Stop;
use crate::parallel;
use distance_field::quantile_in_place;
use mesh_core::CloudIndex;
use nalgebra::{Point, SVector};

/// Standard deviation of the points as a share of the length of the curve from which on they are no curve.
const THICK: f64 = 0.03;
/// Neighbourhood in units of the root mean square distance, how far along the curve those in it may be, and the share of pairs further apart, in the
/// mean along the curve, from which on the points are no curve.
const ABOUT: f64 = 4.0;
const ALONG: f64 = 3.0;
const FOREIGN: f64 = 0.15;
/// Points whose neighbourhoods are looked at, at most.
const LOOKED_AT: usize = 400;
/// Root mean square distance in spacings, and number of points, from which on it is asked how they lie about the curve.
const WIDE: f64 = 1.5;
const LEAST: usize = 40;
/// Mean squared difference of neighbours along the curve in units of the mean square from which on they are different: 2 for noise.
const ALIKE: f64 = 1.0;
/// Mean fourth power of distances in units of the square of their mean square below which there are few in the middle: 3 for a normal and 1.8 for a
/// uniform distribution in the plane, 2 and 1.33 in space; 1 for two lines beside the curve, or a tube about it. In the mean of all neighbourhoods.
const KURTOSIS: [f64; 2] = [1.6, 1.25];
/// In those of a share of the length: elsewhere the lines may come together.
const APART: f64 = 0.3;
const KURTOSIS_APART: [f64; 2] = [1.5, 1.2];
/// Points next to each other along the curve whose distances are compared.
const AROUND: usize = 24;
/// Neighbours of which the nearest at another place is taken, width of a cloud in units of its standard deviation, and distance of its points as a share
/// of what they have to themselves below which they lie on lines.
const NEIGHBOURS: usize = 6;
const BAND: f64 = 3.5;
const LINE: f64 = 0.4;

/// Whether the points lie so far about the curve that neighbours among them belong to parts of it that are far from each other.
pub(super) fn spreads<const D: usize>(
    stops: &[Stop<D>],
    points: &[SVector<f64, D>],
    total: f64,
    closed: bool,
) -> bool {
    let squares: f64 = stops.iter().map(|s| s.residual.norm_squared()).sum();
    let rms = (squares / stops.len() as f64).sqrt();
    if rms > THICK * total {
        return true;
    }
    let places: Vec<Point<f64, D>> = points.iter().copied().map(Point::from).collect();
    let Ok(index) = CloudIndex::new(&places) else { return false };
    if in_lanes(stops, &places, &index, rms, total / stops.len() as f64) {
        return true;
    }
    // Points may be dense where parts of the curve come near to each other, as at the ends of a thin section: its length counts.
    let mut at = vec![0.0; points.len()];
    let mut own = vec![0.0; points.len()];
    for (k, stop) in stops.iter().enumerate() {
        let before = if k > 0 { stop.at - stops[k - 1].at } else { 0.0 };
        let behind = stops.get(k + 1).map_or(0.0, |next| next.at - stop.at);
        at[stop.index] = stop.at;
        own[stop.index] = 0.5 * (before + behind);
    }
    let reach = ABOUT * rms;
    let stride = points.len().div_ceil(LOOKED_AT).max(1);
    let looked: Vec<usize> = (0..points.len()).step_by(stride).collect();
    let shares = parallel::tasks(looked.len(), |k| {
        let i = looked[k];
        let near = index.within(&places[i], reach);
        let foreign = near.iter().filter(|n| {
            let apart = (at[n.index] - at[i]).abs();
            let apart = if closed { apart.min(total - apart) } else { apart };
            apart > ALONG * reach
        });
        (own[i], own[i] * foreign.count() as f64 / (near.len().saturating_sub(1)).max(1) as f64)
    });
    let (length, foreign) = shares.iter().fold((0.0, 0.0), |sum, s| (sum.0 + s.0, sum.1 + s.1));
    foreign > FOREIGN * length
}

/// Whether there are few points in the middle along the curve: in the mean, or along a share of it. Distances are in units of those of their neighbours:
/// what lies beside the curve may come nearer to it and end on it.
fn is_hollow<const D: usize>(stops: &[Stop<D>], [mean, apart]: [f64; 2]) -> bool {
    let (mut sum, mut count) = (0.0, 0.0);
    let (mut beside, mut length) = (0.0, 0.0);
    for part in stops.chunks(AROUND).filter(|part| 2 * part.len() > AROUND) {
        let own = part.len() as f64;
        let square = part.iter().map(|s| s.residual.norm_squared()).sum::<f64>() / own;
        let fourth = part.iter().map(|s| s.residual.norm_squared().powi(2)).sum::<f64>() / own;
        let kurtosis = fourth / (square * square).max(f64::MIN_POSITIVE);
        sum += kurtosis * own;
        count += own;
        let part_length = part[part.len() - 1].at - part[0].at;
        length += part_length;
        beside += if kurtosis < apart { part_length } else { 0.0 };
    }
    sum < mean * count || beside > APART * length
}

/// Whether the points lie beside the curve rather than about it: on both sides of it with few in the middle, or on thin lines.
///
/// Neighbours along the curve are then as different as with noise, but their distances have no normal distribution, or points are much
/// nearer to each other than those of a cloud of that width.
fn in_lanes<const D: usize>(
    stops: &[Stop<D>],
    places: &[Point<f64, D>],
    index: &CloudIndex<D>,
    rms: f64,
    spacing: f64,
) -> bool {
    let kurtosis = match D {
        2 => [KURTOSIS[0], KURTOSIS_APART[0]],
        3 => [KURTOSIS[1], KURTOSIS_APART[1]],
        _ => return false,
    };
    if rms <= WIDE * spacing || stops.len() < LEAST {
        return false;
    }
    let count = stops.len() as f64;
    let changes: f64 = stops.windows(2).map(|s| (s[1].residual - s[0].residual).norm_squared()).sum();
    if changes < ALIKE * count * rms * rms {
        return false;
    }
    if is_hollow(stops, kurtosis) {
        return true;
    }
    // In units of half the side of the square, or of the cube, that a point of the cloud has to itself there.
    let stride = stops.len().div_ceil(LOOKED_AT).max(1);
    let looked: Vec<usize> = (0..stops.len()).step_by(stride).collect();
    let mut nearest = parallel::tasks(looked.len(), |k| {
        let (first, last) =
            (looked[k].saturating_sub(AROUND / 2), (looked[k] + AROUND / 2).min(stops.len() - 1));
        let along = (stops[last].at - stops[first].at) / (last - first) as f64;
        let own = if D == 2 { along * BAND * rms } else { along * (BAND * rms).powi(2) };
        let near = index.nearest_n(&places[stops[looked[k]].index], NEIGHBOURS);
        let distance = near.iter().map(|n| n.distance()).find(|d| *d > 0.0).unwrap_or(f64::INFINITY);
        distance / (0.5 * own.powf(1.0 / D as f64)).max(f64::MIN_POSITIVE)
    });
    quantile_in_place(&mut nearest, 0.5) < LINE
}
