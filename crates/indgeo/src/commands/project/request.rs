//! What a projection is asked to do.

use super::search::SearchMode;
use crate::input::cad::Choice;
use crate::output::Format;
use industrial_geometry::footpoint::ProjectionOptions;
use std::path::Path;

/// Files and options of a projection.
#[derive(Debug)]
pub(crate) struct Job<'a> {
    /// File of the model.
    pub(crate) model: &'a Path,
    /// What is chosen of a CAD model.
    pub(crate) cad: &'a Choice,
    /// File of the points.
    pub(crate) points: &'a Path,
    /// File of the result.
    pub(crate) out: &'a Path,
    /// Its format, if not that of the extension.
    pub(crate) format: Option<Format>,
    /// Options of the library.
    pub(crate) options: ProjectionOptions,
    /// Largest angle, in radians, between the normals of points and feet.
    pub(crate) max_angle: Option<f64>,
    /// The mode, by its name on the command line.
    pub(crate) mode: SearchMode,
    /// Whether points that are not finite are left out.
    pub(crate) drop_non_finite: bool,
    /// The scan that is read of a file of several.
    pub(crate) scan: Option<&'a str>,
    /// Number of threads asked for.
    pub(crate) threads: Option<u16>,
    /// Suppress progress output.
    pub(crate) quiet: bool,
}
