//! Options of surface fits.

use super::base_shape::{BaseShape, NetSize};
use crate::{Error, FitOptions};

/// Factor of the fairing by default: the least that leaves no folds in noisy scans.
const FAIRING: f64 = 3e-5;
/// Damping by default: without it a surface of few control points slides beyond the ends of the data, where nothing holds it.
const DAMPING: f64 = 0.01;

/// How a cloud is made a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct SurfaceOptions {
    /// What gives the first parameters; default [`BaseShape::Auto`].
    pub base: BaseShape,
    /// Degrees and control points to begin with.
    pub size: NetSize,
    /// Largest distance that is wanted (a length): knots are inserted until it holds or the cap is met, a few damped steps after
    /// each insertion, and removed where they carry nothing; default none.
    pub abs_tolerance: Option<f64>,
    /// Share of the points that must lie within the tolerance; default 1.
    pub share: f64,
    /// Most control points (not counting repetitions); default 10 000.
    pub max_controls: usize,
    /// How many rows of control points stay where they are at each open side of the start, in the order of
    /// [`Side::ALL`](nurbs_core::construct::Side::ALL): one keeps the boundary curve, two the tangent planes along it, too; default none. Knots are
    /// then not removed, and the sides count as data for the coverage.
    pub held: [usize; 4],
    /// Whether weights are unknowns, too, so that cylinders, spheres, other quadrics and tori are exact; default not. Boundaries
    /// are free then.
    pub rational: bool,
    /// How often the loop goes on with more fairing around cells that are folded; default 6.
    pub unfoldings: usize,
    /// Whether a surface on which the points lie nearly exactly is fitted on without any energy, which makes it exact where that is
    /// possible; default yes.
    pub exact: bool,
    /// Whether it is measured how near the parts of the surface are to the points; default yes.
    pub coverage: bool,
    /// The loop; the default takes second derivatives as energy, fairs parameter lines, damps steps a little, and stops after 100
    /// iterations or three that change the mean squared distance by less than 0.2 %.
    pub fit: FitOptions,
}

impl Default for SurfaceOptions {
    fn default() -> Self {
        Self {
            base: BaseShape::Auto,
            size: NetSize::default(),
            abs_tolerance: None,
            share: 1.0,
            max_controls: 10_000,
            held: [0; 4],
            rational: false,
            unfoldings: 6,
            exact: true,
            coverage: true,
            fit: FitOptions::default()
                .with_energy([0.0, 1.0, 0.0])
                .with_tolerance(1e-6)
                .with_cost_tolerance(2e-3)
                .with_fairing(FAIRING)
                .with_damping(DAMPING),
        }
    }
}

macro_rules! setters {
    ($($(#[$doc:meta])* $name:ident($field:ident: $type:ty);)*) => {$(
        $(#[$doc])*
        #[must_use]
        pub fn $name(self, $field: $type) -> Self {
            Self { $field, ..self }
        }
    )*};
}

impl SurfaceOptions {
    setters! {
        /// The same options with another base.
        with_base(base: BaseShape);
        /// The same options with other degrees and numbers of control points.
        with_size(size: NetSize);
        /// The same options with or without a tolerance.
        with_abs_tolerance(abs_tolerance: Option<f64>);
        /// The same options with another share of points within the tolerance.
        with_share(share: f64);
        /// The same options with another cap on the control points.
        with_max_controls(max_controls: usize);
        /// The same options with other rows of control points that stay.
        with_held(held: [usize; 4]);
        /// The same options with or without weights.
        with_rational(rational: bool);
        /// The same options with another number of attempts at folds.
        with_unfoldings(unfoldings: usize);
        /// The same options with or without a last run without energy.
        with_exact(exact: bool);
        /// The same options with or without the distances of the surface from the points.
        with_coverage(coverage: bool);
        /// The same options for the loop.
        with_fit(fit: FitOptions);
    }

    /// The same options with a boundary that stays or moves.
    #[must_use]
    pub fn with_fixed_boundary(self, fixed: bool) -> Self {
        self.with_held([usize::from(fixed); 4])
    }

    /// Whether some control points stay.
    pub(super) fn holds_some(&self) -> bool {
        self.held.iter().any(|rows| *rows > 0)
    }

    pub(crate) fn check(&self) -> Result<(), Error> {
        self.fit.check()?;
        match self.abs_tolerance {
            Some(value) if !(value > 0.0 && value.is_finite()) => {
                Err(Error::Option { name: "abs_tolerance", value, allowed: "a positive length" })
            }
            _ if !(self.share > 0.0 && self.share <= 1.0) => {
                Err(Error::Option { name: "share", value: self.share, allowed: "in (0, 1]" })
            }
            _ => Ok(()),
        }
    }
}
