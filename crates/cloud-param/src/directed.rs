//! Directed projection: from a place along a direction onto a cloud.

use crate::{Error, Neighbourhood};
use nalgebra::Vector3;

/// Weights of the points of a cloud in a directed projection.
///
/// `r` is the distance of a point from the place, `s` its distance from the line along the direction, `h` the spacing of
/// the cloud. All weights are made independent of the unit of length by `h`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(rename_all = "snake_case"))]
pub enum DirectedWeight {
    /// `1/(r² + ε²)²`: near points count ([MPK, eq. (15)], with a bound where `r = 0`).
    Near,
    /// `1/(1 + r² s²/h⁴)`: points near the line count at any distance ([MPK, eq. (16)], read with the distance from the
    /// line). Over all points of a closed cloud it diverges, since those behind count as well; among neighbours it is good.
    Axis,
    /// `1/((r² + ε²)² (s² + ε²))`: both ([MPK, eq. (19)], with a bound at its poles).
    #[default]
    NearAxis,
}

/// Options of a directed projection.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct DirectedOptions {
    /// Weights; default [`DirectedWeight::NearAxis`].
    pub weight: DirectedWeight,
    /// Number of nearest points that count; default 50.
    pub neighbours: usize,
    /// `ε` in spacings of the cloud; default 0.1. It takes the place of distances that are smaller.
    pub regularisation: f64,
}

impl Default for DirectedOptions {
    fn default() -> Self {
        Self { weight: DirectedWeight::default(), neighbours: 50, regularisation: 0.1 }
    }
}

impl DirectedOptions {
    /// The same options with another weight.
    #[must_use]
    pub fn with_weight(self, weight: DirectedWeight) -> Self {
        Self { weight, ..self }
    }

    /// The same options with another number of neighbours.
    #[must_use]
    pub fn with_neighbours(self, neighbours: usize) -> Self {
        Self { neighbours, ..self }
    }

    /// The same options with another regularisation.
    #[must_use]
    pub fn with_regularisation(self, regularisation: f64) -> Self {
        Self { regularisation, ..self }
    }

    pub(crate) fn check(&self) -> Result<(), Error> {
        if self.neighbours == 0 {
            return Err(Error::Option { name: "neighbours", value: 0.0, allowed: "at least 1" });
        }
        if !(self.regularisation > 0.0 && self.regularisation.is_finite()) {
            let value = self.regularisation;
            return Err(Error::Option { name: "regularisation", value, allowed: "a positive number" });
        }
        Ok(())
    }
}

/// Where a directed projection leads.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DirectedFoot {
    /// The place `p* = p + t n` on the line.
    pub point: Vector3<f64>,
    /// `t`, for a direction of length 1.
    pub offset: f64,
    /// What the sum over all points of the cloud could change about `t`, at most.
    ///
    /// Points that are not among the neighbours are at least as far as the last of these, so that their weights have a
    /// bound. For [`DirectedWeight::Axis`], whose weights do not fall off along the line, it is of the size of the cloud.
    pub bound: f64,
}

/// Projects a place onto a cloud along a direction ([MPK, eqs. (7)-(14)]): the place on the line with the least weighted sum
/// of squared distances, in one pass over the neighbours. `None` for a direction of no length.
///
/// With `⟨n, n⟩ = 1`, eqs. (12)-(13) are `t = Σ a_d ⟨p_d − p, n⟩ / Σ a_d`; written with differences nothing cancels far from
/// the origin.
///
/// # Errors
/// [`Error::Option`] for options that are not usable.
///
/// ```
/// use cloud_param::{DirectedOptions, Neighbourhood, project_directed};
/// use nalgebra::Vector3;
///
/// let plane: Vec<_> = (0..400).map(|i| Vector3::new(f64::from(i % 20), f64::from(i / 20), 3.0)).collect();
/// let cloud = Neighbourhood::new(&plane)?;
/// let foot = project_directed(&cloud, &Vector3::new(9.3, 9.6, 5.0), &Vector3::z(), &DirectedOptions::default())?;
/// assert!((foot.unwrap().point - Vector3::new(9.3, 9.6, 3.0)).norm() < 1e-12);
/// # Ok::<(), cloud_param::Error>(())
/// ```
pub fn project_directed(
    cloud: &Neighbourhood,
    place: &Vector3<f64>,
    direction: &Vector3<f64>,
    options: &DirectedOptions,
) -> Result<Option<DirectedFoot>, Error> {
    options.check()?;
    Ok(direction.try_normalize(0.0).map(|n| project(cloud, place, &n, options)))
}

/// The same for a unit vector and options that are known to be usable.
pub(crate) fn project(
    cloud: &Neighbourhood,
    place: &Vector3<f64>,
    n: &Vector3<f64>,
    options: &DirectedOptions,
) -> DirectedFoot {
    let h = cloud.spacing();
    let e_sq = options.regularisation * options.regularisation;
    let weight = |r_sq: f64, s_sq: f64| match options.weight {
        DirectedWeight::Near => 1.0 / (r_sq + e_sq).powi(2),
        DirectedWeight::Axis => 1.0 / (1.0 + r_sq * s_sq),
        DirectedWeight::NearAxis => 1.0 / ((r_sq + e_sq).powi(2) * (s_sq + e_sq)),
    };
    let (mut total, mut moment, mut farthest, mut found) = (0.0, 0.0, 0.0f64, 0usize);
    for (point, distance) in cloud.nearest(place, options.neighbours) {
        let d = (point - place) / h;
        let along = d.dot(n);
        let r_sq = d.norm_squared();
        let a = weight(r_sq, d.cross(n).norm_squared());
        total += a;
        moment += a * along;
        farthest = distance / h;
        found += 1;
    }
    if total == 0.0 || !total.is_finite() {
        return DirectedFoot { point: *place, offset: 0.0, bound: f64::INFINITY };
    }
    let t = moment / total;
    let others = (cloud.points().len() - found) as f64;
    // |t_all − t| ≤ Σ a (r + |t|) / Σ_near a; a (r + |t|) falls with r from the last neighbour on, but for eq. (16).
    let reach = if options.weight == DirectedWeight::Axis { cloud.reach(place) / h } else { farthest };
    let bound = if found == cloud.points().len() {
        0.0
    } else {
        others * weight(farthest * farthest, 0.0) * (reach + t.abs()) / total
    };
    DirectedFoot { point: place + n * (t * h), offset: t * h, bound: bound * h }
}
