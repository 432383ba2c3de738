//! New feet of points that have moved a little: many warm starts at once.

use super::batch;
use super::curve::CurveProjector;
use super::surface::{Sets, SurfaceProjector, with_set};
use crate::global::arithmetic::simd::{Simd, Task, dispatch};
use crate::global::surface::geometry::Geometry;
use crate::global::surface::newton_lanes::{Outcome, Walker};
use crate::{CurveFootpoint, Error, SurfaceFootpoint, UpdateOptions};
use nalgebra::{SVector, Vector3};

/// Walkers on one patch that are not worth the vectors.
const FEW: usize = 2;
/// Passes over the patches, each for those that have crossed a border in the one before.
const PASSES: usize = 6;
/// Points for which sorting does not pay.
const SMALL: usize = 8;

impl SurfaceProjector {
    /// Local feet of many points, each from the parameter of a previous answer, as between the iterations of a
    /// registration or a fit.
    ///
    /// Every answer is that of [`project_from`](Self::project_from), bit by bit, whatever the number of
    /// threads, but several times faster: points on the same patch are iterated side by side. Nothing is certified: a
    /// point that has moved far may end in a local minimum of the distance. A point, or a previous parameter, that is not
    /// finite, and a shape that does not exist, give [`Status::InvalidPoint`](crate::Status::InvalidPoint).
    ///
    /// # Errors
    /// [`Error::StartCount`] unless there is one previous answer per point.
    ///
    /// ```
    /// # use nurbs_core::{Frame, Torus};
    /// # use nalgebra::Vector3;
    /// use footpoint::{ProjectionOptions, SurfaceProjector, no_progress};
    ///
    /// let torus = Torus::new(Frame::WORLD, 3.0, 1.0)?.to_nurbs()?;
    /// let projector = SurfaceProjector::new(&torus);
    /// let mut scan: Vec<_> = (0..100).map(|i| Vector3::new(3.0, f64::from(i) * 0.01, 1.5)).collect();
    /// let feet = projector.project_many(&scan, &ProjectionOptions::default(), &no_progress)?;
    ///
    /// scan.iter_mut().for_each(|x| *x += Vector3::new(0.01, 0.0, -0.02));
    /// let updated = projector.update_many(&scan, &feet)?;
    /// assert!(updated.iter().all(|foot| foot.status.is_converged()));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn update_many(
        &self,
        points: &[Vector3<f64>],
        previous: &[SurfaceFootpoint],
    ) -> Result<Vec<SurfaceFootpoint>, Error> {
        let mut feet = previous.to_vec();
        self.update_in_place(points, &mut feet, &UpdateOptions::default())?;
        Ok(feet)
    }

    /// As [`update_many`](Self::update_many), replacing the previous answers, without a new vector of results.
    ///
    /// With `UpdateOptions::default().with_max_steps(1)` every foot takes one step of the local iteration, which is enough
    /// between two steps of a registration or a fit (\[HW05\], section 5): both converge together.
    ///
    /// # Errors
    /// [`Error::StartCount`] unless there is one previous answer per point; [`Error::Option`] for an invalid option.
    pub fn update_in_place(
        &self,
        points: &[Vector3<f64>],
        feet: &mut [SurfaceFootpoint],
        options: &UpdateOptions,
    ) -> Result<(), Error> {
        check(points.len(), feet.len(), options)?;
        let queries = self.frame.queries(points);
        with_set!(&self.set, set => {
            batch::zip_chunks(&queries, feet, chunk_length(set.patches.len()), |points, feet, work| {
                dispatch(Update { set, points, feet, max_steps: options.max_steps, work });
            });
        });
        self.frame.leave_all(points, feet);
        Ok(())
    }
}

impl<const D: usize> CurveProjector<D> {
    /// Local feet of many points, each from the parameter of a previous answer, as between the iterations of a
    /// registration or a fit.
    ///
    /// Every answer is that of [`project_from`](Self::project_from), bit by bit, whatever the number of
    /// threads. Nothing is certified. A point, or a previous parameter, that is not finite, and a shape that does not
    /// exist, give [`Status::InvalidPoint`](crate::Status::InvalidPoint).
    ///
    /// # Errors
    /// [`Error::StartCount`] unless there is one previous answer per point.
    ///
    /// ```
    /// # use nurbs_core::BsplineCurve;
    /// # use nalgebra::Vector2;
    /// use footpoint::CurveProjector;
    ///
    /// let arch = vec![Vector2::new(0.0, 0.0), Vector2::new(1.0, 2.0), Vector2::new(2.0, 0.0)];
    /// let projector = CurveProjector::new(&BsplineCurve::bezier(arch, None)?);
    /// let feet = vec![projector.project(&Vector2::new(1.0, 1.25))];
    ///
    /// let updated = projector.update_many(&[Vector2::new(1.01, 1.3)], &feet)?;
    /// assert!(updated[0].status.is_converged() && updated[0].parameter > 0.5);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn update_many(
        &self,
        points: &[SVector<f64, D>],
        previous: &[CurveFootpoint<D>],
    ) -> Result<Vec<CurveFootpoint<D>>, Error> {
        let mut feet = previous.to_vec();
        self.update_in_place(points, &mut feet, &UpdateOptions::default())?;
        Ok(feet)
    }

    /// As [`update_many`](Self::update_many), replacing the previous answers, with a limit on the steps.
    ///
    /// # Errors
    /// [`Error::StartCount`] unless there is one previous answer per point; [`Error::Option`] for an invalid option.
    pub fn update_in_place(
        &self,
        points: &[SVector<f64, D>],
        feet: &mut [CurveFootpoint<D>],
        options: &UpdateOptions,
    ) -> Result<(), Error> {
        check(points.len(), feet.len(), options)?;
        let queries = self.frame.queries(points);
        batch::zip_chunks(&queries, feet, chunk_length(0), |points, feet, (): &mut ()| {
            self.update_slice(points, feet, options.max_steps);
        });
        self.frame.leave_all(points, feet);
        Ok(())
    }
}

fn check(points: usize, feet: usize, options: &UpdateOptions) -> Result<(), Error> {
    if points != feet {
        return Err(Error::StartCount { found: feet, needed: points });
    }
    options.validate()
}

/// Points treated together: several for each patch, but few enough that they stay in the caches.
fn chunk_length(patches: usize) -> usize {
    (16 * patches).clamp(1 << 12, 1 << 15)
}

/// Buffers of one chunk.
#[derive(Debug, Default)]
struct Work {
    walkers: Vec<Walker>,
    sorted: Vec<Walker>,
    /// For the counting sort: the next free place of each patch.
    places: Vec<u32>,
}

impl Work {
    /// The walkers in the order of their patches, on a patch in the order in which they came.
    fn sort(&mut self, patches: usize) {
        if patches > 4 * self.walkers.len() {
            self.sorted.clone_from(&self.walkers);
            self.sorted.sort_by_key(|walker| walker.patch);
            return;
        }
        self.sorted.resize(self.walkers.len(), Walker::default());
        self.places.clear();
        self.places.resize(patches, 0);
        for walker in &self.walkers {
            self.places[walker.patch as usize] += 1;
        }
        let mut place = 0;
        for slot in &mut self.places {
            place += std::mem::replace(slot, place);
        }
        for walker in &self.walkers {
            let slot = &mut self.places[walker.patch as usize];
            self.sorted[*slot as usize] = *walker;
            *slot += 1;
        }
    }
}

/// New feet of the points of one chunk.
struct Update<'a> {
    set: &'a Geometry,
    points: &'a [Vector3<f64>],
    feet: &'a mut [SurfaceFootpoint],
    max_steps: u32,
    work: &'a mut Work,
}

impl Task for Update<'_> {
    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let Self { set, points, feet, max_steps, work } = self;
        work.walkers.clear();
        for (index, (x, foot)) in (0..).zip(points.iter().zip(&mut *feet)) {
            match start(set, x, foot) {
                Some((patch, local)) => {
                    let patch = u32::try_from(patch).unwrap_or(u32::MAX);
                    let before_sq = f64::INFINITY;
                    work.walkers.push(Walker { local, before_sq, patch, index, steps: 0 });
                }
                None => *foot = SurfaceFootpoint::invalid(),
            }
        }
        for pass in 0.. {
            let alone = pass >= PASSES || work.walkers.len() <= SMALL;
            work.sort(set.patches.len());
            work.walkers.clear();
            for group in work.sorted.chunk_by(|a, b| a.patch == b.patch) {
                if alone || group.len() <= FEW || set.patches[group[0].patch as usize].order() == 0 {
                    for walker in group {
                        let (x, foot) = of(points, feet, walker);
                        *foot = walk_alone(set, x, walker, foot, max_steps);
                    }
                    continue;
                }
                set.newton_lanes(
                    simd,
                    points,
                    group,
                    max_steps,
                    #[inline(always)]
                    |walker, outcome| match outcome {
                        Outcome::Found(foot) => feet[walker.index as usize] = foot,
                        Outcome::Landed(place, jet) => {
                            let (x, foot) = of(points, feet, walker);
                            *foot = set.conclude_walk(x, &set.go_on(x, place, jet, max_steps));
                        }
                        Outcome::Crossed(walker) => work.walkers.push(walker),
                        Outcome::Lost => {
                            let (x, foot) = of(points, feet, walker);
                            *foot = walk_again(set, x, foot, max_steps);
                        }
                    },
                );
            }
            if work.walkers.is_empty() {
                return;
            }
        }
    }
}

/// The place that a previous answer tells, if it does.
#[inline(always)]
fn start(set: &Geometry, x: &Vector3<f64>, foot: &SurfaceFootpoint) -> Option<(usize, [f64; 2])> {
    let [u, v] = foot.parameter;
    let finite = x.x.is_finite() & x.y.is_finite() & x.z.is_finite() & u.is_finite() & v.is_finite();
    if !finite {
        return None;
    }
    let cells = set.cells.get(foot.shape)?;
    let (cell, local) = cells.locate(foot.parameter);
    Some(set.best_side(x, (cells.patch(cell), local)))
}

/// The point of a walker and its answer.
#[inline(always)]
fn of<'a>(
    points: &'a [Vector3<f64>],
    feet: &'a mut [SurfaceFootpoint],
    walker: &Walker,
) -> (&'a Vector3<f64>, &'a mut SurfaceFootpoint) {
    (&points[walker.index as usize], &mut feet[walker.index as usize])
}

/// The rest of a walk.
fn walk_alone(
    set: &Geometry,
    x: &Vector3<f64>,
    walker: &Walker,
    previous: &SurfaceFootpoint,
    max_steps: u32,
) -> SurfaceFootpoint {
    let patch = walker.patch as usize;
    if !set.falls(x, patch, walker.local, walker.before_sq) {
        return walk_again(set, x, previous, max_steps);
    }
    let (mut foot, jet) = set.descend_to_jet(x, patch, walker.local, max_steps - walker.steps);
    foot.steps += walker.steps;
    set.conclude_walk(x, &set.go_on(x, foot, jet, max_steps))
}

/// The whole walk from the previous answer, with step control.
#[cold]
fn walk_again(
    set: &Geometry,
    x: &Vector3<f64>,
    previous: &SurfaceFootpoint,
    max_steps: u32,
) -> SurfaceFootpoint {
    let Some((patch, local)) = start(set, x, previous) else { return SurfaceFootpoint::invalid() };
    let (foot, jet) = set.descend_to_jet(x, patch, local, max_steps);
    set.conclude_walk(x, &set.go_on(x, foot, jet, max_steps))
}
