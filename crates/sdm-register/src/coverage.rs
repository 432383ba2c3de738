//! How much of what a scan could see of a model has points.

use crate::parallel;
use crate::start::OrientedPoints;
use crate::{Doubt, Pose};
use distance_field::{DistanceField, Search};
use mesh_core::CloudIndex;
use nalgebra::{Matrix3, Point2, Point3, SymmetricEigen, Vector3};
use std::fmt;

/// Most points of the scan, and most samples of the model, that are looked at.
const POINTS: usize = 8000;
const SAMPLES: usize = 6000;
/// Distance, in spacings of samples or points, within which a sample has points, and depth that hides one behind others.
const NEAR: f64 = 3.0;
/// Points whose spacing is measured.
const MEASURED: usize = 1000;
/// Length of the mean of the unit normals from which a scan is one from one side.
const ONE_SIDED: f64 = 0.5;
/// Fewest samples of a model that tell something.
const FEWEST: usize = 20;
/// Share of the region with points, and share of the points that count, below which both together are a contradiction.
const BARE: f64 = 0.1;
const LEFT_OUT: f64 = 0.7;

/// The region of a model that a scan could see, and how much of it has points.
///
/// The region are the places of the model in the box around the scan, along its principal axes. If the points that count lie on one
/// side of the model, the mean of the normals at their feet is the direction from which it was seen, and places that face away from
/// there, or lie behind others, are not in the region.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Coverage {
    /// Share of the model that is in the region.
    pub region: f64,
    /// Share of the region that has points near it.
    pub covered: f64,
    /// Share of the whole model that has points near it.
    pub model: f64,
    /// Distance within which a point is near: three spacings of the samples or of the points that count, whichever is larger.
    pub distance: f64,
}

impl fmt::Display for Coverage {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [covered, region, model] = [self.covered, self.region, self.model].map(|share| 100.0 * share);
        write!(
            f,
            "{covered:.1} % of what the scan could see of the model has points ({region:.1} % of it could be seen, {model:.1} % of \
             it has points)"
        )
    }
}

impl Coverage {
    /// Whether so little of the region has points that these say nothing for the pose, where many of them were left out as well: points of
    /// something else that touch the model somewhere.
    ///
    /// `share` is that of the points that count.
    #[must_use]
    pub fn doubt(&self, share: f64) -> Option<Doubt> {
        (self.covered < BARE && share < LEFT_OUT).then_some(Doubt::Bare)
    }

    /// How much of a model has points of a scan in a pose; those within `limit` count, all if there is none.
    ///
    /// `samples` are points with normals spread evenly over the model. `None` if they are too few to tell, or if no point
    /// counts.
    #[must_use]
    pub fn of(
        field: &dyn DistanceField<3>,
        samples: &OrientedPoints,
        points: &[Vector3<f64>],
        pose: &Pose<3>,
        limit: Option<f64>,
    ) -> Option<Self> {
        let thinned = |count: usize, most: usize| (0..count).step_by(count.div_ceil(most).max(1));
        let moved: Vec<Vector3<f64>> = thinned(points.len(), POINTS)
            .map(|i| pose.apply(&points[i]))
            .filter(|x| x.iter().all(|c| c.is_finite()))
            .collect();
        let frames = field.frames(&moved, Search::Global, &[]);
        let counts =
            |distance: f64| distance.is_finite() && limit.is_none_or(|limit| distance.abs() <= limit);
        let counting: Vec<usize> = (0..moved.len()).filter(|&i| counts(frames[i].distance)).collect();
        let near: Vec<Point3<f64>> = counting.iter().map(|&i| moved[i].into()).collect();
        let index = CloudIndex::new(&near).ok().filter(|index| !index.is_empty())?;
        let model: Vec<usize> = thinned(samples.len(), SAMPLES).collect();
        let places: Vec<Point3<f64>> = model.iter().map(|&i| samples.points()[i].into()).collect();
        let distance = NEAR * spacing(&places)?.max(spacing(&near).unwrap_or(0.0));
        let has_points =
            parallel::map(places.len(), |k| index.nearest_within(&places[k], distance).is_some());
        let frame = Region::around(&moved, distance)?;
        let mean = counting.iter().map(|&i| frames[i].normal()).sum::<Vector3<f64>>() / counting.len() as f64;
        let mut inside: Vec<usize> = (0..places.len()).filter(|&k| frame.contains(&places[k])).collect();
        if mean.norm() > ONE_SIDED {
            let normals: Vec<&Vector3<f64>> = model.iter().map(|&i| &samples.normals()[i]).collect();
            inside = seen_from(&mean.normalize(), &places, &normals, &inside, distance);
        }
        if places.len() < FEWEST {
            return None;
        }
        let share = |count: usize, of: usize| count as f64 / of.max(1) as f64;
        Some(Self {
            region: share(inside.len(), places.len()),
            covered: share(inside.iter().filter(|&&k| has_points[k]).count(), inside.len()),
            model: share(has_points.iter().filter(|has| **has).count(), has_points.len()),
            distance,
        })
    }
}

/// A box along the principal axes of points.
struct Region {
    axes: Matrix3<f64>,
    low: Vector3<f64>,
    high: Vector3<f64>,
}

impl Region {
    fn around(points: &[Vector3<f64>], margin: f64) -> Option<Self> {
        let mean = points.iter().sum::<Vector3<f64>>() / points.len().max(1) as f64;
        let mut spread = Matrix3::zeros();
        for x in points {
            spread += (x - mean) * (x - mean).transpose();
        }
        if points.is_empty() || !spread.iter().all(|value| value.is_finite()) {
            return None;
        }
        let axes = SymmetricEigen::new(spread).eigenvectors;
        let first = axes.tr_mul(&points[0]);
        let (low, high) = points.iter().fold((first, first), |(low, high), x| {
            let local = axes.tr_mul(x);
            (low.inf(&local), high.sup(&local))
        });
        let margin = Vector3::repeat(margin);
        Some(Self { axes, low: low - margin, high: high + margin })
    }

    fn contains(&self, x: &Point3<f64>) -> bool {
        let local = self.axes.tr_mul(&x.coords);
        (0..3).all(|axis| (self.low[axis]..=self.high[axis]).contains(&local[axis]))
    }
}

/// Those of the places that face a direction and are not hidden behind others, as seen from far away.
fn seen_from(
    towards: &Vector3<f64>,
    places: &[Point3<f64>],
    normals: &[&Vector3<f64>],
    among: &[usize],
    distance: f64,
) -> Vec<usize> {
    let side = towards.cross(&Vector3::ith(towards.iamin(), 1.0)).normalize();
    let up = towards.cross(&side);
    let flat: Vec<Point2<f64>> =
        places.iter().map(|x| Point2::new(x.coords.dot(&side), x.coords.dot(&up))).collect();
    let Ok(index) = CloudIndex::new(&flat) else { return among.to_vec() };
    let hidden = parallel::map(among.len(), |k| {
        let own = places[among[k]].coords.dot(towards);
        // Samples in front of it, around the same line of sight.
        index
            .within(&flat[among[k]], 0.5 * distance)
            .iter()
            .any(|near| places[near.index].coords.dot(towards) > own + 2.0 * distance)
    });
    let seen = among.iter().zip(hidden).filter(|(k, hidden)| !hidden && normals[**k].dot(towards) > 0.0);
    seen.map(|(&k, _)| k).collect()
}

/// The median distance of neighbours; `None` of fewer than two points.
fn spacing(points: &[Point3<f64>]) -> Option<f64> {
    let index = CloudIndex::new(points).ok()?;
    let step = points.len().div_ceil(MEASURED).max(1);
    let some: Vec<&Point3<f64>> = points.iter().step_by(step).collect();
    let mut distances: Vec<f64> =
        parallel::map(some.len(), |k| index.nearest_n(some[k], 2).get(1).map(mesh_core::Neighbour::distance))
            .into_iter()
            .flatten()
            .collect();
    let middle = distances.len() / 2;
    (!distances.is_empty()).then(|| *distances.select_nth_unstable_by(middle, f64::total_cmp).1)
}
