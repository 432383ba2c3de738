//! A pose with the footpoints of the cloud in it, and what they add up to.

use crate::linearise::{NormalSystem, Unknowns, add_square};
use crate::motion::{Pose, Velocity, rigid_unknowns};
use crate::parallel;
use crate::source::Prepared;
use crate::weights::{Rejection, Weighting};
use distance_field::{DistanceField, ErrorTerm, Hint, PrincipalFrame, Search};
use nalgebra::SVector;

/// A motion as a share of the size of the cloud below which footpoints are followed from the last ones.
pub(crate) const WARM_START_MOTION: f64 = 0.01;

/// The cloud in one pose.
#[derive(Clone, Debug)]
pub(crate) struct View<const D: usize> {
    pub(crate) pose: Pose<D>,
    pub(crate) frames: Vec<PrincipalFrame<D>>,
    /// How far each point has moved since its foot was found, at most, in the unit of the model; empty where all feet are those of
    /// the pose.
    since: Vec<f64>,
    /// Whether distances count in the unit of the source, as they do where the scale is an unknown: in that of the model a
    /// cloud that shrinks to a point would fit anything.
    relative: bool,
}

/// What the sums are made of.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Terms {
    /// The error term of the linear steps.
    pub(crate) term: ErrorTerm,
    /// Whether the exact second derivatives are wanted, too.
    pub(crate) taylor: bool,
    /// Whether the symmetric objective replaces the tangent term where a point has a normal.
    pub(crate) symmetric: bool,
}

/// The hint of a frame for a point that was elsewhere when it was found.
fn hint_at<const D: usize>(frame: &PrincipalFrame<D>, x: &SVector<f64, D>) -> Hint {
    let before = frame.foot + frame.normal() * frame.distance;
    frame.hint.moved((x - before).norm())
}

impl<const D: usize> View<D> {
    /// Moves the cloud and finds the footpoints, from those of an earlier pose unless the search is global.
    pub(crate) fn new(
        field: &dyn DistanceField<D>,
        cloud: &Prepared<D>,
        pose: Pose<D>,
        search: Search,
        before: Option<&Self>,
        relative: bool,
    ) -> Self {
        let linear = pose.rotation * pose.scale;
        let points = parallel::map(cloud.points.len(), |i| linear * cloud.points[i] + pose.target_origin);
        let hints: Vec<Hint> = match before {
            Some(view) if search != Search::Global => {
                view.frames.iter().zip(&points).map(|(frame, x)| hint_at(frame, x)).collect()
            }
            _ => Vec::new(),
        };
        let search = if hints.is_empty() { Search::Global } else { search };
        Self { pose, frames: field.frames(&points, search, &hints), since: Vec::new(), relative }
    }

    /// The cloud in another pose, with the feet of those points alone that may matter: `idle(i, d)` tells that the foot of a point is
    /// not needed while its distance is at least `d`, in the unit in which it counts. Such a point keeps the frame that it had.
    ///
    /// The distance from a shape changes by no more than the point moves.
    pub(crate) fn moved(
        &self,
        field: &dyn DistanceField<D>,
        cloud: &Prepared<D>,
        pose: Pose<D>,
        search: Search,
        idle: &(dyn Fn(usize, f64) -> bool + Sync),
    ) -> Self {
        let unit = if self.relative { pose.scale } else { 1.0 };
        let [linear, before] = [&pose, &self.pose].map(|pose| pose.rotation * pose.scale);
        let moved = parallel::map(cloud.points.len(), |i| {
            let y = &cloud.points[i];
            let x = linear * y + pose.target_origin;
            let step = x - (before * y + self.pose.target_origin);
            let way = step.norm() + self.since.get(i).copied().unwrap_or(0.0);
            let least = (self.frames[i].distance.abs() - way) / unit;
            (x, if idle(i, least) { way } else { 0.0 }, idle(i, least))
        });
        let wanted: Vec<usize> = (0..moved.len()).filter(|&i| !moved[i].2).collect();
        let since = if wanted.len() < moved.len() { moved.iter().map(|m| m.1).collect() } else { Vec::new() };
        let mut out = Self { pose, frames: self.frames.clone(), since, relative: self.relative };
        let points: Vec<_> = wanted.iter().map(|&i| moved[i].0).collect();
        out.find(field, &points, search, &wanted);
        out
    }

    /// Moves the cloud by a step so short that no foot is looked for: the distances change as those from the tangent planes.
    pub(crate) fn slide(&mut self, cloud: &Prepared<D>, pose: Pose<D>) {
        let [linear, before] = [&pose, &self.pose].map(|pose| pose.rotation * pose.scale);
        let shift = pose.target_origin - self.pose.target_origin;
        for (frame, y) in self.frames.iter_mut().zip(&cloud.points) {
            let step = linear * y - before * y + shift;
            frame.distance += frame.normal().dot(&step);
            // What is known of other feet was for where the point was.
            frame.hint.slack = 0.0;
        }
        self.pose = pose;
    }

    /// Finds the feet that were left out; whether there were any.
    pub(crate) fn complete(&mut self, field: &dyn DistanceField<D>, cloud: &Prepared<D>) -> bool {
        let wanted: Vec<usize> = (0..self.since.len()).filter(|&i| self.since[i] > 0.0).collect();
        let farthest = self.since.iter().copied().fold(0.0, f64::max);
        self.since = Vec::new();
        let linear = self.pose.rotation * self.pose.scale;
        let points: Vec<_> =
            wanted.iter().map(|&i| linear * cloud.points[i] + self.pose.target_origin).collect();
        let is_far = farthest > WARM_START_MOTION * cloud.diagonal * self.pose.scale;
        self.find(field, &points, if is_far { Search::Global } else { Search::Local }, &wanted);
        !wanted.is_empty()
    }

    /// Finds the feet of some points, from those that they have.
    fn find(
        &mut self,
        field: &dyn DistanceField<D>,
        points: &[SVector<f64, D>],
        search: Search,
        wanted: &[usize],
    ) {
        let from: &[usize] = if search == Search::Global { &[] } else { wanted };
        let hints: Vec<Hint> = from.iter().zip(points).map(|(&i, x)| hint_at(&self.frames[i], x)).collect();
        for (&i, frame) in wanted.iter().zip(field.frames(points, search, &hints)) {
            self.frames[i] = frame;
        }
    }

    /// The unit in which distances count, in that of the model.
    #[inline]
    pub(crate) fn unit(&self) -> f64 {
        if self.relative { self.pose.scale } else { 1.0 }
    }

    /// The distance of a point as it counts, signed.
    #[inline]
    pub(crate) fn distance(&self, i: usize) -> f64 {
        self.frames[i].distance / self.unit()
    }

    /// The size of a cloud in the unit in which distances count.
    pub(crate) fn size(&self, cloud: &Prepared<D>) -> f64 {
        if self.relative { cloud.diagonal } else { cloud.diagonal * self.pose.scale }
    }

    /// The points in the order of the elements of the shape on which they have their feet; `None` if that is their order.
    pub(crate) fn order_of_feet(&self) -> Option<Vec<usize>> {
        let element = |i: &usize| self.frames[*i].hint.element;
        let mut order: Vec<usize> = (0..self.frames.len()).collect();
        if order.is_sorted_by_key(element) {
            return None;
        }
        order.sort_unstable_by_key(|i| (element(i), *i));
        Some(order)
    }

    /// Some of the points, or all, in another order.
    pub(crate) fn picked(&self, pick: &[usize]) -> Self {
        Self {
            frames: pick.iter().map(|&i| self.frames[i]).collect(),
            since: if self.since.is_empty() {
                Vec::new()
            } else {
                pick.iter().map(|&i| self.since[i]).collect()
            },
            ..*self
        }
    }

    /// The weight of each point before any kernel: 0 for those without a footpoint and those that are rejected.
    pub(crate) fn base_weights(&self, cloud: &Prepared<D>, rejection: &Rejection) -> Vec<f64> {
        parallel::map(self.frames.len(), |i| {
            let frame = &self.frames[i];
            if !frame.is_finite() {
                return 0.0;
            }
            let normal = rejection
                .normal_angle
                .and_then(|_| cloud.normals.get(i))
                .map(|normal| self.pose.rotate(normal));
            if rejection.keeps(frame, normal.as_ref()) { cloud.weight(i) } else { 0.0 }
        })
    }

    /// The distances of the points that have a weight, not negative.
    pub(crate) fn distances(&self, base: &[f64]) -> Vec<f64> {
        (0..self.frames.len()).filter(|&i| base[i] > 0.0).map(|i| self.distance(i).abs()).collect()
    }

    /// `Σ ω ρ(d²)` over the points with a weight; a point without a footpoint makes it infinite.
    pub(crate) fn cost(&self, base: &[f64], weighting: &Weighting) -> f64 {
        let parts = parallel::ranges(self.frames.len(), |range| {
            let mut sum = 0.0;
            for i in range {
                if base[i] > 0.0 {
                    let distance = self.distance(i);
                    sum += base[i]
                        * if distance.is_nan() { f64::INFINITY } else { weighting.evaluate(distance).loss };
                }
            }
            sum
        });
        parts.iter().sum()
    }

    /// Root mean square distance of the points with their weights, and how many have one.
    pub(crate) fn rms(&self, base: &[f64], weighting: &Weighting) -> (f64, usize) {
        let parts = parallel::ranges(self.frames.len(), |range| {
            let mut sums = (0.0, 0.0, 0);
            for i in range {
                let distance = self.distance(i);
                let weight = if base[i] > 0.0 { base[i] * weighting.evaluate(distance).weight } else { 0.0 };
                if weight > 0.0 {
                    sums = (sums.0 + weight * distance * distance, sums.1 + weight, sums.2 + 1);
                }
            }
            sums
        });
        let total = parts.iter().fold((0.0, 0.0, 0), |a, b| (a.0 + b.0, a.1 + b.1, a.2 + b.2));
        (if total.1 > 0.0 { (total.0 / total.1).sqrt() } else { 0.0 }, total.2)
    }

    /// The normal equations at this pose.
    pub(crate) fn system(
        &self,
        cloud: &Prepared<D>,
        base: &[f64],
        weighting: &Weighting,
        terms: &Terms,
    ) -> NormalSystem<D> {
        let linear = self.pose.rotation * self.pose.scale;
        let unit = self.relative.then_some(self.pose.scale);
        let parts = parallel::ranges(self.frames.len(), |range| {
            let mut system = NormalSystem::default();
            for i in range {
                if base[i] > 0.0 {
                    let normal = if terms.symmetric { cloud.normals.get(i) } else { None };
                    let normal = normal.map(|n| self.pose.rotate(n));
                    let y = linear * cloud.points[i];
                    add_point(&mut system, &self.frames[i], &y, unit, normal, base[i], weighting, terms);
                }
            }
            system
        });
        let mut total = NormalSystem::default();
        for part in &parts {
            total.merge(part);
        }
        total.mirror();
        if self.relative && terms.taylor {
            total.add_second_order_of_unit();
        }
        total
    }
}

/// The share of each unknown in the change of a distance along `e`, in the unit in which it counts.
///
/// With a unit that grows with the cloud, `d/s`, growth by `g` takes `g d` from the change.
#[inline]
fn row_of<const D: usize>(
    e: &SVector<f64, D>,
    y: &SVector<f64, D>,
    unit: Option<f64>,
    distance: f64,
) -> Unknowns {
    let mut row = Velocity::<D>::row(e, y);
    if let Some(unit) = unit {
        row /= unit;
        row[rigid_unknowns(D)] -= distance;
    }
    row
}

/// Adds one point, `y` its position relative to the origin of the motion.
#[inline]
#[allow(clippy::too_many_arguments, reason = "one call, in the innermost loop")]
fn add_point<const D: usize>(
    system: &mut NormalSystem<D>,
    frame: &PrincipalFrame<D>,
    y: &SVector<f64, D>,
    unit: Option<f64>,
    normal: Option<SVector<f64, D>>,
    base: f64,
    weighting: &Weighting,
    terms: &Terms,
) {
    let distance = unit.map_or(frame.distance, |unit| frame.distance / unit);
    let kernel = weighting.evaluate(distance);
    system.cost += base * kernel.loss;
    if kernel.weight <= 0.0 {
        return;
    }
    let weight = base * kernel.weight;
    system.weight += weight;
    system.count += 1;
    system.squares += weight * distance * distance;
    let along = frame.normal();
    if let Some(normal) = normal.filter(|n| terms.symmetric && n.norm_squared() > 0.0) {
        add_symmetric(system, frame, y, unit, &normal, weight);
        return;
    }
    let row = row_of(&along, y, unit, distance);
    add_square::<D>(&mut system.tangent, &row, weight);
    system.add_gradient(&row, weight * distance);
    if terms.taylor {
        let gradient = along * (weight * distance);
        system.add_moment(&unit.map_or(gradient, |unit| gradient / unit), y);
        if kernel.weight_change != 0.0 {
            add_square::<D>(&mut system.taylor, &row, base * kernel.weight_change);
        }
    }
    let shares = terms.term.weights(frame);
    let exact = if terms.taylor { ErrorTerm::Taylor.weights(frame) } else { SVector::zeros() };
    for k in 0..D - 1 {
        let is_tangent = k < frame.tangent_dimension;
        if is_tangent && shares[k] == 0.0 && exact[k] == 0.0 {
            continue;
        }
        let row = row_of(&frame.axes.column(k).into_owned(), y, unit, 0.0);
        if !is_tangent {
            add_square::<D>(&mut system.tangent, &row, weight);
            continue;
        }
        if shares[k] != 0.0 {
            add_square::<D>(&mut system.term, &row, weight * shares[k]);
        }
        if exact[k] != 0.0 {
            add_square::<D>(&mut system.taylor, &row, weight * exact[k]);
        }
    }
}

/// Adds a point with a normal by the symmetric objective (\[Ru19\]): the distance along the mean of both normals, which
/// moves with the point half-way to the foot.
fn add_symmetric<const D: usize>(
    system: &mut NormalSystem<D>,
    frame: &PrincipalFrame<D>,
    y: &SVector<f64, D>,
    unit: Option<f64>,
    normal: &SVector<f64, D>,
    weight: f64,
) {
    let along = frame.normal();
    let side = if normal.dot(&along) < 0.0 { -1.0 } else { 1.0 };
    let mean = (along + normal * side) * 0.5;
    let gap = along * frame.distance;
    let height = mean.dot(&gap) / unit.unwrap_or(1.0);
    let row = row_of(&mean, &(y - gap * 0.5), unit, height);
    add_square::<D>(&mut system.tangent, &row, weight);
    system.add_gradient(&row, weight * height);
}
