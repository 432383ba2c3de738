//! The narrow band in which a level set moves.

use super::differences::Stencil;
use crate::contour::empty;
use crate::{Error, parallel, region};
use distance_field::Grid;
use distance_field::grid::redistance;
use nalgebra::SVector;

/// Half the width of the band in which values change, in cells, and of the one in which they are distances.
///
/// At the end of the band values jump by what the zero set has moved, which the spline of the next distances carries on to the zero
/// set, damped by 0.27 for each node: with nine of them it is nothing.
const WIDE: [f64; 2] = [9.0, 13.0];
/// The same where only the place counts at which an evolution comes to rest.
const NARROW: [f64; 2] = [3.5, 7.0];
/// How far the zero set may move before values are made distances again, in cells.
const TRAVEL: f64 = 0.9;
/// Share of the largest stable step that is taken.
const COURANT: f64 = 0.45;
/// Value of a node that must not change sides, in cells.
const HELD: f64 = 1e-2;

/// How a level set evolves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EvolutionOptions {
    /// Whether the numbers of components and holes stay as they are; default not.
    pub fixed_topology: bool,
    /// Order in time, 1 or 3; default 3. Where only the place counts at which an evolution comes to rest, 1 is as good.
    pub time_order: usize,
    /// Most steps of one run; default 100 000.
    pub max_steps: usize,
}

impl Default for EvolutionOptions {
    fn default() -> Self {
        Self { fixed_topology: false, time_order: 3, max_steps: 100_000 }
    }
}

impl EvolutionOptions {
    /// The same options with a topology that is held or not.
    #[must_use]
    pub fn with_fixed_topology(self, fixed_topology: bool) -> Self {
        Self { fixed_topology, ..self }
    }

    /// The same options with another order in time.
    #[must_use]
    pub fn with_time_order(self, time_order: usize) -> Self {
        Self { time_order, ..self }
    }
}

/// Speeds at the nodes of a grid; by default none. `φ_t = −a |∇φ| + b κ |∇φ| − v · ∇φ`.
#[derive(Clone, Copy, Debug, Default)]
pub struct Motion<'a, const D: usize> {
    /// `a`, along the normals: positive where the inside grows. Empty for none.
    pub propagation: &'a [f64],
    /// `b ≥ 0`, the factor of the curvature (in space the sum of the two), which smooths. Empty for none.
    pub curvature: &'a [f64],
    /// `v`, a flow that carries the level set along. Empty for none.
    pub flow: &'a [SVector<f64, D>],
}

impl<'a, const D: usize> Motion<'a, D> {
    /// The same with a speed along the normals.
    #[must_use]
    pub fn with_propagation(self, propagation: &'a [f64]) -> Self {
        Self { propagation, ..self }
    }

    /// The same with a factor of the curvature.
    #[must_use]
    pub fn with_curvature(self, curvature: &'a [f64]) -> Self {
        Self { curvature, ..self }
    }

    /// The same with a flow.
    #[must_use]
    pub fn with_flow(self, flow: &'a [SVector<f64, D>]) -> Self {
        Self { flow, ..self }
    }
}

/// A level set on its way. Its values are distances from the zero set in a band around it, and constant beyond.
#[derive(Clone, Debug)]
pub struct Evolution<const D: usize> {
    /// As it was when the values were distances last.
    grid: Grid<D>,
    values: Vec<f64>,
    band: Vec<usize>,
    options: EvolutionOptions,
    cell: f64,
    /// How far the zero set may have moved since the values were distances.
    travelled: f64,
    steps: usize,
}

impl<const D: usize> Evolution<D> {
    /// Starts with the zero set of a level function, which need not be a distance.
    ///
    /// # Errors
    /// [`Error::Empty`] without a zero, [`Error::Option`] for options that cannot be used.
    pub fn new(start: &Grid<D>, options: &EvolutionOptions) -> Result<Self, Error> {
        if !matches!(options.time_order, 1 | 3) {
            let (option, value) = ("time_order", options.time_order as f64);
            return Err(Error::Option { option, value, what: "it must be 1 or 3" });
        }
        let cell = start.spacing().min();
        let mut out = Self {
            grid: start.clone(),
            values: start.values().to_vec(),
            band: Vec::new(),
            options: *options,
            cell,
            travelled: 0.0,
            steps: 0,
        };
        out.redistance()?;
        Ok(out)
    }

    /// The level function: distances near the zero set, constant beyond nine cells or more.
    #[must_use]
    pub fn grid(&self) -> &Grid<D> {
        &self.grid
    }

    /// Steps in time so far.
    #[must_use]
    pub fn steps(&self) -> usize {
        self.steps
    }

    /// Makes the values distances again.
    pub(super) fn redistance(&mut self) -> Result<(), Error> {
        let [moving, distances] = if self.options.time_order == 1 { NARROW } else { WIDE };
        let moved = self.grid.with_values(std::mem::take(&mut self.values))?;
        self.grid = match redistance(&moved, Some(distances * self.cell)) {
            Err(distance_field::Error::NoPoints { .. }) => return Err(empty(moved.values())),
            found => found?.grid,
        };
        self.values = self.grid.values().to_vec();
        let near = moving * self.cell;
        self.band = (0..self.values.len()).filter(|&node| self.values[node].abs() < near).collect();
        self.travelled = 0.0;
        Ok(())
    }

    /// Moves the level set for a time. Ends with distances.
    ///
    /// # Errors
    /// [`Error::Empty`] where the level set vanishes, [`Error::Option`] for speeds that are not finite, not one per node, or a negative
    /// factor of the curvature, and where more steps than allowed would be needed.
    pub fn run(&mut self, motion: &Motion<'_, D>, time: f64) -> Result<(), Error> {
        self.check(motion, time)?;
        let mut left = time;
        let mut steps = 0;
        while left > 0.0 {
            let rate = self.rate(motion);
            // Nothing moves.
            if rate.stable <= 0.0 {
                return Ok(());
            }
            // A step is not longer than what the band allows.
            let step = (COURANT / rate.stable).min(left).min(self.cell / rate.speed.max(f64::MIN_POSITIVE));
            steps += 1;
            if steps > self.options.max_steps || step <= 0.0 {
                let what = "it needs more steps than allowed (max_steps); shorten it or lower the speeds";
                return Err(Error::Option { option: "time", value: time, what });
            }
            self.step(motion, step);
            left = if step == left { 0.0 } else { left - step };
            self.travelled += rate.speed * step;
            if self.travelled > TRAVEL * self.cell {
                self.redistance()?;
            }
        }
        self.redistance()
    }

    fn check(&self, motion: &Motion<'_, D>, time: f64) -> Result<(), Error> {
        let nodes = self.grid.values().len();
        let refuse = |option, value, what| Err(Error::Option { option, value, what });
        if !(time >= 0.0 && time.is_finite()) {
            return refuse("time", time, "it must be a number, at least 0");
        }
        let lengths = [
            ("propagation", motion.propagation.len()),
            ("curvature", motion.curvature.len()),
            ("flow", motion.flow.len()),
        ];
        for (option, length) in lengths {
            if length != 0 && length != nodes {
                return refuse(option, length as f64, "it must have one value for each node, or none at all");
            }
        }
        let flow = motion.flow.iter().flat_map(|v| v.iter());
        if let Some(bad) = motion.propagation.iter().chain(flow).find(|value| !value.is_finite()) {
            return refuse("speed", *bad, "all speeds must be finite");
        }
        match motion.curvature.iter().find(|value| !(**value >= 0.0 && value.is_finite())) {
            Some(bad) => refuse("curvature", *bad, "its factor must be finite and at least 0"),
            None => Ok(()),
        }
    }

    /// The largest speeds in the band.
    fn rate(&self, motion: &Motion<'_, D>) -> Rate {
        let spacing = self.grid.spacing();
        let (mut stable, mut speed) = (0.0f64, 0.0f64);
        for &node in &self.band {
            let a = motion.propagation.get(node).map_or(0.0, |a| a.abs());
            let b = motion.curvature.get(node).copied().unwrap_or(0.0);
            let (mut own, mut carried) = (a * (D as f64).sqrt() / self.cell, 0.0);
            if let Some(v) = motion.flow.get(node) {
                own += (0..D).map(|k| v[k].abs() / spacing[k]).sum::<f64>();
                carried = v.norm();
            }
            own += (0..D).map(|k| 2.0 * b / spacing[k].powi(2)).sum::<f64>();
            stable = stable.max(own);
            // A curvature that counts is at most that of a few cells.
            speed = speed.max(a + carried + 0.25 * b / self.cell);
        }
        Rate { stable, speed }
    }

    /// One step of Runge and Kutta that does not increase the variation, of third order (Shu & Osher 1988), or of Euler.
    fn step(&mut self, motion: &Motion<'_, D>, step: f64) {
        let before: Vec<f64> = self.band.iter().map(|&node| self.values[node]).collect();
        let stages: &[[f64; 2]] = if self.options.time_order == 1 {
            &[[0.0, 1.0]]
        } else {
            &[[0.0, 1.0], [0.75, 0.25], [1.0 / 3.0, 2.0 / 3.0]]
        };
        for [old, new] in stages {
            let rates = parallel::map(self.band.len(), |k| self.change(motion, self.band[k]));
            for ((&node, rate), before) in self.band.iter().zip(rates).zip(&before) {
                self.values[node] = old * before + new * (self.values[node] + step * rate);
            }
        }
        if self.options.fixed_topology {
            self.hold(&before);
        }
        self.steps += 1;
    }

    /// How fast the value of a node changes.
    fn change(&self, motion: &Motion<'_, D>, node: usize) -> f64 {
        let counts = self.grid.counts();
        let mut strides = [1; D];
        for k in (0..D.saturating_sub(1)).rev() {
            strides[k] = strides[k + 1] * counts[k + 1];
        }
        let stencil = Stencil { values: &self.values, counts, strides, spacing: *self.grid.spacing() };
        let at: [usize; D] = std::array::from_fn(|k| node / strides[k] % counts[k]);
        let a = motion.propagation.get(node).copied().unwrap_or(0.0);
        let b = motion.curvature.get(node).copied().unwrap_or(0.0);
        let flow = motion.flow.get(node);
        let mut rate = 0.0;
        if a != 0.0 || flow.is_some() {
            let mut squares = 0.0;
            for k in 0..D {
                let [below, above] = stencil.one_sided(node, at[k], k);
                // Godunov's choice: what comes to the node, from the side from which it comes.
                let [forth, back] = if a > 0.0 { [below, above] } else { [above, below] };
                squares += forth.max(0.0).powi(2).max(back.min(0.0).powi(2));
                if let Some(v) = flow {
                    rate -= v[k] * if v[k] > 0.0 { below } else { above };
                }
            }
            rate -= a * squares.sqrt();
        }
        if b != 0.0 {
            rate += b * stencil.bent(node, &at).1;
        }
        rate
    }

    /// Takes back changes of sides that would change the topology, node by node in their order.
    fn hold(&mut self, before: &[f64]) {
        let counts = self.grid.counts();
        let after: Vec<f64> = self.band.iter().map(|&node| self.values[node]).collect();
        for (&node, &value) in self.band.iter().zip(before) {
            self.values[node] = value;
        }
        for ((&node, &old), &new) in self.band.iter().zip(before).zip(&after) {
            let changes = (old < 0.0) != (new < 0.0);
            let may = !changes || region::is_simple(&counts, node, |other| self.values[other] < 0.0);
            self.values[node] = if may {
                new
            } else if old < 0.0 {
                -HELD * self.cell
            } else {
                HELD * self.cell
            };
        }
    }
}

/// Speeds in the band.
struct Rate {
    /// One over the longest stable step.
    stable: f64,
    /// Of the zero set.
    speed: f64,
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector2;

    fn circle(n: usize, radius: f64) -> Grid<2> {
        let h = 4.0 / (n - 1) as f64;
        Grid::sample(Vector2::repeat(-2.0), Vector2::repeat(h), [n, n], |p| {
            p.norm_squared() - radius * radius
        })
        .unwrap()
    }

    #[test]
    fn options_and_speeds_are_checked() {
        let grid = circle(21, 1.0);
        let odd = EvolutionOptions::default().with_time_order(2);
        assert!(matches!(Evolution::new(&grid, &odd), Err(Error::Option { option: "time_order", .. })));
        let none = grid.with_values(vec![1.0; 441]).unwrap();
        assert!(matches!(Evolution::new(&none, &EvolutionOptions::default()), Err(Error::Empty { .. })));
        let mut evolution = Evolution::new(&grid, &EvolutionOptions::default()).unwrap();
        let (nan, short, minus) = (vec![f64::NAN; 441], vec![1.0; 440], vec![-1.0; 441]);
        for bad in [
            Motion::default().with_propagation(&nan),
            Motion::default().with_propagation(&short),
            Motion::default().with_curvature(&minus),
        ] {
            assert!(matches!(evolution.run(&bad, 0.1), Err(Error::Option { .. })));
        }
        assert!(evolution.run(&Motion::default(), f64::INFINITY).is_err());
        evolution.run(&Motion::default(), 1.0).unwrap();
        assert_eq!(evolution.steps(), 0);
    }

    #[test]
    fn a_level_set_that_vanishes_is_an_error() {
        let mut evolution = Evolution::new(&circle(21, 0.5), &EvolutionOptions::default()).unwrap();
        let inwards = vec![-1.0; 441];
        let found = evolution.run(&Motion::default().with_propagation(&inwards), 1.0);
        assert!(matches!(found, Err(Error::Empty { .. })), "{found:?}");
    }
}
