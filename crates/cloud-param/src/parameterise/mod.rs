//! The whole way from a cloud to a base surface and parameters.

mod cylinder;
mod options;
mod plane;
mod report;
mod sphere;

pub use options::ParameteriseOptions;
pub use report::{ParameterStatus, Parameterisation, ParameteriseReport, Stage, StageTime};

use crate::components::components;
use crate::defects::SurfaceDefects;
use crate::shape::decide;
use crate::{AxisChoice, AxisEstimate, Error, Neighbourhood, Shape, ShapeDecision, estimate_axis};
use footpoint::{Location, Multiplicity, SurfaceFootpoint, SurfaceProjector};
use nalgebra::Vector3;
use nurbs_core::BsplineSurface;
use sdm_fit::{CloudKind, cloud_kind, measurable};
use std::ops::ControlFlow;
use std::time::Instant;

/// Fewest points.
const LEAST: usize = 100;
/// Distance, in spacings, up to which points belong to one part.
const REACH: f64 = 6.0;
/// Share of the points that strays may have.
const STRAYS: f64 = 0.02;
/// Share of the directions around the axis that the layers must cover on average.
const AROUND: f64 = 0.75;
/// Widest gap in the directions of a layer, as a share of a whole turn.
const GAP: f64 = 0.15;
/// Mean square of the cosine between normals and axis beyond which there is no cylinder; 1/3 for a sphere.
const ALONG: f64 = 0.42;
/// Mean share of the directions covered from which on this does not matter.
const NO_GAP: f64 = 0.97;
/// Share of the base surface that may lie over holes.
const MISSING: f64 = 0.15;
/// Share of the points that may lie beyond the ends.
const BEYOND: f64 = 0.05;

/// Told the stage that begins; a break cancels.
pub type Progress<'a> = &'a (dyn Fn(Stage) -> ControlFlow<()> + Sync);

/// A progress callback that does nothing.
///
/// # Errors
/// Never breaks.
pub fn no_progress(_stage: Stage) -> ControlFlow<()> {
    ControlFlow::Continue(())
}

/// A base surface that a step has made, with what it tells about it.
struct Base {
    surface: BsplineSurface,
    report: ParameteriseReport,
}

/// From an unorganised cloud to a base surface and a parameter pair for each point (\[MPK\]), without boundary curves and without
/// a choice to be made.
///
/// The surface follows the cloud; it is the parameters of the footpoints on it that a fit needs: see
/// [`fit_parameters`](crate::fit_parameters). What remains wrong is in the [`ParameterStatus`] of the result.
///
/// # Errors
/// [`Error::TooFewPoints`] for fewer than 100 finite points, [`Error::Shape`] for a cloud of another kind than asked for, or of
/// several parts, [`Error::Option`].
///
/// ```
/// use cloud_param::{ParameteriseOptions, Shape, parameterise};
/// use nalgebra::Vector3;
///
/// // A vase, its points in no order.
/// let point = |i: u32| {
///     let (a, h) = (f64::from(i) * 2.399963, (f64::from(i) * 0.7548777).fract());
///     let r = 1.0 + 0.3 * (4.0 * h).sin() + 0.1 * (3.0 * a).cos();
///     Vector3::new(r * a.cos(), r * a.sin(), 3.0 * h)
/// };
/// let points: Vec<_> = (0..6000).map(point).collect();
/// let found = parameterise(&points, &ParameteriseOptions::default())?;
/// assert_eq!(found.report.shape.shape, Shape::Cylinder);
/// assert!(found.is_converged() && found.base.knots_u().is_periodic());
/// assert!(found.report.rms < 0.02);
/// # Ok::<(), cloud_param::Error>(())
/// ```
pub fn parameterise(
    points: &[Vector3<f64>],
    options: &ParameteriseOptions,
) -> Result<Parameterisation, Error> {
    parameterise_with_progress(points, options, &no_progress)
}

/// As [`parameterise`], telling what it is at.
///
/// # Errors
/// As [`parameterise`], and [`Error::Cancelled`].
pub fn parameterise_with_progress(
    points: &[Vector3<f64>],
    options: &ParameteriseOptions,
    progress: Progress<'_>,
) -> Result<Parameterisation, Error> {
    let mut clock = Clock { progress, times: Vec::new(), began: Instant::now() };
    clock.enter(Stage::Preparation)?;
    let belongs = measurable(points)?;
    let finite: Vec<Vector3<f64>> =
        points.iter().zip(&belongs).filter(|(_, b)| **b).map(|(p, _)| *p).collect();
    if finite.len() < LEAST {
        return Err(Error::TooFewPoints { total: points.len(), usable: finite.len(), needed: LEAST });
    }
    // Near the origin coordinates have more digits.
    let (low, high) = finite.iter().fold((finite[0], finite[0]), |(l, h), p| (l.inf(p), h.sup(p)));
    let centre = low + (high - low) / 2.0;
    let centred: Vec<Vector3<f64>> = finite.iter().map(|p| p - centre).collect();
    let (cloud, stray) = one_part(&centred)?;
    is_surface(&cloud)?;

    clock.enter(Stage::Axis)?;
    let axis = estimate_axis(cloud.points(), options.axis)?;
    let shape = match options.shape {
        Shape::Auto => as_with_its_own(&cloud, decide(&cloud, &axis)?, options.axis)?,
        shape => ShapeDecision { shape, why: "it was asked for".into() },
    };
    let base = match shape.shape {
        Shape::Plane => plane::base(&cloud, shape, &axis, &mut clock)?,
        Shape::Sphere => sphere::base(&cloud, shape, &axis, options, &mut clock)?,
        Shape::Cylinder | Shape::Auto => {
            closes(&cloud, &axis, options.axis)?;
            cylinder::base(&cloud, shape, &axis, options, &mut clock)?
        }
    };

    clock.enter(Stage::Parameters)?;
    let surface = base.surface.translated(&centre)?;
    // Points that cannot belong to the cloud are strays without a foot.
    let nowhere = Vector3::repeat(f64::NAN);
    let given: Vec<Vector3<f64>> =
        points.iter().zip(&belongs).map(|(p, b)| if *b { *p } else { nowhere }).collect();
    let all = SurfaceProjector::new(&surface).project_all(&given);
    let mut report = base.report;
    report.points = points.len();
    report.dropped = points.iter().filter(|p| !p.iter().all(|c| c.is_finite())).count();
    report.spacing = cloud.pitch();
    // Strays by the indices of the points given.
    let mut finite_stray = stray.into_iter();
    let stray: Vec<bool> = points
        .iter()
        .zip(&belongs)
        .map(|(p, b)| if *b { finite_stray.next().unwrap_or(false) } else { p.iter().all(|c| c.is_finite()) })
        .collect();
    report.strays = stray.iter().filter(|s| **s).count();
    let counts = judge(&all, &stray, &mut report);
    report.status = status(&report);
    report.times = clock.stop();
    Ok(Parameterisation { base: surface, feet: all, counts, report })
}

/// The largest part of the cloud, if the others are strays, and which points these are. Points that are given many times over
/// count once: others would have no neighbours but them.
fn one_part(points: &[Vector3<f64>]) -> Result<(Neighbourhood, Vec<bool>), Error> {
    let (distinct, number) = distinct(points);
    if distinct.len() < LEAST {
        return Err(Error::TooFewPoints { total: points.len(), usable: distinct.len(), needed: LEAST });
    }
    let cloud = Neighbourhood::new(&distinct)?;
    let (part, sizes) = components(cloud.points(), REACH * cloud.pitch());
    let strays: usize = sizes[1..].iter().sum();
    if strays == 0 {
        return Ok((cloud, vec![false; points.len()]));
    }
    if strays as f64 > STRAYS * distinct.len() as f64 {
        return Err(Error::Shape {
            wanted: "one surface",
            why: format!(
                "it falls apart into {} parts, of {} and {} points and fewer, more than {:.4} apart; separate them, or scan the gaps",
                sizes.len(),
                sizes[0],
                sizes[1],
                REACH * cloud.pitch()
            ),
        });
    }
    let kept: Vec<Vector3<f64>> =
        distinct.iter().zip(&part).filter(|(_, k)| **k == 0).map(|(p, _)| *p).collect();
    Ok((Neighbourhood::new(&kept)?, number.iter().map(|&k| part[k] > 0).collect()))
}

/// Whether the points are those of a surface: not of a curve, and not all through a volume.
fn is_surface(cloud: &Neighbourhood) -> Result<(), Error> {
    let why = match cloud_kind(cloud.points())? {
        CloudKind::Curve => "its points lie along a curve, with nothing beside them; fit a curve instead",
        CloudKind::Volume => {
            "its points have others on all sides, however large the neighbourhood: they fill a volume; take those of its boundary"
        }
        _ => return Ok(()),
    };
    Err(Error::Shape { wanted: "a surface", why: why.to_owned() })
}

/// Points without those that are equal to an earlier one, and for each point the number of the one that stands for it.
fn distinct(points: &[Vector3<f64>]) -> (Vec<Vector3<f64>>, Vec<usize>) {
    let mut order: Vec<usize> = (0..points.len()).collect();
    let compare = |i: &usize, j: &usize| {
        let (a, b) = (points[*i], points[*j]);
        a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)).then(a.z.total_cmp(&b.z)).then(i.cmp(j))
    };
    order.sort_unstable_by(compare);
    let mut first: Vec<usize> = (0..points.len()).collect();
    for pair in order.windows(2) {
        if points[pair[0]] == points[pair[1]] {
            first[pair[1]] = first[pair[0]];
        }
    }
    let (mut kept, mut number) = (Vec::with_capacity(points.len()), vec![0; points.len()]);
    for (i, &earlier) in first.iter().enumerate() {
        if earlier == i {
            number[i] = kept.len();
            kept.push(points[i]);
        } else {
            number[i] = number[earlier];
        }
    }
    (kept, number)
}

/// A decision for a sphere by a given axis, if the cloud's own axis leads to it as well: across it, a tube that is open at its ends
/// looks closed all around.
fn as_with_its_own(
    cloud: &Neighbourhood,
    found: ShapeDecision,
    choice: AxisChoice,
) -> Result<ShapeDecision, Error> {
    if found.shape != Shape::Sphere || choice == AxisChoice::Automatic {
        return Ok(found);
    }
    let own = estimate_axis(cloud.points(), AxisChoice::Automatic)?;
    if decide(cloud, &own)?.shape == Shape::Sphere {
        return Ok(found);
    }
    let a = &own.direction;
    Err(Error::Shape {
        wanted: "closed around the given axis",
        why: format!(
            "it would be taken for a sphere, and its open ends be closed; the axis ({:.3}, {:.3}, {:.3}) fits",
            a.x, a.y, a.z
        ),
    })
}

/// Whether the layers close around the axis.
fn closes(cloud: &Neighbourhood, axis: &AxisEstimate, choice: AxisChoice) -> Result<(), Error> {
    // Threads face along the axis, too, but leave no gap.
    let faces_along = |axis: &AxisEstimate| axis.normals_along > ALONG && axis.coverage.mean() < NO_GAP;
    let fits = |axis: &AxisEstimate| {
        !faces_along(axis) && axis.coverage.median() >= AROUND && axis.coverage.typical_gap() <= GAP
    };
    if fits(axis) {
        return Ok(());
    }
    let better = match choice {
        AxisChoice::Automatic => None,
        _ => estimate_axis(cloud.points(), AxisChoice::Automatic).ok().filter(fits),
    };
    let advice = match better {
        Some(a) => format!(
            "the axis ({:.3}, {:.3}, {:.3}) fits, around which they close to {:.0} %",
            a.direction.x,
            a.direction.y,
            a.direction.z,
            100.0 * a.coverage.median()
        ),
        None => "a surface that is open on one side needs the shape plane".into(),
    };
    let what =
        if faces_along(axis) { "it faces along the axis like a bowl or a sheet" } else { "it is open" };
    Err(Error::Shape {
        wanted: "a cylinder",
        why: format!(
            "{what}: its layers close to {:.0} % around the axis ({:.3}, {:.3}, {:.3}), with gaps of {:.0} degrees; {advice}",
            100.0 * axis.coverage.median(),
            axis.direction.x,
            axis.direction.y,
            axis.direction.z,
            360.0 * axis.coverage.typical_gap()
        ),
    })
}

/// Which points count for a fit: those with a foot of their own, and those beyond an open end by no more than others are
/// off the surface. Fills in what the feet say.
fn judge(feet: &[SurfaceFootpoint], stray: &[bool], report: &mut ParameteriseReport) -> Vec<bool> {
    let inner = |foot: &&SurfaceFootpoint| {
        foot.status.is_converged() && !matches!(foot.location, Location::Edge | Location::Corner)
    };
    let mut distances: Vec<f64> = feet.iter().filter(inner).map(|f| f.distance).collect();
    distances.sort_by(f64::total_cmp);
    let limit = distances.get(distances.len() * 9 / 10).map_or(0.0, |d| 3.0 * d).max(report.spacing);
    let counts: Vec<bool> = feet
        .iter()
        .zip(stray)
        .map(|(foot, &stray)| {
            !stray && foot.status.is_converged() && (inner(&foot) || foot.distance <= limit)
        })
        .collect();
    let used: Vec<&SurfaceFootpoint> =
        feet.iter().zip(&counts).filter(|(_, c)| **c).map(|(f, _)| f).collect();
    let finite = (report.points - report.dropped).max(1) as f64;
    report.used = used.len();
    report.rms = (used.iter().map(|f| f.distance.powi(2)).sum::<f64>() / used.len().max(1) as f64).sqrt();
    report.max = used.iter().map(|f| f.distance).fold(0.0, f64::max);
    let unique =
        feet.iter().filter(|f| f.status.is_converged() && f.multiplicity == Multiplicity::Unique).count();
    report.unique = unique as f64 / finite;
    report.beyond_ends = counts.iter().filter(|c| !**c).count() - report.dropped - report.strays;
    counts
}

fn status(report: &ParameteriseReport) -> ParameterStatus {
    let far = report.rms > report.spacing;
    if !report.defects.is_none() {
        ParameterStatus::Folded
    } else if far || report.unsupported > MISSING || report.beyond_ends as f64 > BEYOND * report.points as f64
    {
        ParameterStatus::Incomplete
    } else {
        ParameterStatus::Converged
    }
}

/// Fills in what is wrong with a base surface.
fn defects(surface: &BsplineSurface, axes: Option<&[Vector3<f64>; 3]>) -> SurfaceDefects {
    SurfaceDefects::of(surface, axes)
}

/// Tells the stages and takes their times.
struct Clock<'a> {
    progress: Progress<'a>,
    times: Vec<StageTime>,
    began: Instant,
}

impl Clock<'_> {
    fn enter(&mut self, stage: Stage) -> Result<(), Error> {
        self.close();
        if (self.progress)(stage).is_break() {
            return Err(Error::Cancelled);
        }
        self.times.push(StageTime { stage, seconds: 0.0 });
        Ok(())
    }

    fn close(&mut self) {
        if let Some(last) = self.times.last_mut() {
            last.seconds = self.began.elapsed().as_secs_f64();
        }
        self.began = Instant::now();
    }

    fn stop(mut self) -> Vec<StageTime> {
        self.close();
        self.times
    }
}
