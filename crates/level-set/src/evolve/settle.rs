//! Evolutions that come to rest.

use super::{Evolution, Motion};
use crate::Error;
use crate::region::{Topology, topology};
use distance_field::Grid;

/// Time between looks at how far the level set has moved, in cells at unit speed.
const PERIOD: f64 = 2.0;
/// Half the width of the band in which that is looked at, in cells.
const LOOK: f64 = 1.5;

/// A level set that has come to rest, or not.
#[derive(Clone, Debug)]
pub struct Evolved<const D: usize> {
    /// The level function: distances near its zero set.
    pub grid: Grid<D>,
    /// Whether it came to rest, by less than the tolerance of the options.
    pub is_settled: bool,
    /// Steps in time.
    pub steps: usize,
    /// How fast it moved at last, in cells per unit of time: root mean square.
    pub speed: f64,
    /// Components and holes at the start.
    pub before: Topology,
    /// Components and holes at the end.
    pub after: Topology,
}

/// Lets a level set move until it rests: `motion` is asked for the speeds in the course of it.
pub(super) fn until_rest<const D: usize>(
    mut evolution: Evolution<D>,
    tolerance: f64,
    periods: usize,
    mut motion: impl FnMut(&Grid<D>, &mut dyn FnMut(&Motion<'_, D>) -> Result<(), Error>) -> Result<(), Error>,
) -> Result<Evolved<D>, Error> {
    let counts = evolution.grid().counts();
    let cell = evolution.grid().spacing().min();
    let before = topology(&counts, evolution.grid().values());
    let mut speed = f64::INFINITY;
    let mut quiet = 0;
    for _ in 0..periods {
        let last = evolution.grid().clone();
        motion(&last, &mut |motion| evolution.run(motion, PERIOD * cell))?;
        let pairs = last.values().iter().zip(evolution.grid().values());
        let near = pairs.filter(|(_, now)| now.abs() < LOOK * cell);
        let (sum, count) =
            near.fold((0.0, 0usize), |(sum, count), (then, now)| (sum + (now - then).powi(2), count + 1));
        // What flickers at a few nodes is no movement.
        speed = (sum / count.max(1) as f64).sqrt() / (PERIOD * cell);
        quiet = if speed <= tolerance { quiet + 1 } else { 0 };
        if quiet == 2 {
            break;
        }
    }
    let after = topology(&counts, evolution.grid().values());
    let steps = evolution.steps();
    Ok(Evolved { grid: evolution.grid().clone(), is_settled: quiet == 2, steps, speed, before, after })
}
