//! Projection onto one or several B-spline curves.

use super::Progress;
use super::all_feet::{self, CurveFeet};
use super::batch::{self, Batch, Queries, Receive};
use super::frame::Frame;
use crate::global::arithmetic::simd::vectorized;
use crate::global::curve::piece::PieceSet;
use crate::global::curve::scratch::CurveScratch;
use crate::global::gap::Gap;
use crate::{CurveFootpoint, Error, Location, Mode, Multiplicity, ProjectionOptions, Status, UpdateOptions};
use nalgebra::SVector;
use nurbs_core::BsplineCurve;
use std::borrow::Cow;

/// Rounding error of the squared distance form of a piece, as a share of the squared size of the model.
const ROUNDING: f64 = 64.0 * f64::EPSILON;

/// Projects points onto one or several B-spline or NURBS curves of `R^D`.
///
/// ```
/// # use nurbs_core::BsplineCurve;
/// # use nalgebra::Vector2;
/// use footpoint::CurveProjector;
///
/// let arch = vec![Vector2::new(0.0, 0.0), Vector2::new(1.0, 2.0), Vector2::new(2.0, 0.0)];
/// let projector = CurveProjector::new(&BsplineCurve::bezier(arch, None)?);
/// let foot = projector.project(&Vector2::new(1.0, 1.25));
/// assert!((foot.parameter - 0.5).abs() < 1e-9 && (foot.distance - 0.25).abs() < 1e-12);
/// # Ok::<(), nurbs_core::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct CurveProjector<const D: usize> {
    set: Sets<D>,
    /// In which the set is stored.
    pub(super) frame: Frame<D>,
}

/// The prepared pieces, by the length of the rows that their degree needs.
#[derive(Clone, Debug)]
enum Sets<const D: usize> {
    /// Degree up to 3.
    One(PieceSet<D, 1>),
    /// Up to 7.
    Two(PieceSet<D, 2>),
    /// Up to 25.
    Seven(PieceSet<D, 7>),
}

/// Runs `$body` with `$set` bound to the piece set, whatever its rows.
macro_rules! with_set {
    ($sets:expr, $set:ident => $body:expr) => {
        match $sets {
            Sets::One($set) => $body,
            Sets::Two($set) => $body,
            Sets::Seven($set) => $body,
        }
    };
}

impl<const D: usize> CurveProjector<D> {
    /// Prepares one curve.
    #[must_use]
    pub fn new(curve: &BsplineCurve<D>) -> Self {
        Self::prepare(&[curve])
    }

    /// Prepares a model of several curves; the nearest of all is found.
    ///
    /// # Errors
    /// [`Error::EmptyModel`] when there are no curves.
    pub fn for_model(curves: &[BsplineCurve<D>]) -> Result<Self, Error> {
        if curves.is_empty() {
            return Err(Error::EmptyModel);
        }
        Ok(Self::prepare(&curves.iter().collect::<Vec<_>>()))
    }

    fn prepare(curves: &[&BsplineCurve<D>]) -> Self {
        let degree = curves.iter().map(|c| c.degree()).max().unwrap_or(1);
        let frame = Frame::of(curves.iter().flat_map(|s| s.control_points()));
        let framed: Result<Vec<_>, _> = curves.iter().map(|s| frame.curve(s)).collect();
        // Scaling by a power of two leaves a valid shape valid.
        let (frame, framed) = match framed {
            Ok(framed) => (frame, framed),
            Err(_) => (Frame::FILE, curves.iter().map(|&s| Cow::Borrowed(s)).collect()),
        };
        let all = framed.iter().map(AsRef::as_ref);
        let set = match degree {
            0..=3 => Sets::One(PieceSet::new(all)),
            4..=7 => Sets::Two(PieceSet::new(all)),
            _ => Sets::Seven(PieceSet::new(all)),
        };
        Self { set, frame }
    }

    /// Number of Bézier pieces of the model.
    #[must_use]
    pub fn piece_count(&self) -> usize {
        with_set!(&self.set, set => set.pieces.len())
    }

    /// Bytes held by the prepared model.
    #[must_use]
    pub fn memory(&self) -> usize {
        with_set!(&self.set, set => set.memory())
    }

    /// The nearest point of the model, certified, with the default options.
    ///
    /// A query that is not finite gets [`Status::InvalidPoint`].
    #[must_use]
    pub fn project(&self, x: &SVector<f64, D>) -> CurveFootpoint<D> {
        self.answer(x, &ProjectionOptions::default())
    }

    /// The nearest point of the model.
    ///
    /// # Errors
    /// [`Error::Option`] for an option that is invalid.
    pub fn project_with(
        &self,
        x: &SVector<f64, D>,
        options: &ProjectionOptions,
    ) -> Result<CurveFootpoint<D>, Error> {
        options.validate()?;
        Ok(self.answer(x, options))
    }

    /// The nearest point of the model, with options that are valid.
    fn answer(&self, x: &SVector<f64, D>, options: &ProjectionOptions) -> CurveFootpoint<D> {
        let y = self.frame.query(x);
        let mut foot = with_set!(&self.set, set => {
            let query = CurveQuery::new(set, options);
            set.scratch.with(|scratch| batch::single(&query, &y, scratch))
        });
        self.frame.leave(x, &mut foot);
        foot
    }

    /// Follows the distance downhill from a known parameter: a previous answer for a point nearby.
    ///
    /// Kinks are crossed where the distance falls beyond them; on a kink a foot is converged only if it falls on neither side.
    #[must_use]
    pub fn project_from(&self, x: &SVector<f64, D>, shape: usize, parameter: f64) -> CurveFootpoint<D> {
        let y = self.frame.query(x);
        let mut foot = with_set!(&self.set, set => vectorized(
            #[inline(always)]
            || follow(set, &y, shape, parameter, UpdateOptions::default().max_steps),
        ));
        self.frame.leave(x, &mut foot);
        foot
    }

    /// New feet of points, each from the previous one.
    pub(super) fn update_slice(
        &self,
        points: &[SVector<f64, D>],
        feet: &mut [CurveFootpoint<D>],
        max_steps: u32,
    ) {
        with_set!(&self.set, set => vectorized(
            #[inline(always)]
            || for (x, foot) in points.iter().zip(feet) {
                *foot = if foot.parameter.is_finite() {
                    follow(set, x, foot.shape, foot.parameter, max_steps)
                } else {
                    CurveFootpoint::invalid()
                };
            },
        ));
    }

    /// Projects many points, in parallel.
    ///
    /// The results come in the order of the points. Each is the one of [`project_with`](Self::project_with), bit by bit, whatever
    /// the other points and the number of threads. `progress` is told every few dozen points and may cancel: what is left then
    /// has [`Status::Cancelled`].
    ///
    /// # Errors
    /// [`Error::Option`] for an option that is invalid.
    pub fn project_many(
        &self,
        points: &[SVector<f64, D>],
        options: &ProjectionOptions,
        progress: Progress<'_>,
    ) -> Result<Vec<CurveFootpoint<D>>, Error> {
        options.validate()?;
        Ok(self.answers(points, options, progress))
    }

    /// The nearest points of many, certified, with the default options.
    ///
    /// As [`project_many`](Self::project_many), but nothing can be invalid and nobody wants to watch.
    #[must_use]
    pub fn project_all(&self, points: &[SVector<f64, D>]) -> Vec<CurveFootpoint<D>> {
        self.answers(points, &ProjectionOptions::default(), &super::no_progress)
    }

    /// The nearest points of many, with options that are valid.
    fn answers(
        &self,
        points: &[SVector<f64, D>],
        options: &ProjectionOptions,
        progress: Progress<'_>,
    ) -> Vec<CurveFootpoint<D>> {
        let queries = self.frame.queries(points);
        let mut feet =
            with_set!(&self.set, set => batch::run(&CurveQuery::new(set, options), &queries, progress));
        self.frame.leave_all(points, &mut feet);
        feet
    }

    /// As [`project_many`](Self::project_many) for the points `at(0)`, …, `at(count − 1)`, without holding all footpoints at
    /// once; see [`SurfaceProjector::project_each`](crate::SurfaceProjector::project_each).
    ///
    /// # Errors
    /// [`Error::Option`] for an option that is invalid.
    pub fn project_each<T: Send>(
        &self,
        count: usize,
        at: &(dyn Fn(usize) -> SVector<f64, D> + Sync),
        options: &ProjectionOptions,
        progress: Progress<'_>,
        treat: &(dyn Fn(usize, &CurveFootpoint<D>) -> T + Sync),
        receive: Receive<'_, T>,
    ) -> Result<(), Error> {
        options.validate()?;
        let queries = Queries { count, at: &|index| self.frame.query(&at(index)) };
        let treat = |index: usize, foot: &CurveFootpoint<D>| {
            let mut foot = *foot;
            self.frame.leave(&at(index), &mut foot);
            treat(index, &foot)
        };
        with_set!(&self.set, set => {
            batch::each(&CurveQuery::new(set, options), &queries, progress, &treat, receive);
        });
        Ok(())
    }

    /// All local minima of the distance that are at most `factor` (at least 1) times as far as the nearest point.
    ///
    /// A foot is a point without nearer ones around it on its curve: inside, on the boundary, on an inner
    /// kink. Saddles and maxima of the distance are left out. With the factor 1 the feet are the exact ties, up to
    /// [`tie_tolerance`](ProjectionOptions::tie_tolerance). The search is certified whatever the mode in the options,
    /// and examines [`max_boxes`](ProjectionOptions::max_boxes) boxes at most, plus 64 for each piece within reach.
    ///
    /// # Errors
    /// [`Error::NonFinitePoint`]; [`Error::Option`] when `factor` is not finite or below 1, or an option is invalid.
    pub fn feet_within(
        &self,
        x: &SVector<f64, D>,
        factor: f64,
        options: &ProjectionOptions,
    ) -> Result<CurveFeet<D>, Error> {
        let y = self.frame.query(x);
        let mut found = with_set!(&self.set, set => all_feet::curve_feet(set, &y, factor, options))?;
        found.feet.iter_mut().for_each(|foot| self.frame.leave(x, foot));
        Ok(found)
    }

    /// The parameter of a point that lies on the model.
    ///
    /// # Errors
    /// [`Error::NonFinitePoint`], and [`Error::NotOnShape`] when the model is further away than `tolerance` (a
    /// length).
    pub fn invert(&self, x: &SVector<f64, D>, tolerance: f64) -> Result<CurveFootpoint<D>, Error> {
        let foot = self.project(x);
        if foot.status == Status::InvalidPoint {
            return Err(Error::NonFinitePoint { index: 0 });
        }
        if foot.distance > tolerance {
            return Err(Error::NotOnShape { distance: foot.distance, tolerance });
        }
        Ok(foot)
    }
}

/// The foot that a known parameter leads to.
#[inline(always)]
fn follow<const D: usize, const K: usize>(
    set: &PieceSet<D, K>,
    x: &SVector<f64, D>,
    shape: usize,
    parameter: f64,
    max_steps: u32,
) -> CurveFootpoint<D> {
    match set.locate(shape, parameter) {
        Some(place) if x.iter().all(|c| c.is_finite()) => {
            set.conclude_walk(x, &set.follow(x, place, max_steps))
        }
        _ => CurveFootpoint::invalid(),
    }
}

/// One way to answer queries about one set of pieces.
struct CurveQuery<'a, const D: usize, const K: usize> {
    set: &'a PieceSet<D, K>,
    mode: Mode,
    gap: Gap,
}

impl<'a, const D: usize, const K: usize> CurveQuery<'a, D, K> {
    fn new(set: &'a PieceSet<D, K>, options: &ProjectionOptions) -> Self {
        Self { set, mode: options.mode, gap: Gap::new(options, set.size) }
    }
}

impl<const D: usize, const K: usize> Batch<D> for CurveQuery<'_, D, K> {
    type Scratch = CurveScratch<K>;
    type Output = CurveFootpoint<D>;

    fn invalid(&self) -> CurveFootpoint<D> {
        CurveFootpoint::invalid()
    }

    fn cancelled(&self) -> CurveFootpoint<D> {
        CurveFootpoint { status: Status::Cancelled, ..CurveFootpoint::invalid() }
    }

    #[inline(always)]
    fn answer(&self, x: &SVector<f64, D>, scratch: &mut CurveScratch<K>) -> CurveFootpoint<D> {
        if self.mode == Mode::Local {
            // From a place of its own: what is found does not depend on the points before.
            let start = self.set.nearest_sample(x, scratch);
            return start.map_or_else(CurveFootpoint::diverged, |start| {
                self.set.conclude_walk(x, &self.set.follow(x, start, UpdateOptions::default().max_steps))
            });
        }
        let certify = self.mode == Mode::Certified;
        let (foot, bound_sq) = self.set.search(x, certify, &self.gap, scratch);
        if foot.piece == usize::MAX {
            return CurveFootpoint::diverged();
        }
        let mut out = self.set.finish(x, &foot);
        if certify {
            out.lower_bound = bound_sq.sqrt().min(out.distance);
            out.multiplicity = self.set.multiplicity(x, &foot, &out, &self.gap, scratch);
            if out.multiplicity == Multiplicity::Continuum && !out.status.is_converged() {
                // Along a continuum no point is better than another: there is nothing to converge to.
                out.status = Status::Converged;
            }
            // Squares of lengths are not known better than this: close to a curve it limits what can be proven.
            let piece = &self.set.pieces[foot.piece];
            let size_sq = self.set.size * self.set.size + foot.distance_sq;
            let rounding_sq = ROUNDING * size_sq * piece.max_weight_sq / piece.min_weight_sq;
            let bound = (bound_sq + rounding_sq).sqrt();
            if out.status.is_converged() && !self.gap.is_closed(out.distance, bound) {
                out.status = Status::Uncertified;
            }
        }
        out
    }
}

impl<const D: usize> CurveFootpoint<D> {
    /// The answer where numbers overflow.
    fn diverged() -> Self {
        Self { status: Status::Diverged, ..Self::invalid() }
    }

    /// The answer for a point that is not finite.
    fn invalid() -> Self {
        Self {
            shape: 0,
            parameter: f64::NAN,
            point: SVector::repeat(f64::NAN),
            distance: f64::NAN,
            status: Status::InvalidPoint,
            location: Location::Interior,
            multiplicity: Multiplicity::Unknown,
            lower_bound: 0.0,
            iterations: 0,
        }
    }
}
