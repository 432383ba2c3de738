//! The distance of a shape at the nodes of a grid: read, compute, write.

mod arrays;
mod exact;
mod picture;
mod scene_file;
mod shape;

use crate::error::Error;
use crate::files;
use crate::fits::input::warn_dropped;
use crate::input::image_or_grid::refused;
use crate::report::wording::counted;
use crate::report::{Input, Output, ReadSummary, Report, Timings};
use crate::runtime::progress::Progress;
use industrial_geometry::distance_field::grid::{
    Element, InsideRule, Lattice, Medium, Scene, Seed, carry, march, seeds, seeds_on_faces, sweep,
};
use industrial_geometry::io::{Content, ReadOptions};
use industrial_geometry::level_set::Image;
use industrial_geometry::mesh::nalgebra::{SVector, Vector2};
use serde::Serialize;
use shape::{Closest, Shape, Sides, SpaceShape};
use std::path::Path;

/// Nodes along the longest side where no grid is given, in the plane and in space.
const DEFAULT_NODES: [usize; 2] = [257, 65];
/// Share of the diagonal of a shape that is left free around it where no box is given.
const MARGIN: f64 = 0.1;
/// Nodes around a source that are exact for marching of second order, in spacings.
const BALL: f64 = 4.0;

/// Distance of curves from the contours of an image above which it is said, in pixels.
const WORST_CONTOUR: f64 = 0.05;

/// How distances are found.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub(crate) enum Method {
    /// The distance of every node for itself; around obstacles the shortest way
    Exact,
    /// Fast sweeping (Zhao), first order
    Zhao,
    /// Nearest points carried from node to node (Tsai)
    Tsai,
    /// Fast marching, first order
    Fmm,
    /// Fast marching, second order
    Fmm2,
}

impl Method {
    fn name(self) -> &'static str {
        match self {
            Self::Exact => "exact",
            Self::Zhao => "zhao",
            Self::Tsai => "tsai",
            Self::Fmm => "fmm",
            Self::Fmm2 => "fmm2",
        }
    }

    /// Up to which distance from the source nodes are exact from the start.
    fn margin<const D: usize>(self, lattice: &Lattice<D>) -> f64 {
        let spacing = lattice.spacing();
        if self == Self::Fmm2 { BALL * spacing.max() } else { spacing.norm() }
    }
}

/// What is to be done.
#[derive(Debug)]
pub(crate) struct Job<'a> {
    /// File of the shape or scene.
    pub(crate) shape: &'a Path,
    /// File of the values.
    pub(crate) out: Option<&'a Path>,
    /// Nodes along each axis.
    pub(crate) grid: Option<&'a [usize]>,
    /// The box, low end first.
    pub(crate) bounds: Option<&'a [f64]>,
    /// How distances are found.
    pub(crate) method: Method,
    /// Whether distances inside are negative.
    pub(crate) signed: bool,
    /// Targets of shortest ways.
    pub(crate) targets: &'a [[f64; 2]],
    /// File of the picture.
    pub(crate) picture: Option<&'a Path>,
    /// Whether nobody wants to watch.
    pub(crate) quiet: bool,
}

/// What was found.
#[derive(Debug, Serialize)]
pub(crate) struct FieldResults {
    /// The method, by its name on the command line.
    pub(crate) method: &'static str,
    /// Nodes along each axis.
    pub(crate) grid: Vec<usize>,
    /// The first node, then the last one.
    #[serde(rename = "box")]
    pub(crate) bounds: [Vec<f64>; 2],
    /// Number of nodes.
    pub(crate) nodes: usize,
    /// Nodes inside of obstacles.
    pub(crate) blocked: usize,
    /// Nodes to which no way leads.
    pub(crate) unreachable: usize,
    /// Nodes whose distance is not proven, or was not found.
    pub(crate) not_proven: usize,
    /// Smallest and largest distance.
    pub(crate) min: Option<f64>,
    pub(crate) max: Option<f64>,
    /// Rounds of sweeps, for methods that sweep.
    pub(crate) rounds: Option<usize>,
    /// Points, segments or triangles that stand for the shape, for methods that go from node to node.
    pub(crate) elements: Option<usize>,
    /// Largest distance of a curve or surface from these, where they are carried; of the contours of an image from the curves as well.
    pub(crate) chord: Option<f64>,
    /// Shortest ways, as asked for.
    pub(crate) paths: Vec<PathResult>,
}

/// A shortest way.
#[derive(Debug, Serialize)]
pub(crate) struct PathResult {
    /// Where it leads.
    pub(crate) target: [f64; 2],
    /// Its length; `null` if there is none.
    pub(crate) length: Option<f64>,
    /// Its bends, from the source to the target.
    pub(crate) points: Vec<[f64; 2]>,
}

/// Values at the nodes, and how they were found.
#[derive(Debug, Default)]
struct Found {
    values: Vec<f64>,
    blocked: usize,
    not_proven: usize,
    rounds: Option<usize>,
    elements: Option<usize>,
    chord: Option<f64>,
    paths: Vec<PathResult>,
    obstacles: Vec<Vec<[f64; 2]>>,
}

/// Does the job and fills in the report; returns whether everything that was asked for was found.
pub(crate) fn run(job: &Job<'_>, report: &mut Report) -> Result<bool, Error> {
    for path in [job.out, job.picture].into_iter().flatten() {
        files::check_writable(path, &[job.shape])?;
    }
    let form = job.out.map(arrays::form_of).transpose()?;
    if let Some(path) = job.picture {
        picture::check(path)?;
    }
    let mut timings = Timings::default();
    let bytes = Timings::measure(&mut timings.read, || files::read_bytes(job.shape))?;
    if let Some(scene) = scene_file::of_bytes(&bytes, job.shape)? {
        report.add_input(Input {
            role: "model",
            path: job.shape.to_path_buf(),
            read: ReadSummary {
                format: "json".to_owned(),
                shapes: scene.obstacles.len(),
                ..ReadSummary::default()
            },
        });
        let lattice = lattice::<2>(job, Some((scene.low, scene.high)))?;
        let found = Timings::measure(&mut timings.compute, || in_scene(job, &scene, &lattice))?;
        return conclude(job, &lattice, found, form, timings, report);
    }
    if Image::is_image(&bytes) {
        let image = Timings::measure(&mut timings.read, || Image::from_bytes(&bytes));
        let image = image.map_err(|error| refused(job.shape, &error))?;
        without_targets(job)?;
        report.add_input(Input::of_shapes("model", job.shape, "image", 0));
        let (shape, gap) = Timings::measure(&mut timings.build, || shape::of_image(&image, job.shape))?;
        if gap > WORST_CONTOUR {
            report.warnings.push(format!(
                "{}: the curves are up to {gap:.3} pixels from the contours of the image; smooth it first",
                job.shape.display()
            ));
        }
        let lattice = lattice::<2>(job, shape.bounds())?;
        let mut found = of_shape(job, &shape, &lattice, &mut timings)?;
        found.chord = Some(found.chord.unwrap_or(0.0) + gap);
        return conclude(job, &lattice, found, form, timings, report);
    }
    let loaded = Timings::measure(&mut timings.read, || {
        files::read_from_bytes(&bytes, job.shape, &ReadOptions::default())
    })?;
    drop(bytes);
    without_targets(job)?;
    report.add_input(Input::new("model", job.shape, &loaded.report));
    report.warnings.extend(loaded.report.warnings.iter().map(|w| format!("{}: {w}", job.shape.display())));
    if let (Content::Cloud(cloud), lost @ 1..) = (&loaded.content, loaded.report.non_finite) {
        warn_dropped(job.shape, lost, cloud.len(), report);
    }
    match Timings::measure(&mut timings.build, || shape::of_content(loaded.content, job.shape, job.signed))? {
        Sides::Plane(shape) => {
            let lattice = lattice::<2>(job, shape.bounds())?;
            let found = of_shape(job, &shape, &lattice, &mut timings)?;
            conclude(job, &lattice, found, form, timings, report)
        }
        Sides::Space(shape) => {
            if let SpaceShape::Mesh { closest, .. } = &shape {
                warn_of_mesh(job.shape, closest, report);
            }
            let lattice = lattice::<3>(job, shape.bounds())?;
            let found = of_shape(job, &shape, &lattice, &mut timings)?;
            conclude(job, &lattice, found, form, timings, report)
        }
    }
}

/// Says what of a mesh does not count, and what tells its inside where it does not bound a solid.
fn warn_of_mesh(path: &Path, closest: &Closest, report: &mut Report) {
    let name = path.display();
    let projector = closest.projector();
    if projector.skipped() > 0 {
        let count = counted(projector.skipped(), "triangle");
        report
            .warnings
            .push(format!("{name}: {count} without area or with coordinates that are not finite left out"));
    }
    let Closest::Signed(inside) = closest else { return };
    if inside.turned() > 0 {
        let count = counted(inside.turned(), "triangle");
        report.warnings.push(format!("{name}: {count} turned to the side of their neighbours"));
    }
    if inside.rule() == InsideRule::Winding {
        report.warnings.push(format!(
            "{name}: the mesh bounds no simple solid ({}): inside is where its generalised winding number exceeds one half; seen from its \
             triangles, {:.1} % of the inside is open",
            projector.topology(),
            100.0 * (1.0 - inside.closure())
        ));
    }
}

/// Ways lead around the obstacles of scenes only.
fn without_targets(job: &Job<'_>) -> Result<(), Error> {
    if job.targets.is_empty() {
        return Ok(());
    }
    Err(Error::usage("--path asks for ways around obstacles", "give a scene (see `indgeo field --help`)"))
}

/// The grid that is asked for; `shape` is the box of the shape, or that of a scene.
fn lattice<const D: usize>(
    job: &Job<'_>,
    shape: Option<(SVector<f64, D>, SVector<f64, D>)>,
) -> Result<Lattice<D>, Error> {
    let bounds = match job.bounds {
        Some(bounds) if bounds.len() == 2 * D => {
            (SVector::from_fn(|k, _| bounds[k]), SVector::from_fn(|k, _| bounds[D + k]))
        }
        Some(bounds) => {
            let what = format!("--box has {} numbers, but the shape lies in {D} dimensions", bounds.len());
            return Err(Error::usage(what, "give the low end, then the high end"));
        }
        None => shape.ok_or_else(|| {
            Error::content(
                job.shape,
                "the shape has no extent from which a box would follow, or one too large for squares of lengths",
                "give one: --box, or scale the shape",
            )
        })?,
    };
    let sides = bounds.1 - bounds.0;
    let counts: [usize; D] = match job.grid {
        Some(counts) => <[usize; D]>::try_from(counts).map_err(|_| {
            let what = format!("--grid has {} counts, but the shape lies in {D} dimensions", counts.len());
            Error::usage(what, "give one count per axis, as 257x257 or 129x129x129")
        })?,
        // Cells as nearly cubes as they can be.
        None => std::array::from_fn(|k| share_of(DEFAULT_NODES[usize::from(D == 3)], sides[k] / sides.max())),
    };
    Lattice::new(bounds.0, bounds.1, counts)
        .map_err(|error| Error::usage(error.to_string(), "change --grid or --box"))
}

/// The share of a number of nodes, at least 2.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a share of a small number")]
fn share_of(nodes: usize, share: f64) -> usize {
    ((nodes as f64 * share).round() as usize).clamp(2, nodes)
}

/// Distances from the source of a scene.
fn in_scene(job: &Job<'_>, file: &scene_file::SceneFile, lattice: &Lattice<2>) -> Result<Found, Error> {
    let failed = |error: industrial_geometry::distance_field::Error| {
        Error::content(job.shape, error.to_string(), "correct the scene")
    };
    if job.signed {
        return Err(Error::usage("--signed has no effect in a scene", "leave it out"));
    }
    let scene = Scene::new(file.low, file.high, file.source, &file.obstacles).map_err(failed)?;
    let mut found = Found::default();
    if job.method == Method::Exact {
        found.values = scene.distances(lattice);
    } else {
        if job.method == Method::Tsai && !file.obstacles.is_empty() {
            let what = "--method tsai measures straight distances, which obstacles bend";
            return Err(Error::usage(what, "choose exact, zhao, fmm or fmm2"));
        }
        let blocked: Vec<bool> =
            (0..lattice.len()).map(|node| scene.is_blocked(&lattice.point(node))).collect();
        let source = [Element::Point(file.source)];
        let straight = |seed: &Seed| {
            // Not through a wall.
            scene.distance(&lattice.point(seed.node)).is_some_and(|way| way <= seed.distance * (1.0 + 1e-9))
        };
        let mut near = seeds(lattice, &source, job.method.margin(lattice));
        near.retain(straight);
        if near.is_empty() {
            near = seeds_on_faces(lattice, &source);
        }
        found = by_method(job.method, lattice, &source, &near, &Medium { blocked, ..Medium::default() });
        let inside = |node: usize| scene.is_blocked(&lattice.point(node));
        for node in 0..found.values.len() {
            if found.values[node].is_infinite() && inside(node) {
                found.values[node] = -1.0;
            }
        }
    }
    found.blocked = found.values.iter().filter(|value| **value == -1.0).count();
    for target in file.targets.iter().chain(job.targets) {
        let target = Vector2::from(*target);
        let path = scene.path(&target);
        found.paths.push(PathResult {
            target: target.into(),
            length: path.as_ref().map(|path| path.length),
            points: path.map_or_else(Vec::new, |path| path.points.into_iter().map(Into::into).collect()),
        });
    }
    found.obstacles =
        file.obstacles.iter().map(|polygon| polygon.iter().map(|p| (*p).into()).collect()).collect();
    Ok(found)
}

/// Distances from a shape.
fn of_shape<const D: usize, S: Shape<D>>(
    job: &Job<'_>,
    shape: &S,
    lattice: &Lattice<D>,
    timings: &mut Timings,
) -> Result<Found, Error> {
    let progress = Progress::new("distances", job.quiet);
    let began = std::time::Instant::now();
    let mut found = if job.method == Method::Exact {
        let (values, not_proven) = exact::distances(shape, lattice, job.signed, &progress)?;
        Found { values, not_proven, ..Found::default() }
    } else {
        let cell = lattice.spacing().min();
        let (elements, chord) = shape.elements(cell, job.shape)?;
        let near = if job.method == Method::Tsai {
            let near = seeds(lattice, &elements, job.method.margin(lattice));
            if near.is_empty() { seeds_on_faces(lattice, &elements) } else { near }
        } else {
            exact::seeds_of(shape, lattice, &seeds(lattice, &elements, job.method.margin(lattice)))?
        };
        let mut found = by_method(job.method, lattice, &elements, &near, &Medium::default());
        found.chord = chord.filter(|_| job.method == Method::Tsai);
        if job.signed {
            exact::turn_inside(shape, lattice, &mut found.values)?;
        }
        found
    };
    found.obstacles = Vec::new();
    timings.compute += began.elapsed().as_secs_f64();
    Ok(found)
}

/// Distances by a method that goes from node to node.
fn by_method<const D: usize>(
    method: Method,
    lattice: &Lattice<D>,
    elements: &[Element<D>],
    near: &[Seed],
    medium: &Medium,
) -> Found {
    let (values, rounds) = match method {
        Method::Exact | Method::Zhao => sweep(lattice, near, medium),
        Method::Tsai => carry(lattice, elements, near),
        Method::Fmm => (march(lattice, near, medium, false), 0),
        Method::Fmm2 => (march(lattice, near, medium, true), 0),
    };
    Found {
        values,
        rounds: (rounds > 0).then_some(rounds),
        elements: Some(elements.len()),
        ..Found::default()
    }
}

/// Writes what was found.
fn conclude<const D: usize>(
    job: &Job<'_>,
    lattice: &Lattice<D>,
    found: Found,
    form: Option<arrays::Form>,
    mut timings: Timings,
    report: &mut Report,
) -> Result<bool, Error> {
    Timings::measure(&mut timings.write, || -> Result<(), Error> {
        if let (Some(path), Some(form)) = (job.out, form) {
            let bytes = files::write(path, |out| arrays::write(out, form, lattice, &found.values))?;
            let content = counted(found.values.len(), "distance");
            report.add_output(Output { path: path.to_path_buf(), bytes, content });
        }
        if let Some(path) = job.picture {
            picture::write(path, lattice, &found.values, &found.obstacles, &found.paths, report)?;
        }
        Ok(())
    })?;
    report.timings = timings;
    let blocked = |value: f64| found.blocked > 0 && value == -1.0;
    let finite = found.values.iter().copied().filter(|value| value.is_finite() && !blocked(*value));
    let (min, max) =
        finite.fold((f64::INFINITY, f64::NEG_INFINITY), |(min, max), value| (min.min(value), max.max(value)));
    let unreachable = found.values.iter().filter(|value| **value == f64::INFINITY).count();
    if unreachable > 0 {
        report.warnings.push(format!(
            "{}: no way leads to {} of {}, which are infinite",
            job.shape.display(),
            unreachable,
            counted(found.values.len(), "node")
        ));
    }
    if found.not_proven > 0 {
        report.warnings.push(format!(
            "{}: the distance of {} of {} is not proven or was not found",
            job.shape.display(),
            found.not_proven,
            counted(found.values.len(), "node")
        ));
    }
    let lost = found.paths.iter().filter(|path| path.length.is_none()).count();
    if lost > 0 {
        let what = format!("{}: no way leads to {}", job.shape.display(), counted(lost, "target"));
        report.warnings.push(what);
    }
    let is_done = found.not_proven == 0 && lost == 0;
    report.results = Some(Box::new(FieldResults {
        method: job.method.name(),
        grid: lattice.counts().to_vec(),
        bounds: [lattice.low(), lattice.high()].map(|end| end.iter().copied().collect()),
        nodes: found.values.len(),
        blocked: found.blocked,
        unreachable,
        not_proven: found.not_proven,
        min: (min <= max).then_some(min),
        max: (min <= max).then_some(max),
        rounds: found.rounds,
        elements: found.elements,
        chord: found.chord,
        paths: found.paths,
    }));
    Ok(is_done)
}
