//! Alignment by datum targets: 3-2-1 and reference points.

use crate::constraint::{Chart, Freedom, Locks};
use crate::linearise::{NormalSystem, add_square};
use crate::motion::rigid_unknowns;
use crate::solve::{Scaled, Spectrum};
use crate::superpose::superpose;
use crate::{Error, Pose, Status, Velocity, rotation};
use nalgebra::{DVector, SVector, Vector3};
use sdm_core::{
    Controller, Problem, StepControl, StepDirection, StepLimits, StepTaken, Stop, Trial, minimise,
};

/// Most steps.
const MAX_STEPS: usize = 100;
/// Share of the largest eigenvalue up to which a motion counts as open.
const OPEN: f64 = 1e-12;
/// Motion as a share of the size below which the change of the cost is rounding, and that which ends the iteration.
const ROUNDING: f64 = 1e-7;
const TOLERANCE: f64 = 1e-14;
/// Control of the steps; dampings are shares of the largest eigenvalue.
const LIMITS: StepLimits = StepLimits {
    decrease: 1e-4,
    shortest: 1e-6,
    first: 1e-3,
    least: 0.0,
    last: 1e8,
    drops: true,
    slack: f64::EPSILON,
};

/// One condition on a motion `T`: `⟨e, T x − q⟩ = 0`, the point `x` shall come to lie in the plane through `q` at right
/// angles to `e`.
///
/// Three targets with the normal of the primary datum plane, two with that of the secondary and one with that of the
/// tertiary are a 3-2-1 alignment; a reference point (RPS) has one target for each direction that it fixes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DatumTarget<const D: usize> {
    /// `x`, measured, in the coordinates of the source.
    pub point: SVector<f64, D>,
    /// `q`, nominal, in the coordinates of the model.
    pub nominal: SVector<f64, D>,
    /// `e`, of any length but 0, in the axes of the model.
    pub direction: SVector<f64, D>,
    /// Weight where there are more targets than needed.
    pub weight: f64,
}

impl<const D: usize> DatumTarget<D> {
    /// A target of weight 1.
    #[must_use]
    pub fn new(point: SVector<f64, D>, nominal: SVector<f64, D>, direction: SVector<f64, D>) -> Self {
        Self { point, nominal, direction, weight: 1.0 }
    }
}

/// The result of an alignment by targets.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct DatumReport<const D: usize> {
    /// Takes points of the source to the frame of the model.
    pub pose: Pose<D>,
    /// How the iteration ended.
    pub status: Status,
    /// `⟨e, T x − q⟩` for each target, `e` of unit length.
    pub residuals: Vec<f64>,
    /// Root mean square residual, with the weights.
    pub rms: f64,
    /// Number of steps.
    pub iterations: usize,
}

impl<const D: usize> std::fmt::Display for DatumReport<D> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(
            f,
            "{} after {} steps, {} targets, rms {:.4e}",
            self.status,
            self.iterations,
            self.residuals.len(),
            self.rms
        )
    }
}

/// Aligns by datum targets: exactly if they are as many as the unknowns (6 in space, 3 in the plane), by least squares if
/// they are more. Gauss and Newton's method from `start`, which decides between the solutions of such equations.
///
/// # Errors
/// [`Error::OpenDatum`] if the targets do not fix the motion, [`Error::NotFinite`] for a target that is not finite,
/// [`Error::Weight`] for a weight that is negative or not finite.
pub fn align_datum<const D: usize>(
    targets: &[DatumTarget<D>],
    start: &Pose<D>,
) -> Result<DatumReport<D>, Error> {
    check(targets)?;
    let unknowns = rigid_unknowns(D);
    if targets.len() < unknowns {
        return Err(Error::OpenDatum { free: unknowns - targets.len(), unknowns });
    }
    let n = targets.len() as f64;
    let first = targets[0].point;
    let centre = first + targets.iter().map(|t| t.point - first).sum::<SVector<f64, D>>() / n;
    let length = targets.iter().map(|t| (t.point - centre).norm()).fold(0.0, f64::max);
    let pose = start.with_source_origin(centre);
    let chart = Chart::new(Locks::default(), false, pose);
    let cost = cost_of(targets, &pose);
    let mut run = Run { targets, chart, length, pose, cost, iterations: 0 };
    let mut control = Controller::new(StepControl::LevenbergMarquardt, LIMITS);
    let status = minimise(&mut run, &mut control, usize::MAX)?;
    let Run { pose, cost, iterations, .. } = run;
    let residuals: Vec<f64> = targets.iter().map(|t| residual(t, &pose)).collect();
    let weight: f64 = targets.iter().map(|t| t.weight).sum();
    let rms = if weight > 0.0 { (cost / weight).sqrt() } else { 0.0 };
    Ok(DatumReport { pose, status, residuals, rms, iterations })
}

/// Aligns by datum targets wherever the points are to begin with, as [`align_datum`] does from a start.
///
/// The iteration runs from the motion that takes the points nearest to their nominal places ([`superpose`]), and from that
/// motion with half a turn about each axis of the model. Of the solutions with the smallest residual the one that leaves the
/// points nearest to their nominal places counts.
///
/// # Errors
/// Those of [`align_datum`].
pub fn align_datum_from_anywhere<const D: usize>(
    targets: &[DatumTarget<D>],
) -> Result<DatumReport<D>, Error> {
    check(targets)?;
    let pairs: Vec<_> = targets.iter().map(|t| (t.point, t.nominal, t.weight)).collect();
    let first = superpose(&pairs)?;
    let half_turns = (0..if D == 2 { 1 } else { 3 }).map(|axis| {
        let turn = rotation::exponential::<D>(&Vector3::ith(axis, std::f64::consts::PI)).0;
        Pose { rotation: turn * first.rotation, ..first }
    });
    let mut best = align_datum(targets, &first)?;
    let offset = |report: &DatumReport<D>| -> f64 {
        targets.iter().map(|t| t.weight * (report.pose.apply(&t.point) - t.nominal).norm_squared()).sum()
    };
    let size = pairs.iter().map(|pair| (pair.1 - first.target_origin).norm()).fold(0.0, f64::max);
    // Rounding of the residuals, which tells no solution from another.
    let rounding = 1e-12 * (size + first.target_origin.norm());
    for start in half_turns {
        // An alignment that is open from one start can be closed from another; the first one has found a solution already.
        let Ok(found) = align_datum(targets, &start) else { continue };
        let better = if (found.rms - best.rms).abs() <= rounding {
            offset(&found) < offset(&best)
        } else {
            found.rms < best.rms
        };
        if found.status.is_converged() && (better || !best.status.is_converged()) {
            best = found;
        }
    }
    Ok(best)
}

/// The Gauss-Newton method in the unknowns of a motion.
struct Run<'a, const D: usize> {
    targets: &'a [DatumTarget<D>],
    chart: Chart<D>,
    /// Size of the targets.
    length: f64,
    pose: Pose<D>,
    cost: f64,
    iterations: usize,
}

struct Linear<const D: usize> {
    freedom: Freedom<D>,
    scaled: Scaled,
    spectrum: Spectrum,
}

/// A pose that a step leads to.
struct Moved<const D: usize> {
    pose: Pose<D>,
    cost: f64,
    motion: f64,
}

impl<const D: usize> Trial for Moved<D> {
    fn cost(&self) -> f64 {
        self.cost
    }

    fn is_rounding(&self) -> bool {
        self.motion <= ROUNDING
    }
}

impl<const D: usize> Problem for Run<'_, D> {
    type Linear = Linear<D>;
    type Step = DVector<f64>;
    type Trial = Moved<D>;
    type Error = Error;

    fn linearise(&mut self) -> Result<Linear<D>, Stop<Error>> {
        let unknowns = rigid_unknowns(D);
        let freedom = self.chart.freedom(&self.pose);
        let system = system_of(self.targets, &self.pose);
        let tangent = freedom.reduce(&system.tangent);
        let scaled = Scaled::new(&tangent, &freedom.is_translation, self.length, OPEN);
        if scaled.rank() < unknowns {
            return Err(Error::OpenDatum { free: unknowns - scaled.rank(), unknowns }.into());
        }
        let spectrum = scaled.spectrum(&tangent, &freedom.reduce_vector(&system.vector));
        Ok(Linear { freedom, scaled, spectrum })
    }

    fn cost(&self, _: &Linear<D>) -> f64 {
        self.cost
    }

    fn direction(
        &mut self,
        linear: &Linear<D>,
        damping: f64,
    ) -> Result<StepDirection<DVector<f64>>, Stop<Error>> {
        let step = linear.scaled.step(&linear.spectrum, damping * linear.spectrum.largest());
        Ok(StepDirection::along(step, linear.spectrum.slope(damping * linear.spectrum.largest())))
    }

    fn advance(
        &mut self,
        linear: &Linear<D>,
        step: &DVector<f64>,
        factor: f64,
    ) -> Result<Option<Moved<D>>, Stop<Error>> {
        if self.iterations >= MAX_STEPS {
            return Err(Stop::Ended(Status::MaxIterations));
        }
        self.iterations += 1;
        let step = step * factor;
        let pose = self.chart.advance(&self.pose, &linear.freedom, &step);
        let velocity = linear.freedom.velocity(&step);
        let motion = velocity.translation.norm() / self.length + velocity.rotation.norm();
        Ok(Some(Moved { cost: cost_of(self.targets, &pose), pose, motion }))
    }

    fn accept(&mut self, _: Linear<D>, trial: Moved<D>, _: StepTaken) -> Result<(), Stop<Error>> {
        (self.pose, self.cost) = (trial.pose, trial.cost);
        let far = self.pose.target_origin.norm() / self.length;
        if trial.motion <= TOLERANCE * (1.0 + far) { Err(Stop::Ended(Status::Converged)) } else { Ok(()) }
    }
}

fn check<const D: usize>(targets: &[DatumTarget<D>]) -> Result<(), Error> {
    let finite = |t: &DatumTarget<D>| {
        let length = t.direction.norm();
        length > 0.0 && t.point.iter().chain(t.nominal.iter()).chain([&length]).all(|c| c.is_finite())
    };
    if let Some(index) = targets.iter().position(|t| !finite(t)) {
        return Err(Error::NotFinite { index, count: targets.iter().filter(|t| !finite(t)).count() });
    }
    match targets.iter().position(|t| !(t.weight >= 0.0 && t.weight.is_finite())) {
        Some(index) => Err(Error::Weight { index, value: targets[index].weight }),
        None => Ok(()),
    }
}

fn residual<const D: usize>(target: &DatumTarget<D>, pose: &Pose<D>) -> f64 {
    target.direction.normalize().dot(&(pose.apply(&target.point) - target.nominal))
}

fn cost_of<const D: usize>(targets: &[DatumTarget<D>], pose: &Pose<D>) -> f64 {
    targets.iter().map(|t| t.weight * residual(t, pose).powi(2)).sum()
}

fn system_of<const D: usize>(targets: &[DatumTarget<D>], pose: &Pose<D>) -> NormalSystem<D> {
    let mut system = NormalSystem::default();
    for target in targets.iter().filter(|t| t.weight > 0.0) {
        let row = Velocity::<D>::row(
            &target.direction.normalize(),
            &(pose.apply(&target.point) - pose.target_origin),
        );
        add_square::<D>(&mut system.tangent, &row, target.weight);
        system.add_gradient(&row, target.weight * residual(target, pose));
    }
    system.mirror();
    system
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rotation::exponential;
    use nalgebra::{Vector2, Vector3};

    /// Nominal points and directions of a 3-2-1 alignment.
    fn nominal() -> Vec<(Vector3<f64>, Vector3<f64>)> {
        let (x, y, z) = (Vector3::x(), Vector3::y(), Vector3::z());
        vec![
            (Vector3::new(0.0, 0.0, 0.0), z),
            (Vector3::new(5.0, 0.0, 0.0), z),
            (Vector3::new(0.0, 3.0, 0.0), z),
            (Vector3::new(1.0, 0.0, 1.0), y),
            (Vector3::new(4.0, 0.0, 1.0), y),
            (Vector3::new(0.0, 1.5, 1.0), x),
        ]
    }

    fn moved() -> Pose<3> {
        Pose::new(exponential::<3>(&Vector3::new(0.2, -0.4, 0.3)).0, Vector3::new(100.0, -20.0, 7.0))
    }

    #[test]
    fn three_two_one_is_exact() {
        let back = moved();
        let targets: Vec<_> =
            nominal().into_iter().map(|(q, e)| DatumTarget::new(back.inverse().apply(&q), q, e)).collect();
        let report = align_datum(&targets, &Pose::identity()).unwrap();
        assert!(report.status.is_converged() && report.rms < 1e-13, "{report}");
        let x = Vector3::new(1.0, 2.0, 3.0);
        assert!((report.pose.apply(&back.inverse().apply(&x)) - x).norm() < 1e-12);
    }

    #[test]
    fn more_targets_are_least_squares() {
        // All three directions of four reference points, measured with errors: the gradient vanishes at the minimum.
        let noise = |i: usize| 0.01 * (7.3 * i as f64).sin();
        let corners = [[0.0, 0.0, 0.0], [5.0, 0.0, 1.0], [0.0, 3.0, 2.0], [4.0, 4.0, 0.0]].map(Vector3::from);
        let mut targets = Vec::new();
        for (i, q) in corners.iter().enumerate() {
            let x = moved().inverse().apply(&(q + Vector3::from_fn(|k, _| noise(3 * i + k))));
            targets.extend([Vector3::x(), Vector3::y(), Vector3::z()].map(|e| DatumTarget::new(x, *q, e)));
        }
        let report = align_datum(&targets, &Pose::identity()).unwrap();
        assert!(report.status.is_converged() && report.rms > 1e-3, "{report}");
        let gradient = system_of(&targets, &report.pose).vector.fixed_rows::<6>(0).into_owned();
        assert!(gradient.norm() < 1e-12, "{gradient}");
    }

    #[test]
    fn three_two_one_is_found_from_any_position() {
        for turn in [[3.1, 0.0, 0.0], [0.0, 2.9, 0.4], [1.5, -1.5, 1.5], [0.1, 0.1, -3.0]] {
            let back = Pose::new(exponential::<3>(&Vector3::from(turn)).0, Vector3::new(40.0, -20.0, 7.0));
            // Measured beside the nominal places, in the datum planes.
            let beside = |q: &Vector3<f64>, e: &Vector3<f64>| {
                let slip = Vector3::new(0.2, -0.1, 0.15);
                q + slip - e * e.dot(&slip)
            };
            let targets: Vec<_> = (nominal().into_iter())
                .map(|(q, e)| DatumTarget::new(back.inverse().apply(&beside(&q, &e)), q, e))
                .collect();
            let report = align_datum_from_anywhere(&targets).unwrap();
            assert!(report.status.is_converged() && report.rms < 1e-12, "{report}");
            let x = Vector3::new(1.0, 2.0, 3.0);
            assert!((report.pose.apply(&back.inverse().apply(&x)) - x).norm() < 1e-11, "{turn:?}");
        }
    }

    #[test]
    fn open_and_bad_targets_are_refused() {
        let all: Vec<_> = nominal().into_iter().map(|(q, e)| DatumTarget::new(q, q, e)).collect();
        assert_eq!(align_datum(&all[..5], &Pose::identity()), Err(Error::OpenDatum { free: 1, unknowns: 6 }));
        let mut double = all.clone();
        double[5] = double[4];
        assert_eq!(align_datum(&double, &Pose::identity()), Err(Error::OpenDatum { free: 1, unknowns: 6 }));
        let mut bad = all.clone();
        bad[2].point.x = f64::NAN;
        assert_eq!(align_datum(&bad, &Pose::identity()), Err(Error::NotFinite { index: 2, count: 1 }));
        let mut negative = all;
        negative[1].weight = -1.0;
        assert_eq!(align_datum(&negative, &Pose::identity()), Err(Error::Weight { index: 1, value: -1.0 }));
    }

    #[test]
    fn two_one_in_the_plane() {
        let turn = Pose::new(exponential::<2>(&(Vector3::x() * 0.3)).0, Vector2::new(3.0, 4.0));
        let nominal = [([0.0, 0.0], [0.0, 1.0]), ([2.0, 0.0], [0.0, 1.0]), ([0.0, 1.0], [1.0, 0.0])];
        let targets = nominal.map(|(q, e)| {
            let q = Vector2::from(q);
            DatumTarget::new(turn.inverse().apply(&q), q, Vector2::from(e))
        });
        let report = align_datum(&targets, &Pose::identity()).unwrap();
        assert!((report.pose.rotation - turn.rotation).norm() < 1e-13 && report.rms < 1e-14, "{report}");
    }
}
