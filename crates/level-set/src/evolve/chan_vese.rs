//! Regions that evolve until inside and outside are as even as they can be (Chan & Vese, *Active contours without edges*, 2001).

use super::settle::{Evolved, until_rest};
use super::{Evolution, EvolutionOptions, Motion};
use crate::Error;
use distance_field::Grid;

/// How a region evolves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ChanVeseOptions {
    /// Weight of the length (in space the area) of the contour, in cells: wiggles with radii below it are smoothed away; default 0.3.
    pub length_weight: f64,
    /// Whether the numbers of components and holes of the start stay as they are; default not.
    pub fixed_topology: bool,
    /// Speed at which the contour counts as resting, in cells per unit of time; default 2e-3.
    pub tolerance: f64,
    /// Most periods of two units of time; default 250.
    pub max_periods: usize,
}

impl Default for ChanVeseOptions {
    fn default() -> Self {
        Self { length_weight: 0.3, fixed_topology: false, tolerance: 2e-3, max_periods: 250 }
    }
}

impl ChanVeseOptions {
    /// The same options with another weight of the length.
    #[must_use]
    pub fn with_length_weight(self, length_weight: f64) -> Self {
        Self { length_weight, ..self }
    }

    /// The same options with a topology that is held or not.
    #[must_use]
    pub fn with_fixed_topology(self, fixed_topology: bool) -> Self {
        Self { fixed_topology, ..self }
    }
}

/// Means of values inside and outside; a node between them counts for both by its distance.
fn means<const D: usize>(values: &[f64], levels: &Grid<D>) -> Option<[f64; 2]> {
    let cell = levels.spacing().min();
    let (mut sums, mut weights) = ([0.0; 2], [0.0; 2]);
    for (value, level) in values.iter().zip(levels.values()) {
        let inside = (0.5 - level / (2.0 * cell)).clamp(0.0, 1.0);
        for (side, weight) in [inside, 1.0 - inside].into_iter().enumerate() {
            sums[side] += weight * value;
            weights[side] += weight;
        }
    }
    (weights[0] > 0.0 && weights[1] > 0.0).then(|| [sums[0] / weights[0], sums[1] / weights[1]])
}

/// Moves the zero set of `start` until the squared differences of the `values` from their means inside and outside, plus the weighted
/// length of the contour, are least. Both grids have the same nodes.
///
/// The zero set moves in its narrow band: it parts, joins and loses components, but none appears far from it. The speed is that of the
/// functional, `1` at values as far from the middle of the means as the means are, and no more.
///
/// # Errors
/// [`Error::Empty`] where the level set has no point or vanishes, [`Error::NoContrast`] where inside and outside have the same mean,
/// [`Error::Option`] for options that cannot be used.
pub fn chan_vese<const D: usize>(
    values: &Grid<D>,
    start: &Grid<D>,
    options: &ChanVeseOptions,
) -> Result<Evolved<D>, Error> {
    if !(options.length_weight >= 0.0 && options.length_weight <= 1e3) {
        let (option, value) = ("length_weight", options.length_weight);
        return Err(Error::Option { option, value, what: "it must be a number of cells from 0 to 1000" });
    }
    if values.counts() != start.counts() {
        let value = start.values().len() as f64;
        return Err(Error::Option { option: "start", value, what: "it must have the nodes of the values" });
    }
    let settings = EvolutionOptions::default().with_fixed_topology(options.fixed_topology).with_time_order(1);
    let evolution = Evolution::new(start, &settings)?;
    let cell = start.spacing().min();
    // A unit of time moves the contour by a cell at unit speed.
    let curvature = vec![options.length_weight * cell; values.values().len()];
    until_rest(evolution, options.tolerance, options.max_periods, |levels, run| {
        let means = means(values.values(), levels);
        let [inside, outside] = means.ok_or_else(|| crate::contour::empty(levels.values()))?;
        let difference = inside - outside;
        if difference.abs() <= f64::EPSILON * inside.abs().max(outside.abs()) {
            return Err(Error::NoContrast { value: inside });
        }
        let speed = |value: &f64| ((2.0 * value - inside - outside) / difference).clamp(-1.0, 1.0);
        let propagation: Vec<f64> = values.values().iter().map(speed).collect();
        run(&Motion::default().with_propagation(&propagation).with_curvature(&curvature))
    })
}
