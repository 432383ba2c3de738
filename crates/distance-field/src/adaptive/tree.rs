//! The tree: how it is built, and what it says about a point.

use super::polynomial::{self, MOST};
use crate::{Error, parallel};
use nalgebra::{SMatrix, SVector};
use nurbs_core::Aabb;

/// Places along each axis at which the polynomial of a leaf is tested; none is one of interpolation.
const TESTS: [f64; 4] = [0.125, 0.375, 0.625, 0.875];
/// A cell without children.
pub(super) const LEAF: u32 = 0;

/// How an [`AdaptiveField`] is built.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct AdaptiveOptions {
    /// Largest difference of function and polynomial, a length; default 1e-3.
    pub abs_tolerance: f64,
    /// Distance from the zero set within which the tolerance holds; default everywhere. Needs a function that grows by no more than
    /// the distance.
    pub band: Option<f64>,
    /// Degree along each axis, from 1 to 3; default 3.
    pub degree: usize,
    /// Levels below the root at most; default 12.
    pub max_depth: u32,
    /// Leaves at most; default 1 000 000. Refinement stops there, level by level.
    pub max_leaves: usize,
}

impl Default for AdaptiveOptions {
    fn default() -> Self {
        Self { abs_tolerance: 1e-3, band: None, degree: MOST, max_depth: 12, max_leaves: 1_000_000 }
    }
}

impl AdaptiveOptions {
    /// The same options with another largest error.
    #[must_use]
    pub fn with_abs_tolerance(self, abs_tolerance: f64) -> Self {
        Self { abs_tolerance, ..self }
    }

    /// The same options with another band.
    #[must_use]
    pub fn with_band(self, band: Option<f64>) -> Self {
        Self { band, ..self }
    }

    /// The same options with another degree.
    #[must_use]
    pub fn with_degree(self, degree: usize) -> Self {
        Self { degree, ..self }
    }

    /// The same options with another number of levels.
    #[must_use]
    pub fn with_max_depth(self, max_depth: u32) -> Self {
        Self { max_depth, ..self }
    }

    fn check(&self) -> Result<(), Error> {
        let refuse = |option, value, what| Err(Error::Option { option, value, what });
        if !(self.abs_tolerance > 0.0 && self.abs_tolerance.is_finite()) {
            return refuse("abs_tolerance", self.abs_tolerance, "it must be a positive length");
        }
        if let Some(band) = self.band.filter(|band| !(*band > 0.0 && band.is_finite())) {
            return refuse("band", band, "it must be a positive length");
        }
        if !(1..=MOST).contains(&self.degree) {
            return refuse("degree", self.degree as f64, "it must be 1, 2 or 3");
        }
        Ok(())
    }
}

/// What came out of building an [`AdaptiveField`].
#[derive(Clone, Copy, Debug, PartialEq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct AdaptiveReport {
    /// Cells, inner ones included.
    pub cells: usize,
    /// Cells with a polynomial.
    pub leaves: usize,
    /// Levels below the root.
    pub depth: u32,
    /// Values of the function that were computed.
    pub evaluations: usize,
    /// Bytes held.
    pub memory: usize,
    /// Largest difference at a test point, of leaves within the band.
    pub largest_error: f64,
    /// Leaves within the band in which the tolerance was not reached.
    pub open_leaves: usize,
}

/// A function on a box as polynomials on the leaves of a quadtree or octree.
#[derive(Clone, Debug, PartialEq)]
pub struct AdaptiveField<const D: usize> {
    pub(super) low: SVector<f64, D>,
    pub(super) high: SVector<f64, D>,
    pub(super) degree: usize,
    pub(super) abs_tolerance: f64,
    /// For each cell the first of its children, which stand one after the other, or [`LEAF`].
    pub(super) children: Vec<u32>,
    /// For each cell the number of its polynomial; of no meaning for inner cells.
    pub(super) leaf: Vec<u32>,
    pub(super) coefficients: Vec<f64>,
    /// Around the zero set.
    pub(super) bounds: Aabb<D>,
}

/// The polynomial of a cell that may become a leaf.
struct Trial {
    coefficients: Vec<f64>,
    error: f64,
    /// Whether the tolerance shall hold there.
    is_within: bool,
    /// Whether the zero set may pass.
    is_near: bool,
}

impl<const D: usize> AdaptiveField<D> {
    /// Samples a function on the box from `low` to `high`. Runs in parallel; the result does not depend on the number of threads.
    ///
    /// # Errors
    /// [`Error::Option`] for options that cannot be used, [`Error::Grid`] for a box without extent or a function that is not finite,
    /// and [`Error::NoPoints`] where it has no zero.
    pub fn build(
        low: SVector<f64, D>,
        high: SVector<f64, D>,
        options: &AdaptiveOptions,
        function: impl Fn(&SVector<f64, D>) -> f64 + Sync,
    ) -> Result<(Self, AdaptiveReport), Error> {
        options.check()?;
        if !(0..D).all(|k| low[k].is_finite() && (high[k] - low[k]).is_finite() && high[k] > low[k]) {
            let what = format!("the box from {:?} to {:?} has no extent", low.as_slice(), high.as_slice());
            return Err(Error::Grid { what });
        }
        let mut out = Self {
            low,
            high,
            degree: options.degree,
            abs_tolerance: options.abs_tolerance,
            children: vec![LEAF],
            leaf: vec![0],
            coefficients: Vec::new(),
            bounds: Aabb { min: low, max: high },
        };
        let per_cell = polynomial::count::<D>(options.degree);
        let mut report = AdaptiveReport::default();
        // The cells of a level, each with its lower corner.
        let mut level = vec![(0usize, low)];
        let mut sides = high - low;
        let mut near: Vec<(SVector<f64, D>, SVector<f64, D>)> = Vec::new();
        for depth in 0..=options.max_depth {
            let trials = parallel::map(level.len(), |k| trial(&level[k].1, &sides, options, &function));
            report.evaluations += level.len() * (per_cell + TESTS.len().pow(u32::try_from(D).unwrap_or(3)));
            report.depth = depth;
            let is_last = depth == options.max_depth
                || report.leaves + (level.len() << D) > options.max_leaves
                || out.children.len() + (level.len() << D) > u32::MAX as usize;
            let mut next = Vec::new();
            for ((cell, corner), trial) in level.iter().zip(trials) {
                if !trial.error.is_finite() {
                    let what = format!("the function is not finite in the cell at {:?}", corner.as_slice());
                    return Err(Error::Grid { what });
                }
                let is_open = trial.is_within && trial.error > options.abs_tolerance;
                if is_open && !is_last {
                    let first = out.children.len();
                    out.children[*cell] = u32::try_from(first).unwrap_or(u32::MAX);
                    for child in 0..1usize << D {
                        let offset = SVector::from_fn(|k, _| 0.5 * (child >> k & 1) as f64 * sides[k]);
                        next.push((first + child, corner + offset));
                        out.children.push(LEAF);
                        out.leaf.push(0);
                    }
                    continue;
                }
                out.leaf[*cell] = u32::try_from(report.leaves).unwrap_or(u32::MAX);
                out.coefficients.extend(trial.coefficients);
                report.leaves += 1;
                report.open_leaves += usize::from(is_open);
                if trial.is_within {
                    report.largest_error = report.largest_error.max(trial.error);
                }
                if trial.is_near {
                    near.push((*corner, sides));
                }
            }
            if next.is_empty() {
                break;
            }
            level = next;
            sides *= 0.5;
        }
        report.cells = out.children.len();
        report.memory = 8 * out.coefficients.len() + 8 * out.children.len();
        out.bounds = out.around(&near).ok_or(Error::NoPoints { count: report.evaluations })?;
        Ok((out, report))
    }

    /// A box around the zero set: around the feet of sample points in the leaves near it, or around these leaves.
    fn around(&self, near: &[(SVector<f64, D>, SVector<f64, D>)]) -> Option<Aabb<D>> {
        let feet = |(corner, sides): &(SVector<f64, D>, SVector<f64, D>)| {
            let (corner, sides) = (*corner, *sides);
            let per_leaf = TESTS.len().pow(u32::try_from(D).unwrap_or(3));
            (0..per_leaf).filter_map(move |number| {
                let place = SVector::<f64, D>::from_fn(|k, _| TESTS[number >> (2 * k) & 3]);
                let x = corner + place.component_mul(&sides);
                let (value, gradient, _) = self.taylor(&x)?;
                let foot = x - gradient * (value / gradient.norm_squared());
                let share = (foot - corner).component_div(&sides);
                share.iter().all(|s| (0.0..=1.0).contains(s)).then_some(foot)
            })
        };
        let feet: Vec<SVector<f64, D>> = near.iter().flat_map(feet).collect();
        let corners: Vec<SVector<f64, D>> =
            near.iter().flat_map(|(corner, sides)| [*corner, corner + sides]).collect();
        Aabb::of_points(feet.iter()).or_else(|| Aabb::of_points(corners.iter()))
    }

    /// The box.
    #[must_use]
    pub fn limits(&self) -> (SVector<f64, D>, SVector<f64, D>) {
        (self.low, self.high)
    }

    /// Number of leaves.
    #[must_use]
    pub fn leaves(&self) -> usize {
        self.coefficients.len() / polynomial::count::<D>(self.degree)
    }

    /// The polynomial at a point of the box, the place in its leaf, and the sides of that.
    fn at(&self, x: &SVector<f64, D>) -> Option<(&[f64], SVector<f64, D>, SVector<f64, D>)> {
        let mut sides = self.high - self.low;
        let mut place = (x - self.low).component_div(&sides);
        if !place.iter().all(|p| (0.0..=1.0).contains(p)) {
            return None;
        }
        let mut cell = 0;
        while self.children[cell] != LEAF {
            let mut child = 0;
            for k in 0..D {
                let upper = place[k] > 0.5;
                child |= usize::from(upper) << k;
                place[k] = 2.0 * place[k] - if upper { 1.0 } else { 0.0 };
            }
            sides *= 0.5;
            cell = self.children[cell] as usize + child;
        }
        let count = polynomial::count::<D>(self.degree);
        let first = self.leaf[cell] as usize * count;
        Some((&self.coefficients[first..first + count], place, sides))
    }

    /// The value at a point; `None` outside of the box and for points that are not finite.
    #[must_use]
    pub fn value(&self, x: &SVector<f64, D>) -> Option<f64> {
        let (coefficients, place, _) = self.at(x)?;
        Some(polynomial::value(self.degree, coefficients, &place))
    }

    /// Value, gradient and Hessian at a point; `None` outside of the box and for points that are not finite.
    #[must_use]
    pub fn taylor(&self, x: &SVector<f64, D>) -> Option<(f64, SVector<f64, D>, SMatrix<f64, D, D>)> {
        let (coefficients, place, sides) = self.at(x)?;
        let (value, gradient, hessian) = polynomial::taylor(self.degree, coefficients, &place);
        let scaled = SMatrix::from_fn(|i, j| hessian[(i, j)] / (sides[i] * sides[j]));
        Some((value, gradient.component_div(&sides), scaled))
    }
}

/// Interpolates and tests on one cell.
fn trial<const D: usize>(
    corner: &SVector<f64, D>,
    sides: &SVector<f64, D>,
    options: &AdaptiveOptions,
    function: &impl Fn(&SVector<f64, D>) -> f64,
) -> Trial {
    let at = |place: &SVector<f64, D>| function(&(corner + place.component_mul(sides)));
    let degree = options.degree;
    let coefficients: Vec<f64> =
        (0..polynomial::count::<D>(degree)).map(|number| at(&polynomial::place(degree, number))).collect();
    let mut least = coefficients.iter().fold(f64::INFINITY, |least, value| least.min(value.abs()));
    let mut error = if coefficients.iter().all(|value| value.is_finite()) { 0.0f64 } else { f64::NAN };
    for number in 0..TESTS.len().pow(u32::try_from(D).unwrap_or(3)) {
        let place = SVector::from_fn(|k, _| TESTS[number >> (2 * k) & 3]);
        let value = at(&place);
        least = least.min(value.abs());
        // Not a number stays so.
        let difference = (value - polynomial::value(degree, &coefficients, &place)).abs();
        error = if difference <= error { error } else { difference };
        if error.is_nan() {
            break;
        }
    }
    // No sample is further than this from any point of the cell.
    let reach = 0.5 * sides.norm();
    let is_within = options.band.is_none_or(|band| least <= band + reach);
    Trial { coefficients, error, is_within, is_near: least <= reach }
}
