//! Contours that are drawn to edges (Caselles, Kimmel & Sapiro, *Geodesic active contours*, 1997).

use super::settle::{Evolved, until_rest};
use super::{Evolution, EvolutionOptions, Motion};
use crate::{Error, Image};
use distance_field::Grid;
use nalgebra::SVector;

/// Share of the nodes with the steepest slopes, and the share of the slope there that counts as an edge.
const STEEP: f64 = 0.05;
const EDGE: f64 = 0.3;

/// How a contour is drawn to edges.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GeodesicOptions {
    /// Weight of the curvature, in cells; default 0.5.
    pub smoothness: f64,
    /// Speed along the normals where there is no edge: positive grows, negative shrinks; default −1.
    pub balloon: f64,
    /// How strongly the slope of the edge indicator draws the contour, in cells; default 2.
    pub attraction: f64,
    /// Whether the numbers of components and holes of the start stay as they are; default not.
    pub fixed_topology: bool,
    /// Speed at which the contour counts as resting, in cells per unit of time; default 1e-2.
    pub tolerance: f64,
    /// Most periods of two units of time; default 600.
    pub max_periods: usize,
}

impl Default for GeodesicOptions {
    fn default() -> Self {
        Self {
            smoothness: 0.5,
            balloon: -1.0,
            attraction: 2.0,
            fixed_topology: false,
            tolerance: 1e-2,
            max_periods: 600,
        }
    }
}

impl GeodesicOptions {
    /// The same options with another weight of the curvature.
    #[must_use]
    pub fn with_smoothness(self, smoothness: f64) -> Self {
        Self { smoothness, ..self }
    }

    /// The same options with another speed where there is no edge.
    #[must_use]
    pub fn with_balloon(self, balloon: f64) -> Self {
        Self { balloon, ..self }
    }

    /// The same options with a topology that is held or not.
    #[must_use]
    pub fn with_fixed_topology(self, fixed_topology: bool) -> Self {
        Self { fixed_topology, ..self }
    }
}

/// Central differences at every node, one-sided at the border.
fn gradients<const D: usize>(grid: &Grid<D>) -> Vec<SVector<f64, D>> {
    let (counts, values, spacing) = (grid.counts(), grid.values(), grid.spacing());
    let mut strides = [1; D];
    for k in (0..D.saturating_sub(1)).rev() {
        strides[k] = strides[k + 1] * counts[k + 1];
    }
    crate::parallel::map(values.len(), |node| {
        SVector::from_fn(|k, _| {
            let at = node / strides[k] % counts[k];
            let (below, above) = (at.min(1), (counts[k] - 1 - at).min(1));
            let rise = values[node + above * strides[k]] - values[node - below * strides[k]];
            rise / ((below + above) as f64 * spacing[k])
        })
    })
}

/// One over one plus the squared slope of (smoothed) values: 1 where they are even, near 0 on edges. The slope that counts as an edge is
/// 0.3 of the one that a twentieth of the nodes exceeds.
///
/// # Errors
/// [`Error::NoContrast`] for values that are the same everywhere.
pub fn edge_indicator<const D: usize>(values: &Grid<D>) -> Result<Vec<f64>, Error> {
    let slopes: Vec<f64> = gradients(values).iter().map(SVector::norm).collect();
    let mut sorted = slopes.clone();
    sorted.sort_by(f64::total_cmp);
    let last = sorted.len() - 1;
    let steep = sorted.get(last - to_index(STEEP * last as f64)).copied().unwrap_or(0.0);
    let steepest = sorted.last().copied().unwrap_or(0.0);
    // Few steep places in an even image are edges as well.
    let scale = EDGE * if steep > 0.1 * steepest { steep } else { steepest };
    if !(scale > 0.0 && scale.is_finite()) {
        return Err(Error::NoContrast { value: values.values().first().copied().unwrap_or(0.0) });
    }
    Ok(slopes.iter().map(|slope| 1.0 / (1.0 + (slope / scale).powi(2))).collect())
}

/// Moves the zero set of `start` by `φ_t = g (w κ − b) |∇φ| + c ∇g · ∇φ`, with the smoothness `w`, the balloon `b` and the attraction
/// `c`, until it rests on edges of the `values` (smoothed before, as an edge has no place between the nodes otherwise), where the
/// indicator `g` is least.
///
/// # Errors
/// [`Error::Empty`] where the level set has no point or vanishes (it shrank over everything: make the balloon weaker, or start nearer),
/// [`Error::NoContrast`], and [`Error::Option`] for options that cannot be used.
pub fn geodesic_contour<const D: usize>(
    values: &Grid<D>,
    start: &Grid<D>,
    options: &GeodesicOptions,
) -> Result<Evolved<D>, Error> {
    let allowed = [
        ("smoothness", options.smoothness, 0.0),
        ("balloon", options.balloon, -10.0),
        ("attraction", options.attraction, 0.0),
    ];
    for (option, value, least) in allowed {
        if !(least..=10.0).contains(&value) {
            return Err(Error::Option { option, value, what: "it must be a number up to 10 in size" });
        }
    }
    if values.counts() != start.counts() {
        let value = start.values().len() as f64;
        return Err(Error::Option { option: "start", value, what: "it must have the nodes of the values" });
    }
    let indicator = values.with_values(edge_indicator(values)?)?;
    let cell = start.spacing().min();
    let curvature: Vec<f64> = indicator.values().iter().map(|g| options.smoothness * cell * g).collect();
    let propagation: Vec<f64> = indicator.values().iter().map(|g| options.balloon * g).collect();
    let flow: Vec<SVector<f64, D>> =
        gradients(&indicator).into_iter().map(|slope| slope * (-options.attraction * cell)).collect();
    let settings = EvolutionOptions::default().with_fixed_topology(options.fixed_topology).with_time_order(1);
    let evolution = Evolution::new(start, &settings)?;
    until_rest(evolution, options.tolerance, options.max_periods, |_, run| {
        run(&Motion::default().with_propagation(&propagation).with_curvature(&curvature).with_flow(&flow))
    })
}

/// The signed distance from a box inside the border of an image, to start from.
///
/// # Errors
/// [`Error::Option`] for an inset that leaves nothing.
pub fn inset_box(image: &Image, inset: f64) -> Result<Grid<2>, Error> {
    let sides = [image.width() as f64, image.height() as f64];
    if !(inset >= 1.0 && 2.0 * inset + 2.0 <= sides[0].min(sides[1])) {
        let what = "it must be at least 1 pixel, and leave 2 pixels";
        return Err(Error::Option { option: "inset", value: inset, what });
    }
    let grid = image.grid()?;
    let level = |node: usize| {
        let p = grid.position(node);
        (0..2)
            .map(|k| (p[k] - 0.5 * sides[k]).abs() - 0.5 * sides[k] + inset)
            .fold(f64::NEG_INFINITY, f64::max)
    };
    Ok(grid.with_values((0..grid.values().len()).map(level).collect())?)
}

#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a share of a number of nodes")]
fn to_index(value: f64) -> usize {
    value as usize
}
