//! The bolt in the scan: cylinder coordinates about its axis.

use crate::commands::project::job::Projected;
use crate::error::Error;
use crate::input::target::Foot;
use industrial_geometry::footpoint::Status;
use industrial_geometry::inspection::Statistics;
use industrial_geometry::mesh::nalgebra::{Point3, Vector3};
use serde::Deserialize;
use std::f64::consts::TAU;
use std::path::Path;

/// Where the bolt lies, as the generator of the model wrote it. Lengths in mm.
#[derive(Debug, Deserialize)]
pub(crate) struct Bolt {
    origin: [f64; 3],
    axis: [f64; 3],
    reference: [f64; 3],
    /// Distance of two crests along the axis.
    pub(crate) pitch: f64,
    /// Rise of the helix in one turn, negative for a left-handed thread.
    turn: f64,
    phase: f64,
    /// Corners of the nominal profile over one pitch, from root to root: position relative to the crest, and radius.
    pub(crate) profile: [[f64; 2]; 6],
}

/// Cylinder coordinates of a point.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Cylindrical {
    /// Distance from the axis.
    pub(crate) radius: f64,
    /// Angle in turns, 0 to 1.
    pub(crate) angle: f64,
    /// Position along the axis.
    pub(crate) height: f64,
}

/// Distances in parts of the thread.
#[derive(Debug)]
pub(crate) struct Zones {
    /// Everything that projects into the interior of the model.
    pub(crate) inside: Statistics,
    /// Points on the crests.
    pub(crate) crests: Statistics,
    /// Points on the flanks.
    pub(crate) flanks: Statistics,
    /// Points in the roots.
    pub(crate) roots: Statistics,
    /// Points of the scan beyond the model, whose footpoints lie on its boundary.
    pub(crate) beyond: usize,
}

/// Index of the thread in the model.
const THREAD: u32 = 0;

impl Bolt {
    /// Reads the placement.
    pub(crate) fn read(path: &Path) -> Result<Self, Error> {
        let text = std::fs::read(path).map_err(|source| Error::File {
            source: industrial_geometry::io::Error::Io { path: path.to_path_buf(), action: "read", source },
        })?;
        serde_json::from_slice(&text)
            .map_err(|error| Error::content(path, error.to_string(), "take the file from the repository"))
    }

    /// Coordinates along the axis and along two directions across it.
    pub(crate) fn local(&self, point: &Point3<f64>) -> [f64; 3] {
        let (axis, e1) = (Vector3::from(self.axis), Vector3::from(self.reference));
        let d = point.coords - Vector3::from(self.origin);
        [d.dot(&axis), d.dot(&e1), d.dot(&axis.cross(&e1))]
    }

    /// Cylinder coordinates.
    pub(crate) fn cylindrical(&self, point: &Point3<f64>) -> Cylindrical {
        let [height, x, y] = self.local(point);
        Cylindrical { radius: x.hypot(y), angle: (y.atan2(x) / TAU).rem_euclid(1.0), height }
    }

    /// Position within the pitch, from −½ to ½ pitch with a crest at 0.
    pub(crate) fn position(&self, at: &Cylindrical) -> f64 {
        let position = (at.height - self.phase - self.turn * at.angle) / self.pitch;
        (position - position.round()) * self.pitch
    }

    /// Statistics by part of the thread; `None` when a part has no points.
    pub(crate) fn zones(&self, projected: &Projected) -> Option<Zones> {
        let [_, _, _, [end_of_crest, _], [start_of_root, _], _] = self.profile;
        let at = |index: usize| self.position(&self.cylindrical(&projected.points.positions[index])).abs();
        let feet = || projected.feet.iter().enumerate().filter(|(_, foot)| is_inside(foot));
        let part = |low: f64, high: f64| {
            let on_thread = feet().filter(|(_, foot)| foot.shape == THREAD);
            let here = on_thread.filter(move |&(index, _)| (low..high).contains(&at(index)));
            Statistics::of(here.map(|(_, foot)| foot.distance))
        };
        Some(Zones {
            inside: Statistics::of(feet().map(|(_, foot)| foot.distance))?,
            crests: part(0.0, end_of_crest)?,
            flanks: part(end_of_crest, start_of_root)?,
            roots: part(start_of_root, self.pitch)?,
            beyond: projected.feet.iter().filter(|foot| foot.exists() && !is_inside(foot)).count(),
        })
    }
}

/// Whether the point lies over the interior of the model, so that its distance is a deviation.
pub(crate) fn is_inside(foot: &Foot) -> bool {
    foot.exists() && foot.status == Status::Converged
}

/// Whether the point lies over the thread.
pub(crate) fn is_on_thread(foot: &Foot) -> bool {
    is_inside(foot) && foot.shape == THREAD
}
