//! Projection onto one or several B-spline surfaces.

use super::Progress;
use super::all_feet::{self, SurfaceFeet};
use super::batch::{self, Batch, Queries, Receive};
use super::facing;
use super::frame::Frame;
use crate::global::gap::Gap;
use crate::global::surface::patch::PatchSet;
use crate::global::surface::scratch::Scratch;
use crate::{Error, Facing, Mode, Multiplicity, ProjectionOptions, Status, SurfaceFootpoint, UpdateOptions};
use nalgebra::Vector3;
use nurbs_core::BsplineSurface;
use std::borrow::Cow;

/// Projects points onto one or several B-spline or NURBS surfaces.
///
/// Built once per model; then every query finds the nearest point of all surfaces and proves that none is nearer:
///
/// ```
/// # use nurbs_core::{BsplineSurface, KnotVector, Interval};
/// # use nalgebra::Vector3;
/// use footpoint::{Location, SurfaceProjector};
///
/// let line = KnotVector::bezier(1, Interval::UNIT)?;
/// let corners = [[0., 0., 0.], [0., 1., 0.], [2., 0., 0.], [2., 1., 0.]].map(Vector3::from).to_vec();
/// let rectangle = BsplineSurface::new(line.clone(), line, corners, None)?;
///
/// let foot = SurfaceProjector::new(&rectangle).project(&Vector3::new(0.5, 0.25, -3.0));
/// assert_eq!((foot.distance, foot.signed_distance), (3.0, -3.0));
/// assert_eq!(foot.location, Location::Interior);
/// assert!(foot.gap() < 1e-6);
/// # Ok::<(), nurbs_core::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct SurfaceProjector {
    pub(super) set: Sets,
    /// In which the set is stored.
    pub(super) frame: Frame<3>,
}

/// The prepared patches, by the length of the rows that their degree needs.
#[derive(Clone, Debug)]
pub(crate) enum Sets {
    /// Degrees up to 3.
    One(PatchSet<1>),
    /// Up to 7.
    Two(PatchSet<2>),
    /// Up to 15.
    Four(PatchSet<4>),
    /// Up to 25.
    Seven(PatchSet<7>),
}

/// Runs `$body` with `$set` bound to the patch set, whatever its rows.
macro_rules! with_set {
    ($sets:expr, $set:ident => $body:expr) => {
        match $sets {
            Sets::One($set) => $body,
            Sets::Two($set) => $body,
            Sets::Four($set) => $body,
            Sets::Seven($set) => $body,
        }
    };
}

pub(super) use with_set;

impl SurfaceProjector {
    /// Prepares one surface.
    #[must_use]
    pub fn new(surface: &BsplineSurface) -> Self {
        let projector = Self::on_demand(surface);
        projector.complete();
        projector
    }

    /// As [`SurfaceProjector::new`], but what the proofs on patches of high degree or with unequal weights need is prepared when a query
    /// first needs it: for models of many surfaces of which few queries come near each.
    #[must_use]
    pub fn on_demand(surface: &BsplineSurface) -> Self {
        Self::prepare(&[surface])
    }

    /// Prepares what queries would have to wait for.
    fn complete(&self) {
        with_set!(&self.set, set => {
            set.tiles();
        });
    }

    /// Prepares a model of several surfaces; the nearest of all is found.
    ///
    /// # Errors
    /// [`Error::EmptyModel`] when there are no surfaces.
    pub fn for_model(surfaces: &[BsplineSurface]) -> Result<Self, Error> {
        if surfaces.is_empty() {
            return Err(Error::EmptyModel);
        }
        let projector = Self::prepare(&surfaces.iter().collect::<Vec<_>>());
        projector.complete();
        Ok(projector)
    }

    fn prepare(surfaces: &[&BsplineSurface]) -> Self {
        let degree = surfaces.iter().map(|s| s.degree_u().max(s.degree_v())).max().unwrap_or(1);
        let frame = Frame::of(surfaces.iter().flat_map(|s| s.control_points()));
        let framed: Result<Vec<_>, _> = surfaces.iter().map(|s| frame.surface(s)).collect();
        // Scaling by a power of two leaves a valid shape valid.
        let (frame, framed) = match framed {
            Ok(framed) => (frame, framed),
            Err(_) => (Frame::FILE, surfaces.iter().map(|&s| Cow::Borrowed(s)).collect()),
        };
        let all = framed.iter().map(AsRef::as_ref);
        let set = match degree {
            0..=3 => Sets::One(PatchSet::new(all)),
            4..=7 => Sets::Two(PatchSet::new(all)),
            8..=15 => Sets::Four(PatchSet::new(all)),
            _ => Sets::Seven(PatchSet::new(all)),
        };
        Self { set, frame }
    }

    /// Number of Bézier patches of the model.
    #[must_use]
    pub fn patch_count(&self) -> usize {
        with_set!(&self.set, set => set.patches.len())
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
    pub fn project(&self, x: &Vector3<f64>) -> SurfaceFootpoint {
        self.answer(x, &ProjectionOptions::default())
    }

    /// The nearest point of the model.
    ///
    /// # Errors
    /// [`Error::Option`] for an option that is invalid.
    pub fn project_with(
        &self,
        x: &Vector3<f64>,
        options: &ProjectionOptions,
    ) -> Result<SurfaceFootpoint, Error> {
        options.validate()?;
        Ok(self.answer(x, options))
    }

    /// The nearest point of the model, with options that are valid.
    fn answer(&self, x: &Vector3<f64>, options: &ProjectionOptions) -> SurfaceFootpoint {
        let y = self.frame.query(x);
        let mut foot = with_set!(&self.set, set => {
            let query = SurfaceQuery::new(set, options);
            query.set.scratch.with(|scratch| batch::single(&query, &y, scratch))
        });
        self.frame.leave(x, &mut foot);
        foot
    }

    /// Follows the distance downhill from a known parameter: a previous answer for a point nearby.
    ///
    /// Finds the local minimum that the start leads to, at a fraction of the cost of a search. Kinks, seams and poles are
    /// crossed where the distance falls beyond them; on a kink a foot is converged only if it falls on no side.
    #[must_use]
    pub fn project_from(&self, x: &Vector3<f64>, shape: usize, parameter: [f64; 2]) -> SurfaceFootpoint {
        let y = self.frame.query(x);
        let mut foot = with_set!(&self.set, set => {
            if !y.iter().all(|c| c.is_finite()) || shape >= set.cells.len() {
                return SurfaceFootpoint::invalid();
            }
            let (cell, local) = set.cells[shape].locate(parameter);
            let patch = set.cells[shape].patch(cell);
            set.conclude_walk(&y, &set.follow(&y, (patch, local), UpdateOptions::default().max_steps))
        });
        self.frame.leave(x, &mut foot);
        foot
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
        points: &[Vector3<f64>],
        options: &ProjectionOptions,
        progress: Progress<'_>,
    ) -> Result<Vec<SurfaceFootpoint>, Error> {
        options.validate()?;
        Ok(self.answers(points, options, progress))
    }

    /// The nearest points of many, certified, with the default options.
    ///
    /// As [`project_many`](Self::project_many), but nothing can be invalid and nobody wants to watch.
    #[must_use]
    pub fn project_all(&self, points: &[Vector3<f64>]) -> Vec<SurfaceFootpoint> {
        self.answers(points, &ProjectionOptions::default(), &super::no_progress)
    }

    /// The nearest points of many, with options that are valid.
    fn answers(
        &self,
        points: &[Vector3<f64>],
        options: &ProjectionOptions,
        progress: Progress<'_>,
    ) -> Vec<SurfaceFootpoint> {
        let queries = self.frame.queries(points);
        let mut feet =
            with_set!(&self.set, set => batch::run(&SurfaceQuery::new(set, options), &queries, progress));
        self.frame.leave_all(points, &mut feet);
        feet
    }

    /// As [`project_many`](Self::project_many) for the points `at(0)`, …, `at(count − 1)`, without holding all footpoints at
    /// once: each is turned into what `treat` makes of it, in parallel, and `receive` gets these with the indices of their
    /// points, some tens of thousands at a time. They come in an order that follows the positions of the points.
    ///
    /// # Errors
    /// [`Error::Option`] for an option that is invalid.
    pub fn project_each<T: Send>(
        &self,
        count: usize,
        at: &(dyn Fn(usize) -> Vector3<f64> + Sync),
        options: &ProjectionOptions,
        progress: Progress<'_>,
        treat: &(dyn Fn(usize, &SurfaceFootpoint) -> T + Sync),
        receive: Receive<'_, T>,
    ) -> Result<(), Error> {
        options.validate()?;
        let queries = Queries { count, at: &|index| self.frame.query(&at(index)) };
        let treat = |index: usize, foot: &SurfaceFootpoint| {
            let mut foot = *foot;
            self.frame.leave(&at(index), &mut foot);
            treat(index, &foot)
        };
        with_set!(&self.set, set => {
            batch::each(&SurfaceQuery::new(set, options), &queries, progress, &treat, receive);
        });
        Ok(())
    }

    /// The nearest of the feet whose normals agree, when `nearest` is the answer for `x` among all.
    ///
    /// A foot is a point without nearer ones around it on its surface, as in [`feet_within`](Self::feet_within); on a kink, at a
    /// seam or a pole it counts if the normal on any side of it agrees. The lower bound is one for the feet that count: no
    /// other one is nearer. Without any the status is [`Status::NoMatchingFoot`]. Boxes are examined up to the limits of
    /// [`feet_within`](Self::feet_within), for each of a few ranges of the distance; where these do not suffice for a proof, the
    /// lower bound is that of `nearest`.
    ///
    /// ```
    /// use footpoint::{Facing, ProjectionOptions, SurfaceProjector};
    /// use nalgebra::Vector3;
    /// use nurbs_core::{Frame, Sphere};
    ///
    /// let sphere = Sphere::new(Frame::new(Vector3::zeros(), Vector3::z(), Vector3::x())?, 2.0)?.to_nurbs()?;
    /// let projector = SurfaceProjector::new(&sphere);
    /// let x = Vector3::new(0.0, 0.0, 1.0);
    /// let (nearest, down) = (projector.project(&x), Facing::new(&-Vector3::z(), 0.1)?);
    /// // Inside, the foot on the far side is the farthest point, not a foot: nothing there is a local minimum.
    /// let foot = projector.facing_foot(&x, &nearest, &down, &ProjectionOptions::default());
    /// assert_eq!(foot.status, footpoint::Status::NoMatchingFoot);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[must_use]
    pub fn facing_foot(
        &self,
        x: &Vector3<f64>,
        nearest: &SurfaceFootpoint,
        facing: &Facing,
        options: &ProjectionOptions,
    ) -> SurfaceFootpoint {
        let y = self.frame.query(x);
        let mut foot = with_set!(&self.set, set => {
            let nearest = if self.frame.keeps(x) {
                *nearest
            } else {
                let query = SurfaceQuery::new(set, options);
                query.set.scratch.with(|scratch| batch::single(&query, &y, scratch))
            };
            facing::restricted(set, &y, &nearest, facing, options)
        });
        self.frame.leave(x, &mut foot);
        foot
    }

    /// All local minima of the distance that are at most `factor` (at least 1) times as far as the nearest point.
    ///
    /// A foot is a point without nearer ones around it on its surface: inside, on the boundary, on an inner
    /// kink, at a pole. Saddles and maxima of the distance are left out. With the factor 1 the feet are the exact ties, up to
    /// [`tie_tolerance`](ProjectionOptions::tie_tolerance). The search is certified whatever the mode in the options,
    /// and examines [`max_boxes`](ProjectionOptions::max_boxes) boxes at most, plus 64 for each piece within reach.
    ///
    /// # Errors
    /// [`Error::NonFinitePoint`]; [`Error::Option`] when `factor` is not finite or below 1, or an option is invalid.
    pub fn feet_within(
        &self,
        x: &Vector3<f64>,
        factor: f64,
        options: &ProjectionOptions,
    ) -> Result<SurfaceFeet, Error> {
        let y = self.frame.query(x);
        let mut found = with_set!(&self.set, set => all_feet::surface_feet(set, &y, factor, options))?;
        found.feet.iter_mut().for_each(|foot| self.frame.leave(x, foot));
        Ok(found)
    }

    /// The parameters of a point that lies on the model.
    ///
    /// # Errors
    /// [`Error::NonFinitePoint`], and [`Error::NotOnShape`] when the model is further away than `tolerance` (a
    /// length).
    pub fn invert(&self, x: &Vector3<f64>, tolerance: f64) -> Result<SurfaceFootpoint, Error> {
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

/// One way to answer queries about one patch set.
struct SurfaceQuery<'a, const K: usize> {
    set: &'a PatchSet<K>,
    mode: Mode,
    gap: Gap,
}

impl<'a, const K: usize> SurfaceQuery<'a, K> {
    fn new(set: &'a PatchSet<K>, options: &ProjectionOptions) -> Self {
        Self { set, mode: options.mode, gap: Gap::new(options, set.size) }
    }
}

impl<const K: usize> Batch<3> for SurfaceQuery<'_, K> {
    type Scratch = Scratch<K>;
    type Output = SurfaceFootpoint;

    fn invalid(&self) -> SurfaceFootpoint {
        SurfaceFootpoint::invalid()
    }

    fn cancelled(&self) -> SurfaceFootpoint {
        SurfaceFootpoint { status: Status::Cancelled, ..SurfaceFootpoint::invalid() }
    }

    #[inline(always)]
    fn answer(&self, x: &Vector3<f64>, scratch: &mut Scratch<K>) -> SurfaceFootpoint {
        if self.mode == Mode::Local {
            // From a place of its own: what is found does not depend on the points before.
            let start = self.set.nearest_sample(x, scratch);
            return start.map_or_else(SurfaceFootpoint::diverged, |start| {
                self.set.conclude_walk(x, &self.set.follow(x, start, UpdateOptions::default().max_steps))
            });
        }
        let certify = self.mode == Mode::Certified;
        let mut found = self.set.search(x, certify, &self.gap, scratch);
        if certify {
            self.set.improve_open(x, &mut found, &self.gap, scratch);
        }
        if found.foot.patch == usize::MAX {
            return SurfaceFootpoint::diverged();
        }
        let mut out = self.set.finish(x, &found.foot);
        if certify {
            out.lower_bound = found.bound_sq.sqrt().min(out.distance);
            out.multiplicity = self.set.multiplicity(x, &found.foot, &out, &self.gap, scratch);
            if out.multiplicity == Multiplicity::Continuum && !out.status.is_converged() {
                // Along a continuum no point is better than another: there is nothing to converge to.
                out.status = Status::Converged;
            }
            if out.status.is_converged() && !self.gap.is_closed(out.distance, out.lower_bound) {
                out.status = Status::Uncertified;
            }
        }
        out
    }
}
