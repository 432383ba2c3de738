//! Surfaces within given boundary curves, and surfaces that continue others.

use crate::error::Error;
use crate::fits::boundary::{Boundary, ContinuityChoice, neighbours};
use crate::report::{Report, Timings};
use industrial_geometry::footpoint::SurfaceProjector;
use industrial_geometry::nurbs::construct::{Continuity, Side, joined};
use industrial_geometry::nurbs::nalgebra::Vector3;
use industrial_geometry::nurbs::{BsplineCurve, BsplineSurface, ParametricCurve, ParametricSurface};
use serde::Serialize;
use std::path::{Path, PathBuf};

/// Samples of an edge.
const SAMPLES: usize = 201;
/// What counts as met: gap as a share of the size, and angle in radians.
const GAP: f64 = 1e-6;
const ANGLE: f64 = 1e-5;

/// What is asked of the sides of a surface.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Edges<'a> {
    /// File of the boundary curves.
    pub(crate) boundary: Option<&'a Path>,
    /// Files of neighbours.
    pub(crate) join: &'a [PathBuf],
    pub(crate) continuity: ContinuityChoice,
}

/// What was read.
#[derive(Default)]
pub(crate) struct Given {
    pub(crate) boundary: Option<Boundary>,
    neighbours: Vec<BsplineSurface>,
    /// The file of each.
    files: Vec<PathBuf>,
}

impl Given {
    pub(crate) fn is_empty(&self) -> bool {
        self.boundary.is_none() && self.neighbours.is_empty()
    }
}

/// A side that continues a neighbour.
#[derive(Debug, Serialize)]
pub(crate) struct Join {
    /// The file of the neighbour.
    pub(crate) file: PathBuf,
    /// The side of the surface, and that of the neighbour.
    pub(crate) side: Side,
    pub(crate) of_neighbour: Side,
    /// Largest distance of the edge from the surface.
    pub(crate) gap: f64,
    /// Largest angle between the tangent planes along it, in radians.
    pub(crate) angle: f64,
}

/// What became of the sides.
#[derive(Debug, Serialize)]
pub(crate) struct EdgeResults {
    /// Largest distance of the boundary curves from the surface.
    pub(crate) boundary_gap: Option<f64>,
    pub(crate) joins: Vec<Join>,
}

impl Edges<'_> {
    /// The files that are read.
    pub(crate) fn inputs(&self) -> impl Iterator<Item = &Path> {
        self.boundary.into_iter().chain(self.join.iter().map(PathBuf::as_path))
    }

    pub(crate) fn read(&self, report: &mut Report) -> Result<Given, Error> {
        let boundary = self.boundary.map(|path| Boundary::read(path, report)).transpose()?;
        let mut given = Given { boundary, ..Given::default() };
        for path in self.join {
            let found = neighbours(path, report)?;
            given.files.extend(found.iter().map(|_| path.clone()));
            given.neighbours.extend(found);
        }
        Ok(given)
    }

    /// The surface with its sides where they are to be, and how many rows of control points of each ([`Side::ALL`]) must stay.
    pub(crate) fn imposed(
        &self,
        given: &Given,
        surface: BsplineSurface,
        report: &mut Report,
    ) -> Result<Imposed, Error> {
        let held = [usize::from(given.boundary.is_some()); 4];
        let continuity = match self.continuity {
            ContinuityChoice::G0 => Continuity::Position,
            ContinuityChoice::G1 => Continuity::TangentPlane,
        };
        let made = Timings::measure(&mut report.timings.build, || {
            joined(surface, held, &given.neighbours, continuity)
        });
        let about = given.files.first().map_or_else(PathBuf::new, Clone::clone);
        let made = made.map_err(|error| {
            Error::content(
                &about,
                error.to_string(),
                "give a start (--init) whose sides are near the edges, or --continuity g0",
            )
        })?;
        Ok(Imposed { surface: made.surface, held: made.held, sides: made.sides })
    }

    /// How well the sides are met; whether not well enough is said.
    pub(crate) fn measured(
        &self,
        given: &Given,
        imposed: &Imposed,
        surface: &BsplineSurface,
        report: &mut Report,
    ) -> (EdgeResults, bool) {
        let projector = SurfaceProjector::new(surface);
        let size = surface.control_box().diagonal();
        let gap = |curve: &BsplineCurve<3>| {
            let at = |k: usize| curve.point(curve.domain().lerp(k as f64 / (SAMPLES - 1) as f64));
            let places: Vec<Vector3<f64>> = (0..SAMPLES).map(at).collect();
            projector.project_all(&places).iter().map(|foot| foot.signed_distance.abs()).fold(0.0, f64::max)
        };
        let boundary_gap = given.boundary.as_ref().map(|boundary| {
            boundary.curves.along_u.iter().chain(&boundary.curves.along_v).map(gap).fold(0.0, f64::max)
        });
        let mut joins = Vec::new();
        for ((neighbour, file), &[side, of_neighbour]) in
            given.neighbours.iter().zip(&given.files).zip(&imposed.sides)
        {
            let (mut gap, mut angle) = (0.0f64, 0.0f64);
            let [u, v] = neighbour.domain();
            for k in 0..SAMPLES {
                let t = k as f64 / (SAMPLES - 1) as f64;
                let end = f64::from(u8::from(of_neighbour.is_end()));
                let (u, v) = match of_neighbour {
                    Side::UStart | Side::UEnd => (u.lerp(end), v.lerp(t)),
                    Side::VStart | Side::VEnd => (u.lerp(t), v.lerp(end)),
                };
                let jet = neighbour.jet(u, v);
                let foot = projector.project(&jet.point);
                let own = surface.jet(foot.parameter[0], foot.parameter[1]).normal_direction();
                let other = jet.normal_direction();
                gap = gap.max((foot.point - jet.point).norm());
                angle = angle.max(own.cross(&other).norm().atan2(own.dot(&other).abs()));
            }
            joins.push(Join { file: file.clone(), side, of_neighbour, gap, angle });
        }
        let asks_planes = self.continuity == ContinuityChoice::G1;
        let is_open = |gap: f64| gap.is_nan() || gap > GAP * size;
        let mut unmet = false;
        if let Some(gap) = boundary_gap.filter(|gap| is_open(*gap)) {
            report.warnings.push(format!("the surface is up to {gap:.3e} from its boundary curves"));
            unmet = true;
        }
        for join in &joins {
            if is_open(join.gap) || asks_planes && (join.angle.is_nan() || join.angle > ANGLE) {
                report.warnings.push(format!(
                    "{}: the surface is up to {:.3e} from the edge, and its tangent planes differ by up to {:.3e} radians",
                    join.file.display(),
                    join.gap,
                    join.angle
                ));
                unmet = true;
            }
        }
        (EdgeResults { boundary_gap, joins }, unmet)
    }
}

/// A surface with its sides where they are to be.
pub(crate) struct Imposed {
    pub(crate) surface: BsplineSurface,
    pub(crate) held: [usize; 4],
    sides: Vec<[Side; 2]>,
}
