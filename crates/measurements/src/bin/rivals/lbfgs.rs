//! A rival: control points and parameters of all data minimised together, without footpoints (\[ZBLW12\]).
//!
//! The unknowns are the control points and one parameter per data point; the cost is the mean squared distance of the points from
//! the places of the curve at their parameters, plus the energy. Its gradient is cheap, and L-BFGS follows it: many iterations,
//! each of which solves no system and projects nothing.

use distance_field::Search;
use nalgebra::{DVector, SVector};
use nurbs_core::{BsplineCurve, ParametricCurve};
use sdm_fit::curve::ActiveCurve;
use sdm_fit::{ActiveShape, CellGram, Error};
use std::collections::VecDeque;

/// Steps that are remembered.
const MEMORY: usize = 20;
/// Constants of Wolfe's conditions.
const ARMIJO: f64 = 1e-4;
const CURVATURE: f64 = 0.9;
/// Most evaluations along one direction.
const TRIALS: usize = 30;

/// The joint problem of a curve and its data.
pub(crate) struct Joint<'a, const D: usize> {
    shape: ActiveCurve<D>,
    points: &'a [SVector<f64, D>],
    energy: Vec<CellGram>,
    lambda: f64,
    /// Length of the curve per parameter, so that all unknowns are lengths.
    speed: f64,
    unknowns: DVector<f64>,
    cost: f64,
    gradient: DVector<f64>,
    memory: VecDeque<(DVector<f64>, DVector<f64>)>,
}

impl<'a, const D: usize> Joint<'a, D> {
    /// From a curve; the first parameters are those of the footpoints.
    pub(crate) fn new(
        curve: BsplineCurve<D>,
        points: &'a [SVector<f64, D>],
        lambda: f64,
        energy: [f64; 3],
    ) -> Result<Self, Error> {
        let speed = (0..200).map(|k| curve.jet(curve.knots().domain().lerp(f64::from(k) / 200.0)).d1.norm());
        let speed = speed.sum::<f64>() / 200.0;
        let shape = ActiveCurve::new(curve)?;
        let feet = shape.frames(points, Search::Global, &[])?;
        let count = shape.coefficients().len();
        let mut unknowns = DVector::zeros(count * D + points.len());
        for (i, coefficient) in shape.coefficients().iter().enumerate() {
            unknowns.rows_mut(i * D, D).copy_from(coefficient);
        }
        for (k, foot) in feet.iter().enumerate() {
            unknowns[count * D + k] = foot.hint.parameter[0] * speed;
        }
        let energy = shape.energy(energy);
        let (cost, gradient, memory) = (0.0, DVector::zeros(unknowns.len()), VecDeque::new());
        let mut joint = Self { shape, points, energy, lambda, speed, unknowns, cost, gradient, memory };
        let start = joint.unknowns.clone();
        (joint.cost, joint.gradient) = joint.evaluate(&start)?;
        Ok(joint)
    }

    /// The curve as it is now.
    pub(crate) fn shape(&self) -> Result<ActiveCurve<D>, Error> {
        let mut shape = self.shape.clone();
        shape.set_coefficients(&self.coefficients(&self.unknowns))?;
        Ok(shape)
    }

    fn coefficients(&self, unknowns: &DVector<f64>) -> Vec<SVector<f64, D>> {
        let count = self.shape.coefficients().len();
        (0..count).map(|i| SVector::from_fn(|d, _| unknowns[i * D + d])).collect()
    }

    fn evaluate(&mut self, unknowns: &DVector<f64>) -> Result<(f64, DVector<f64>), Error> {
        let coefficients = self.coefficients(unknowns);
        let (count, share) = (coefficients.len(), 1.0 / self.points.len() as f64);
        self.shape.set_coefficients(&coefficients)?;
        let mut gradient = DVector::zeros(unknowns.len());
        let mut cost = 0.0;
        let domain = self.shape.curve().knots().domain();
        let closed = self.shape.curve().knots().is_periodic();
        let mut values = vec![0.0; self.shape.cells().widest()];
        for (k, x) in self.points.iter().enumerate() {
            let free = unknowns[count * D + k] / self.speed;
            let t = if closed {
                domain.start() + (free - domain.start()).rem_euclid(domain.length())
            } else {
                free.clamp(domain.start(), domain.end())
            };
            let jet = self.shape.curve().jet(t);
            let r = jet.point - x;
            cost += share * r.norm_squared();
            let cell = self.shape.cell([t, 0.0]);
            self.shape.basis([t, 0.0], cell, &mut values);
            for (&column, value) in self.shape.cells().columns(cell).iter().zip(&values) {
                for d in 0..D {
                    gradient[column * D + d] += 2.0 * share * value * r[d];
                }
            }
            if closed || free == t {
                gradient[count * D + k] = 2.0 * share * r.dot(&jet.d1) / self.speed;
            }
        }
        for CellGram { cell, gram } in &self.energy {
            let columns = self.shape.cells().columns(*cell);
            for (&i, row) in columns.iter().zip(gram.chunks_exact(columns.len())) {
                let force: SVector<f64, D> =
                    columns.iter().zip(row).map(|(&j, g)| coefficients[j] * *g).sum();
                cost += self.lambda * force.dot(&coefficients[i]);
                for d in 0..D {
                    gradient[i * D + d] += 2.0 * self.lambda * force[d];
                }
            }
        }
        Ok((cost, gradient))
    }

    /// One iteration; the number of evaluations it took, 0 when it could not go lower.
    pub(crate) fn step(&mut self) -> Result<usize, Error> {
        let mut direction = -self.gradient.clone();
        let mut factors = Vec::new();
        for (s, y) in self.memory.iter().rev() {
            let factor = s.dot(&direction) / s.dot(y);
            direction.axpy(-factor, y, 1.0);
            factors.push(factor);
        }
        if let Some((s, y)) = self.memory.back() {
            direction *= s.dot(y) / y.norm_squared();
        }
        for ((s, y), factor) in self.memory.iter().zip(factors.iter().rev()) {
            let back = y.dot(&direction) / s.dot(y);
            direction.axpy(factor - back, s, 1.0);
        }
        let slope = self.gradient.dot(&direction);
        if slope.is_nan() || slope >= 0.0 {
            return Ok(0);
        }
        let (mut low, mut high) = (0.0, f64::INFINITY);
        // The first direction is a gradient, whose length tells nothing.
        let mut length = if self.memory.is_empty() { self.cost / -slope } else { 1.0 };
        for trial in 1..=TRIALS {
            let unknowns = &self.unknowns + &direction * length;
            let (cost, gradient) = self.evaluate(&unknowns)?;
            if cost.is_nan() || cost > self.cost + ARMIJO * length * slope {
                high = length;
            } else if gradient.dot(&direction) < CURVATURE * slope {
                low = length;
            } else {
                let (s, y) = (&direction * length, &gradient - &self.gradient);
                if self.memory.len() == MEMORY {
                    self.memory.pop_front();
                }
                if s.dot(&y) > 0.0 {
                    self.memory.push_back((s, y));
                }
                (self.unknowns, self.cost, self.gradient) = (unknowns, cost, gradient);
                return Ok(trial);
            }
            length = if high.is_finite() { 0.5 * (low + high) } else { 2.0 * length };
        }
        Ok(0)
    }
}
