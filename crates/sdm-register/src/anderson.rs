//! Anderson acceleration of a fixed point iteration of poses.

use crate::motion::MAX_UNKNOWNS;
use crate::motion::rotation::{exponential, logarithm};
use crate::{Pose, Velocity};
use nalgebra::{DMatrix, DVector, SVector};

/// Number of earlier steps that are looked at.
const MEMORY: usize = 5;

/// The last steps of an iteration `x ← g(x)`, `x` the translation and the rotation vector of the pose from the start, and
/// the combination of them that would have moved least (\[PNG18\]).
#[derive(Clone, Debug)]
pub(crate) struct Anderson<const D: usize> {
    start: Pose<D>,
    length: f64,
    /// `(g, f)` with `f = g − x`, the newest last.
    steps: Vec<[SVector<f64, MAX_UNKNOWNS>; 2]>,
}

impl<const D: usize> Anderson<D> {
    /// Nothing remembered; `length` makes translations comparable to angles.
    pub(crate) fn new(start: Pose<D>, length: f64) -> Self {
        Self { start, length, steps: Vec::new() }
    }

    /// Forgets all but what follows.
    pub(crate) fn reset(&mut self) {
        self.steps.clear();
    }

    fn coordinates(&self, pose: &Pose<D>) -> SVector<f64, MAX_UNKNOWNS> {
        let translation = (pose.target_origin - self.start.target_origin) / self.length;
        let rotation = logarithm(&(pose.rotation * self.start.rotation.transpose()));
        Velocity { translation, rotation, growth: 0.0 }.to_unknowns()
    }

    fn pose(&self, x: &SVector<f64, MAX_UNKNOWNS>) -> Pose<D> {
        let v = Velocity::<D>::from_unknowns(x);
        Pose {
            target_origin: self.start.target_origin + v.translation * self.length,
            rotation: exponential::<D>(&v.rotation).0 * self.start.rotation,
            ..self.start
        }
    }

    /// The pose to go on with instead of `to`, when the plain step leads from `from` to `to`.
    pub(crate) fn accelerated(&mut self, from: &Pose<D>, to: &Pose<D>) -> Pose<D> {
        let (x, g) = (self.coordinates(from), self.coordinates(to));
        // Rotation vectors jump at half a turn from the start: there, begin anew.
        if (x - g).norm() > 1.0 {
            self.reset();
            return *to;
        }
        self.steps.push([g, g - x]);
        if self.steps.len() > MEMORY + 1 {
            self.steps.remove(0);
        }
        let m = self.steps.len() - 1;
        if m == 0 {
            return *to;
        }
        let newest = self.steps[m];
        let change = |j: usize, k: usize| self.steps[j + 1][k] - self.steps[j][k];
        let matrix = DMatrix::from_fn(MAX_UNKNOWNS, m, |i, j| change(j, 1)[i]);
        let right = DVector::from_fn(MAX_UNKNOWNS, |i, _| newest[1][i]);
        let Ok(mix) = matrix.svd(true, true).solve(&right, 1e-10) else { return *to };
        let mut mixed = newest[0];
        for j in 0..m {
            mixed -= change(j, 0) * mix[j];
        }
        if mixed.iter().all(|c| c.is_finite()) { self.pose(&mixed) } else { *to }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector3;

    #[test]
    fn a_linear_iteration_is_solved_at_once() {
        // Each step goes a part of the way to a goal, by another part in each of two directions.
        let goal = Vector3::new(0.3, -0.2, 0.0);
        let plain = |pose: &Pose<3>| {
            let left = goal - pose.target_origin;
            Pose {
                target_origin: pose.target_origin + Vector3::new(0.1 * left.x, 0.3 * left.y, 0.0),
                ..*pose
            }
        };
        let mut anderson = Anderson::new(Pose::identity(), 1.0);
        let mut pose = Pose::<3>::identity();
        for _ in 0..4 {
            let next = plain(&pose);
            pose = anderson.accelerated(&pose, &next);
        }
        assert!((pose.target_origin - goal).norm() < 1e-12, "{}", pose.target_origin);
    }
}
