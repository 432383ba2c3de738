//! The distance from a model in the plane or in space, with poses of space for both.

use industrial_geometry::distance_field::{DistanceField, Hint, PrincipalFrame, Search};
use industrial_geometry::mesh::nalgebra::{Matrix3, SVector, Vector3};
use industrial_geometry::nurbs::Aabb;
use industrial_geometry::register::start::OrientedPoints;
use industrial_geometry::register::{
    Comparison, Covariance, Error, FreeMotion, Locks, Pose, RegisterOptions, RegisterReport, RegisterStep,
    Source, is_symmetry, register_rest, register_some, register_with_progress, rival_poses, surface_left_out,
    symmetries_and_near,
};
use std::ops::ControlFlow;

/// Distance, as a share of the size of the model, within which a point counts as lying on it when poses are compared.
const NEAR: f64 = 0.012;
/// The same within which it may belong there.
const EXACT: f64 = 0.004;
/// Points, at least, that tell of a position whether it is hopeless.
const FEW: usize = 800;
/// Points by which poses are compared.
const COMPARED: usize = 4000;

/// How well a pose fits.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Fit {
    /// Mean squared distance with a limit, as a share of the limit squared.
    pub(crate) score: f64,
    /// Share of the points within the limit.
    pub(crate) near: f64,
    /// Share of the points that lie on the model beyond what chance explains: points that merely are near have distances spread
    /// evenly, and add nothing to it. Between clouds an estimate of the overlap.
    pub(crate) overlap: f64,
}

impl Fit {
    /// Root mean square distance with a limit, as a share of the size of the model.
    pub(crate) fn typical_distance(&self) -> f64 {
        NEAR * self.score.sqrt()
    }
}

/// The distance from a model.
pub(crate) enum RegistrationField {
    /// In the plane z = 0.
    Plane(Box<dyn DistanceField<2>>),
    /// In space.
    Space(Box<dyn DistanceField<3>>),
}

impl RegistrationField {
    /// Diagonal of the box around the model.
    pub(crate) fn diagonal(&self) -> f64 {
        match self {
            Self::Plane(field) => field.bounding_box().diagonal(),
            Self::Space(field) => field.bounding_box().diagonal(),
        }
    }

    /// The corners of the box around the model.
    pub(crate) fn corners(&self) -> Vec<Vector3<f64>> {
        let [low, high] = match self {
            Self::Plane(field) => [field.bounding_box().min, field.bounding_box().max].map(|x| lifted(&x)),
            Self::Space(field) => [field.bounding_box().min, field.bounding_box().max],
        };
        let corner = |k: usize| Vector3::from_fn(|i, _| if k >> i & 1 == 0 { low[i] } else { high[i] });
        (0..8).map(corner).collect()
    }

    /// Centre of the box around the model.
    pub(crate) fn centre(&self) -> Vector3<f64> {
        match self {
            Self::Plane(field) => lifted(&field.bounding_box().centre()),
            Self::Space(field) => field.bounding_box().centre(),
        }
    }

    /// The size of the model over that of the points; 1 where one of them has none.
    pub(crate) fn relative_size(&self, points: &[Vector3<f64>]) -> f64 {
        let finite = points.iter().filter(|x| x.iter().all(|c| c.is_finite()));
        let size = Aabb::of_points(finite).map_or(0.0, |bounds| bounds.diagonal());
        let ratio = self.diagonal() / size;
        if ratio.is_finite() && ratio > 0.0 { ratio } else { 1.0 }
    }

    /// How well a pose fits.
    ///
    /// Where the scale is unknown the limit goes by the size of the moved points: in the size of the model, all points of a cloud
    /// that is small enough are near.
    pub(crate) fn compare(&self, points: &[Vector3<f64>], pose: &Pose<3>, scale: bool) -> Fit {
        let moved = some_moved(points, pose);
        let bounds = Aabb::of_points(&moved).filter(|_| scale);
        let size = bounds.map_or(self.diagonal(), |bounds| bounds.diagonal());
        let distances = self.distances(&moved);
        let (mut sum, mut near, mut overlap) = (0.0, 0usize, 0.0);
        for distance in &distances {
            let share = (distance / (NEAR * size)).powi(2);
            sum += if share < 1.0 { share } else { 1.0 };
            near += usize::from(share < 1.0);
            let exact = (distance / (EXACT * size)).powi(2);
            overlap += if exact < 1.0 { 1.0 - 3.0 * exact } else { 0.0 };
        }
        let count = distances.len().max(1) as f64;
        Fit { score: sum / count, near: near as f64 / count, overlap: (overlap / count).clamp(0.0, 1.0) }
    }

    /// Which of the points by which poses are compared are near the model.
    pub(crate) fn near(&self, points: &[Vector3<f64>], pose: &Pose<3>) -> Vec<bool> {
        let limit = NEAR * self.diagonal();
        self.distances(&some_moved(points, pose)).iter().map(|distance| *distance < limit).collect()
    }

    /// The motions that carry a model in space into itself but for a tolerance, the identity first, and those that nearly do.
    pub(crate) fn symmetries(
        &self,
        samples: &OrientedPoints,
        abs_tolerance: f64,
    ) -> (Vec<Pose<3>>, Vec<Pose<3>>) {
        match self {
            Self::Plane(_) => (vec![Pose::identity()], Vec::new()),
            Self::Space(field) => symmetries_and_near(field.as_ref(), samples, abs_tolerance),
        }
    }

    /// Poses to which turns of a model in space about its own axes lead, if these lay most of it on itself.
    pub(crate) fn rivals(
        &self,
        samples: &OrientedPoints,
        points: &[Vector3<f64>],
        pose: &Pose<3>,
    ) -> Vec<Pose<3>> {
        match self {
            Self::Plane(_) => Vec::new(),
            Self::Space(field) => rival_poses(field.as_ref(), samples, points, pose),
        }
    }

    /// Whether a motion carries a model in space into itself but for a tolerance.
    pub(crate) fn is_symmetry(&self, samples: &OrientedPoints, motion: &Pose<3>, abs_tolerance: f64) -> bool {
        match self {
            Self::Plane(_) => false,
            Self::Space(field) => is_symmetry(field.as_ref(), samples, motion, abs_tolerance),
        }
    }

    /// Which of two poses the points fit better, point by point.
    pub(crate) fn comparison(&self, points: &[Vector3<f64>], poses: [&Pose<3>; 2]) -> Comparison {
        let [first, second] = poses.map(|pose| self.distances(&some_moved(points, pose)));
        Comparison::of(&first, &second, self.diagonal())
    }

    /// Share of the points that lie off the model in a pose, farther than a limit or beyond its boundary, and show a surface there:
    /// scattered outliers do not. `None` in the plane.
    pub(crate) fn surface_left_out(
        &self,
        points: &[Vector3<f64>],
        pose: &Pose<3>,
        limit: f64,
    ) -> Option<f64> {
        let Self::Space(field) = self else { return None };
        let moved = some_moved(points, pose);
        let frames = field.frames(&moved, Search::Global, &[]);
        let is_out: Vec<bool> =
            frames.iter().map(|frame| frame.on_boundary || frame.distance.abs() > limit).collect();
        let found = surface_left_out(&moved, &is_out).iter().filter(|found| **found).count();
        Some(found as f64 / moved.len().max(1) as f64)
    }

    /// Distances of points, not negative.
    pub(crate) fn distances(&self, points: &[Vector3<f64>]) -> Vec<f64> {
        fn of<const D: usize>(frames: &[PrincipalFrame<D>]) -> Vec<f64> {
            frames.iter().map(|frame| frame.distance.abs()).collect()
        }
        match self {
            Self::Plane(field) => {
                let points: Vec<_> = points.iter().map(Vector3::xy).collect();
                of(&field.frames(&points, Search::Global, &[Hint::NONE; 0]))
            }
            Self::Space(field) => of(&field.frames(points, Search::Global, &[Hint::NONE; 0])),
        }
    }

    /// Registers points, all or those of them that tell where a start leads (`None` where these are all); in the plane their z, that
    /// of the normals, and what would turn or lift the start out of the plane are not looked at.
    pub(crate) fn register(
        &self,
        source: &Source<'_, 3>,
        start: &Pose<3>,
        options: &RegisterOptions<3>,
        extent: Extent<'_>,
        progress: &(dyn Fn(&RegisterStep) -> ControlFlow<()> + Sync),
    ) -> Result<Option<RegisterReport<3>>, Error> {
        fn run<const D: usize>(
            field: &dyn DistanceField<D>,
            source: &Source<'_, D>,
            start: &Pose<D>,
            options: &RegisterOptions<D>,
            extent: Extent<'_>,
            progress: &(dyn Fn(&RegisterStep) -> ControlFlow<()> + Sync),
        ) -> Result<Option<RegisterReport<D>>, Error> {
            match extent {
                Extent::Rest(_) | Extent::All => {
                    register_with_progress(field, source, start, options, progress).map(Some)
                }
                Extent::Some => register_some(field, source, start, options, progress),
                Extent::Few => {
                    let coarse_points = options.coarse_points.min(FEW);
                    register_some(
                        field,
                        source,
                        start,
                        &RegisterOptions { coarse_points, ..*options },
                        progress,
                    )
                }
            }
        }
        match (self, extent) {
            (Self::Space(field), Extent::Rest(some)) => {
                register_rest(field.as_ref(), source, start, some, options, progress).map(Some)
            }
            (Self::Space(field), _) => run(field.as_ref(), source, start, options, extent, progress),
            (Self::Plane(field), _) => {
                let points: Vec<_> = source.points.iter().map(Vector3::xy).collect();
                let normals: Option<Vec<_>> = source.normals.map(|all| all.iter().map(Vector3::xy).collect());
                let source = Source { points: &points, normals: normals.as_deref(), weights: source.weights };
                let report = run(field.as_ref(), &source, &flat(start)?, &planar(options), extent, progress)?;
                Ok(report.map(in_space))
            }
        }
    }
}

/// Some of the points, moved.
fn some_moved(points: &[Vector3<f64>], pose: &Pose<3>) -> Vec<Vector3<f64>> {
    let step = points.len().div_ceil(COMPARED).max(1);
    let finite = points.iter().step_by(step).filter(|x| x.iter().all(|c| c.is_finite()));
    finite.map(|x| pose.apply(x)).collect()
}

/// Which points are registered.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Extent<'a> {
    All,
    /// All, after some of them led to where a report says.
    Rest(&'a RegisterReport<3>),
    Some,
    Few,
}

/// A pose of the plane out of one of space.
fn flat(pose: &Pose<3>) -> Result<Pose<2>, Error> {
    let linear = pose.rotation.fixed_view::<2, 2>(0, 0) * pose.scale;
    Pose::<2>::from_linear(&linear, &pose.translation().xy())
}

/// The same options in the plane, where the only rotation is that about z.
fn planar(options: &RegisterOptions<3>) -> RegisterOptions<2> {
    let locks = &options.locks;
    let [tx, ty, _] = locks.translations;
    let locks = Locks::<2> { origin: locks.origin.xy(), ..Locks::default() }
        .with_translations([tx, ty, false])
        .with_rotations([locks.rotations[2], false, false]);
    RegisterOptions {
        method: options.method,
        control: options.control,
        footpoints: options.footpoints,
        outliers: options.outliers,
        rejection: options.rejection,
        locks,
        scale: options.scale,
        non_finite: options.non_finite,
        max_iterations: options.max_iterations,
        tolerance: options.tolerance,
        coarse_points: options.coarse_points,
        limits: options.limits,
        null_tolerance: options.null_tolerance,
    }
}

fn lifted(vector: &SVector<f64, 2>) -> Vector3<f64> {
    Vector3::new(vector.x, vector.y, 0.0)
}

/// A result of the plane as one of space. The covariance keeps its three unknowns: x, y and the angle about z.
fn in_space(report: RegisterReport<2>) -> RegisterReport<3> {
    let Pose { scale, rotation, source_origin, target_origin } = report.pose;
    let mut turn = Matrix3::identity();
    turn.fixed_view_mut::<2, 2>(0, 0).copy_from(&rotation);
    let free = |motion: FreeMotion<2>| match motion {
        FreeMotion::Translation { direction } => FreeMotion::Translation { direction: lifted(&direction) },
        FreeMotion::Rotation { axis, point } => FreeMotion::Rotation { axis, point: lifted(&point) },
        FreeMotion::Helical { axis, point, pitch } => {
            FreeMotion::Helical { axis, point: lifted(&point), pitch }
        }
        FreeMotion::Growth { point } => FreeMotion::Growth { point: lifted(&point) },
    };
    RegisterReport {
        pose: Pose {
            scale,
            rotation: turn,
            source_origin: lifted(&source_origin),
            target_origin: lifted(&target_origin),
        },
        status: report.status,
        support: report.support,
        rms: report.rms,
        initial_rms: report.initial_rms,
        iterations: report.iterations,
        evaluations: report.evaluations,
        points: report.points,
        dropped: report.dropped,
        used: report.used,
        limit: report.limit,
        covariance: report.covariance.map(|covariance| Covariance {
            rows: covariance.rows,
            origin: lifted(&covariance.origin),
            sigma: covariance.sigma,
            degrees_of_freedom: covariance.degrees_of_freedom,
            points_per_independent: covariance.points_per_independent,
            correlation_length: covariance.correlation_length,
            conditioning: covariance.conditioning,
        }),
        free_motions: report.free_motions.into_iter().map(free).collect(),
        history: report.history,
    }
}

/// Whether what is locked is a motion of the plane: x, y or the angle about z.
pub(crate) fn locks_fit_the_plane(options: &RegisterOptions<3>) -> bool {
    let Locks { translations: [.., tz], rotations: [rx, ry, _], .. } = options.locks;
    !(tz || rx || ry)
}

#[cfg(test)]
mod tests {
    use super::*;
    use industrial_geometry::mesh::nalgebra::Vector2;

    #[test]
    fn a_turn_about_z_is_one_of_the_plane() {
        let (sine, cosine) = 0.3f64.sin_cos();
        let turn = Matrix3::new(cosine, -sine, 0.0, sine, cosine, 0.0, 0.0, 0.0, 1.0);
        let pose = flat(&Pose::new(turn, Vector3::new(1.0, 2.0, 0.0))).unwrap();
        let x = Vector2::new(0.5, -0.25);
        let moved = turn * lifted(&x) + Vector3::new(1.0, 2.0, 0.0);
        assert!((pose.apply(&x) - moved.xy()).norm() < 1e-15);
        // A turn about x is none.
        let tilt = Matrix3::new(1.0, 0.0, 0.0, 0.0, cosine, -sine, 0.0, sine, cosine);
        assert!(flat(&Pose::new(tilt, Vector3::zeros())).is_err());
    }
}
