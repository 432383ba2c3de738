//! Contours of images and volumes: read, find, fit, measure, write.

mod drawing;
mod level_function;
mod output;
pub(crate) mod plane;
mod surface;
mod volume;

use crate::error::Error;
use crate::files;
use crate::input::image_or_grid::{self, Source};
use crate::output::cad::CadArgs;
use crate::report::{Report, Timings};
use serde::Serialize;
use std::path::Path;

/// How a contour is found.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub(crate) enum Method {
    /// Where the values have the level
    Threshold,
    /// A region evolves until inside and outside are even (Chan and Vese)
    ChanVese,
    /// A contour is drawn to edges (geodesic active contour)
    Edges,
}

impl Method {
    fn name(self) -> &'static str {
        match self {
            Self::Threshold => "threshold",
            Self::ChanVese => "chan-vese",
            Self::Edges => "edges",
        }
    }
}

/// Which side of the level is inside.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub(crate) enum Region {
    /// What an image shows; in grids what is below the level
    Auto,
    /// Above the level
    Bright,
    /// Below the level
    Dark,
}

/// Whether the topology may change.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub(crate) enum Topology {
    /// Parts join, split and vanish
    Free,
    /// The numbers of components and holes stay those of the start
    Fixed,
}

/// What is to be done.
#[derive(Debug)]
pub(crate) struct Job<'a> {
    /// File of the image or grid.
    pub(crate) input: &'a Path,
    /// File of the curves or of the mesh.
    pub(crate) out: Option<&'a Path>,
    /// How the contour is found.
    pub(crate) method: Method,
    /// The value on it.
    pub(crate) level: Option<f64>,
    /// Which side is inside.
    pub(crate) inside: Region,
    /// Standard deviation of the smoothing of an image.
    pub(crate) smooth: Option<f64>,
    /// Largest distance of curves and level set.
    pub(crate) tolerance: Option<f64>,
    /// Control points of every curve.
    pub(crate) controls: Option<usize>,
    /// Least area of a closed contour.
    pub(crate) min_area: Option<f64>,
    /// Whether the topology is held.
    pub(crate) is_held: bool,
    /// Circles to start from.
    pub(crate) start: &'a [[f64; 3]],
    /// Weight of the length or the curvature.
    pub(crate) length_weight: Option<f64>,
    /// Speed away from edges.
    pub(crate) balloon: Option<f64>,
    /// Ends of the box of a grid.
    pub(crate) bounds: Option<&'a [f64]>,
    /// File of the picture.
    pub(crate) picture: Option<&'a Path>,
    /// Name and unit of the result.
    pub(crate) cad: &'a CadArgs,
    /// Whether progress is not shown.
    pub(crate) quiet: bool,
}

/// What was found.
#[derive(Debug, Serialize)]
pub(crate) struct ContourResults {
    /// The method, by its name on the command line.
    pub(crate) method: &'static str,
    /// Pixels or nodes along each axis.
    pub(crate) size: Vec<usize>,
    /// The value on the contour; of evolved contours that of the start, if there was one.
    pub(crate) level: Option<f64>,
    /// `bright` or `dark`: which side of the level is inside.
    pub(crate) inside: Option<&'static str>,
    /// Standard deviation of the Gaussian, in pixels.
    pub(crate) smoothing: f64,
    /// Largest distance that was asked for.
    pub(crate) tolerance: f64,
    /// Largest distance that was found, over all contours and both ways.
    pub(crate) max: Option<f64>,
    /// Whether all contours are within the tolerance.
    pub(crate) within_tolerance: bool,
    /// Connected parts of the inside, as nodes of the grid.
    pub(crate) components: usize,
    /// Connected parts of the outside that are enclosed.
    pub(crate) holes: usize,
    /// Contours left out since they are small.
    pub(crate) left_out: usize,
    /// How the contour evolved, if it did.
    pub(crate) evolution: Option<EvolutionResult>,
    /// The curves, the longest first.
    pub(crate) contours: Vec<CurveResult>,
    /// The mesh of a volume.
    pub(crate) mesh: Option<MeshResult>,
    /// The surface of a volume, if it was asked for.
    pub(crate) surface: Option<surface::SurfaceResult>,
}

/// A curve of the result.
#[derive(Debug, Serialize)]
pub(crate) struct CurveResult {
    /// Its name in the model.
    pub(crate) name: String,
    /// Whether it is closed.
    pub(crate) closed: bool,
    /// Whether it bounds a hole.
    pub(crate) hole: bool,
    /// The area that the contour surrounds.
    pub(crate) area: f64,
    /// The length of the contour.
    pub(crate) length: f64,
    /// Number of control points, those that repeat counted once.
    pub(crate) control_points: usize,
    /// Largest distance of the curve from the level set.
    pub(crate) max_of_curve: f64,
    /// Largest distance of the contour from the curve.
    pub(crate) max_of_contour: f64,
    /// How often it crosses itself.
    pub(crate) crossings: usize,
    /// Whether it is what was asked for.
    pub(crate) within_tolerance: bool,
}

/// How a contour evolved.
#[derive(Debug, Serialize)]
pub(crate) struct EvolutionResult {
    /// Steps in time.
    pub(crate) steps: usize,
    /// Whether it came to rest.
    pub(crate) settled: bool,
    /// How far it moved at last, in pixels per unit of time.
    pub(crate) speed: f64,
    /// Components and holes at the start.
    pub(crate) components_at_start: usize,
    pub(crate) holes_at_start: usize,
}

/// The mesh of a volume.
#[derive(Debug, Serialize)]
pub(crate) struct MeshResult {
    /// Number of vertices.
    pub(crate) vertices: usize,
    /// Number of triangles.
    pub(crate) triangles: usize,
    /// Whether it is closed.
    pub(crate) closed: bool,
    /// Largest distance of the mesh from the level set.
    pub(crate) max_of_mesh: f64,
    /// Largest distance of the level set from the mesh.
    pub(crate) max_of_level_set: f64,
}

/// Does the job and fills in the report; returns what is wrong with the result, if anything is.
pub(crate) fn run(job: &Job<'_>, report: &mut Report) -> Result<Option<&'static str>, Error> {
    for path in [job.out, job.picture].into_iter().flatten() {
        files::check_writable(path, &[job.input])?;
    }
    if let Some(path) = job.picture {
        drawing::check(path)?;
    }
    let mut timings = Timings::default();
    let source = Timings::measure(&mut timings.read, || image_or_grid::read(job.input))?;
    report.timings = timings;
    report.add_input(source.input(job.input));
    let is_volume = matches!(&source, Source::Grid(grid) if grid.counts.len() == 3);
    let found =
        if is_volume { volume::run(job, &source, report)? } else { plane::run(job, &source, report)? };
    let is_settled = found.evolution.as_ref().is_none_or(|evolution| evolution.settled);
    if !is_settled {
        report.warnings.push(format!(
            "{}: the contour still moves; smooth more (--smooth, --length-weight), or start nearer (--start)",
            job.input.display()
        ));
    }
    let is_within = found.within_tolerance;
    if !is_within {
        report.warnings.push(format!(
            "{}: not all contours are within the tolerance of {}; allow more (--tolerance), or smooth more (--smooth)",
            job.input.display(),
            found.tolerance
        ));
    }
    report.results = Some(Box::new(found));
    Ok(match (is_settled, is_within) {
        (false, _) => Some("not_converged"),
        (true, false) => Some("out_of_tolerance"),
        (true, true) => None,
    })
}
