//! What a registration is asked to do.

use crate::input::cad::Choice;
use industrial_geometry::io::Format;
use industrial_geometry::mesh::nalgebra::Vector3;
use industrial_geometry::register::RegisterOptions;
use std::path::Path;

/// Where the registration of a scan, or of many views, starts.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Start<'a> {
    /// Where the points are.
    Given,
    /// Where the points are, and a search over all positions if that is not good.
    Auto,
    /// The best of a search over all positions.
    Global,
    /// The poses of a file: starts to be tried, or one per view.
    Poses(&'a Path),
}

/// Files and options of a registration.
#[derive(Debug)]
pub(crate) struct Job<'a> {
    /// File of the model.
    pub(crate) model: &'a Path,
    /// What is chosen of a CAD model.
    pub(crate) cad: &'a Choice,
    /// File of the points.
    pub(crate) points: &'a Path,
    /// Most points that are used, if nothing is written per point.
    pub(crate) sample: u32,
    /// File of the moved points.
    pub(crate) out: Option<&'a Path>,
    /// Their format, if not that of the extension.
    pub(crate) format: Option<Format>,
    /// File of the motion.
    pub(crate) transform: Option<&'a Path>,
    /// File of the page.
    pub(crate) page: Option<&'a Path>,
    /// Where to start.
    pub(crate) start: Start<'a>,
    /// Options of the library.
    pub(crate) options: RegisterOptions<3>,
    /// Length of unit normals with which points are matched to the model from a start, before they are registered.
    pub(crate) feature_weight: Option<f64>,
    /// Largest angle, in radians, between the normals of points and feet that count.
    pub(crate) max_angle: Option<f64>,
    /// Whether the method makes no sense without normals of the points.
    pub(crate) needs_normals: bool,
    /// Suppress progress output.
    pub(crate) quiet: bool,
}

/// The points as they are registered.
pub(crate) struct Cloud<'a> {
    pub(crate) positions: Vec<Vector3<f64>>,
    pub(crate) normals: Option<&'a [Vector3<f64>]>,
    /// 0 for points that do not count because they have no normal; `None` where all count.
    pub(crate) weights: Option<Vec<f64>>,
}
