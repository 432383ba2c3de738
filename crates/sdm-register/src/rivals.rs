//! Poses that a model nearly tells not apart from a given one: turns about its own axes, chosen by the points that do not fit.

use crate::start::{OrientedPoints, Turning, thin_evenly};
use crate::{Pose, left_out::surface_left_out, parallel, rotation};
use distance_field::{DistanceField, Search};
use nalgebra::{Matrix3, Vector3};
use std::f64::consts::TAU;

/// Points that are looked at; of those, how many that do not fit, and that do, are turned.
const LOOKED_AT: usize = 6000;
const MISFITS: usize = 80;
const FITTING: usize = 80;
/// Distances, in standard deviations of the noise, from which a point does not fit; and the smallest noise, as a share of the size.
const CUT: f64 = 4.0;
const LEAST: f64 = 2e-4;
/// Distance beyond which all points fit alike, as a share of the size.
const LIMIT: f64 = 0.012;
/// Most poses that are found, and of those that are known to two degrees, most that are looked at more closely: at so many turns to either side,
/// radians apart.
const MOST: usize = 8;
const REFINED: usize = 24;
const BESIDE: i32 = 3;
const STEP: f64 = 0.01;
/// Root mean square displacement, as a share of the size, from which two poses are two.
const APART: f64 = 0.03;
/// Of a ball: places of the points that do not fit, places of the model that are not on the ball, and turns about each.
const FROM: usize = 4;
const TO: usize = 24;
const SPINS: usize = 24;
/// How much farther from the centre one of two such places may be than the other, as a share of the size.
const AS_FAR: f64 = 0.02;
/// Turns of the model on itself that tell which of its places are not on the ball.
const TURNS: usize = 9;

/// Poses to which turns about the model's own axes lead, if these lay most of the model on itself: those that
/// the points fit best, the best first. They are roughly known.
///
/// A flange with one of its bolt holes missing can be turned by each hole of the circle, a shaft with a keyway by any angle, a ball with a bump
/// about any axis; which turn is right is told by the few points that do not lie on the model. `samples` are points with normals spread
/// evenly over the model. Empty for models that no turn lays on themselves for the most part.
#[must_use]
pub fn rival_poses(
    field: &dyn DistanceField<3>,
    samples: &OrientedPoints,
    points: &[Vector3<f64>],
    pose: &Pose<3>,
) -> Vec<Pose<3>> {
    let Some(turning) = Turning::of(samples) else { return Vec::new() };
    let size = field.bounding_box().diagonal();
    let moved: Vec<Vector3<f64>> = thin_evenly(points.len(), LOOKED_AT)
        .into_iter()
        .map(|i| pose.apply(&points[i]))
        .filter(|x| x.iter().all(|c| c.is_finite()))
        .collect();
    let telling = Telling::of(field, moved, size);
    let centre = turning.centre;
    let turned = |rotation: &Matrix3<f64>| Pose {
        scale: 1.0,
        rotation: *rotation,
        source_origin: centre,
        target_origin: centre,
    };
    let cost = |rotation: &Matrix3<f64>| telling.cost(field, &turned(rotation), LIMIT * size);
    let mut found: Vec<(f64, Matrix3<f64>)> = Vec::new();
    let mut rough: Vec<(f64, Matrix3<f64>, Vector3<f64>)> = Vec::new();
    if turning.is_spherical {
        let all = onto_bumps(field, samples, &telling.misfits, &centre, size);
        let costs = parallel::tasks(all.len(), |k| cost(&all[k]));
        found.extend(costs.into_iter().zip(all));
    } else {
        for ring in &turning.rings {
            let count = ring.rotations.len();
            let costs = parallel::tasks(count, |k| {
                if ring.is_near[k] { cost(&ring.rotations[k]) } else { f64::INFINITY }
            });
            let is_least = |k: usize| {
                let (before, after) = (costs[(k + count - 1) % count], costs[(k + 1) % count]);
                costs[k].is_finite() && costs[k] <= before && costs[k] < after
            };
            let least = (0..count).filter(|k| is_least(*k));
            rough.extend(least.map(|k| (costs[k], ring.rotations[k], ring.axis)));
        }
    }
    rough.sort_by(|a, b| a.0.total_cmp(&b.0));
    rough.truncate(REFINED);
    found.extend(parallel::tasks(rough.len(), |k| {
        let (known, rotation, axis) = &rough[k];
        let beside = (-BESIDE..=BESIDE).filter(|step| *step != 0).map(|step| {
            let turn = rotation::exponential::<3>(&(axis * (STEP * f64::from(step)))).0 * rotation;
            (cost(&turn), turn)
        });
        beside.fold((*known, *rotation), |best, other| if other.0 < best.0 { other } else { best })
    }));
    found.sort_by(|a, b| a.0.total_cmp(&b.0));
    let places: Vec<Vector3<f64>> =
        thin_evenly(samples.len(), 300).into_iter().map(|i| samples.points()[i] - centre).collect();
    let apart = |a: &Matrix3<f64>, b: &Matrix3<f64>| {
        let sum: f64 = places.iter().map(|x| (a * x - b * x).norm_squared()).sum();
        sum > (APART * size).powi(2) * places.len() as f64
    };
    let mut kept: Vec<Matrix3<f64>> = Vec::new();
    for (_, rotation) in found {
        if apart(&rotation, &Matrix3::identity()) && kept.iter().all(|other| apart(&rotation, other)) {
            kept.push(rotation);
            if kept.len() == MOST {
                break;
            }
        }
    }
    kept.iter().map(|rotation| pose.followed_by(&turned(rotation))).collect()
}

/// The points that tell a turn: those that do not fit the model, and some that do, each with how many points it stands for.
struct Telling {
    misfits: Vec<Vector3<f64>>,
    fitting: Vec<Vector3<f64>>,
    weights: [f64; 2],
}

impl Telling {
    fn of(field: &dyn DistanceField<3>, moved: Vec<Vector3<f64>>, size: f64) -> Self {
        let frames = field.frames(&moved, Search::Global, &[]);
        let distances: Vec<f64> = frames.iter().map(|frame| frame.distance.abs()).collect();
        let mut sorted = distances.clone();
        sorted.sort_by(f64::total_cmp);
        let noise = 1.4826 * sorted.get(sorted.len() / 2).copied().unwrap_or(0.0);
        let limit = CUT * noise.max(LEAST * size);
        let is_out: Vec<bool> = distances.iter().map(|distance| *distance > limit).collect();
        let is_surface = surface_left_out(&moved, &is_out);
        let pick = |wanted: &dyn Fn(usize) -> bool, most: usize| {
            let all: Vec<Vector3<f64>> = (0..moved.len()).filter(|&i| wanted(i)).map(|i| moved[i]).collect();
            let some: Vec<_> = thin_evenly(all.len(), most).into_iter().map(|i| all[i]).collect();
            let weight = all.len() as f64 / some.len().max(1) as f64;
            (some, weight)
        };
        let (misfits, of_misfits) = pick(&|i| is_surface[i], MISFITS);
        let (fitting, of_fitting) = pick(&|i| !is_out[i], FITTING);
        Self { misfits, fitting, weights: [of_misfits, of_fitting] }
    }

    /// Sum of the squared distances with a limit, each at most 1.
    fn cost(&self, field: &dyn DistanceField<3>, motion: &Pose<3>, limit: f64) -> f64 {
        let of = |points: &[Vector3<f64>], weight: f64| {
            let moved: Vec<Vector3<f64>> = points.iter().map(|x| motion.apply(x)).collect();
            let shares = field.frames(&moved, Search::Global, &[]);
            weight * shares.iter().map(|frame| (frame.distance / limit).powi(2).min(1.0)).sum::<f64>()
        };
        of(&self.misfits, self.weights[0]) + of(&self.fitting, self.weights[1])
    }
}

/// Rotations of a ball that take places of points which do not fit to places of the model that are not on the ball.
fn onto_bumps(
    field: &dyn DistanceField<3>,
    samples: &OrientedPoints,
    misfits: &[Vector3<f64>],
    centre: &Vector3<f64>,
    size: f64,
) -> Vec<Matrix3<f64>> {
    let turns: Vec<Matrix3<f64>> = (0..TURNS)
        .map(|k| {
            let axis = Vector3::ith(k % 3, 1.0) + Vector3::ith((k + 1) % 3, 0.3 * (k / 3) as f64);
            rotation::exponential::<3>(&(axis.normalize() * (0.7 + 0.6 * k as f64))).0
        })
        .collect();
    let places: Vec<Vector3<f64>> =
        thin_evenly(samples.len(), 3000).into_iter().map(|i| samples.points()[i]).collect();
    let mut off = vec![0usize; places.len()];
    for turn in &turns {
        let moved: Vec<Vector3<f64>> = places.iter().map(|x| turn * (x - centre) + centre).collect();
        let frames = field.frames(&moved, Search::Global, &[]);
        for (count, frame) in off.iter_mut().zip(&frames) {
            *count += usize::from(frame.distance.abs() > 10.0 * LEAST * size);
        }
    }
    let bumps = places.iter().zip(&off).filter(|(_, count)| 2 * **count > TURNS).map(|(x, _)| x - centre);
    let (from, to) = (
        far_apart(&misfits.iter().map(|x| x - centre).collect::<Vec<_>>(), FROM),
        far_apart(&bumps.collect::<Vec<_>>(), TO),
    );
    let mut rotations = Vec::new();
    for a in &from {
        for b in to.iter().filter(|b| (b.norm() - a.norm()).abs() < AS_FAR * size) {
            let Some(axis) = b.try_normalize(0.0) else { continue };
            let Some(first) = nalgebra::Rotation3::rotation_between(a, b) else { continue };
            rotations.extend((0..SPINS).map(|k| {
                rotation::exponential::<3>(&(axis * (TAU * k as f64 / SPINS as f64))).0 * first.matrix()
            }));
        }
    }
    rotations
}

/// Some of the points, each as far from the others as can be.
fn far_apart(points: &[Vector3<f64>], count: usize) -> Vec<Vector3<f64>> {
    let mut picked: Vec<Vector3<f64>> = points.first().copied().into_iter().collect();
    while !picked.is_empty() && picked.len() < count.min(points.len()) {
        let distance =
            |x: &Vector3<f64>| picked.iter().map(|p| (p - x).norm_squared()).fold(f64::INFINITY, f64::min);
        let farthest = points.iter().max_by(|a, b| distance(a).total_cmp(&distance(b)));
        picked.extend(farthest.copied());
    }
    picked
}
