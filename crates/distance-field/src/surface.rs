//! The distance from B-spline and NURBS surfaces.

use crate::borders::{Borders, line};
use crate::{DistanceField, Error, Hint, PrincipalFrame, Search, parallel};
use footpoint::local::{newton_curve, newton_surface};
use footpoint::{
    Location, Multiplicity, ProjectionOptions, Status, SurfaceFootpoint, SurfaceProjector, no_progress,
};
use nalgebra::Vector3;
use nurbs_core::{Aabb, BsplineSurface, ParametricSurface, SurfaceJet};

/// Queries whose derivatives are evaluated together.
const CHUNK: usize = 4096;
/// Sine of the angle between residual and normal up to which a foot counts as found, and the same as a share of the
/// size where there is no residual.
const ORTHOGONAL: (f64, f64) = (1e-6, 1e-11);

/// The distance from one or several B-spline or NURBS surfaces, signed by the normal `s_u × s_v` of the nearest.
///
/// Footpoints are exact and, in a global search, certified. Inside a surface the frame is the principal frame; where an
/// open surface ends, its boundary curves and corners take the place of the tangent plane, and so do kinks.
///
/// ```
/// use distance_field::{DistanceField, ErrorTerm, Hint, Search, SurfaceField};
/// use nalgebra::Vector3;
/// use nurbs_core::{Frame, Sphere};
///
/// let sphere = Sphere::new(Frame::WORLD, 2.0)?.to_nurbs()?;
/// let field = SurfaceField::new(&sphere)?;
/// let frame = field.frame(&Vector3::new(0.0, 1.0, 0.0), Search::Global, &Hint::NONE);
/// assert!((frame.distance + 1.0).abs() < 1e-12 && (frame.curvatures[0] + 0.5).abs() < 1e-9);
/// // Half way to the centre of curvature the squared distance falls along the sphere as fast as it grows.
/// assert!((ErrorTerm::Taylor.model(&frame).weights[0] + 1.0).abs() < 1e-9);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct SurfaceField {
    projector: SurfaceProjector,
    /// Relative to `centre`, so that derivatives do not drown in large coordinates.
    surfaces: Vec<BsplineSurface>,
    borders: Vec<Borders>,
    centre: Vector3<f64>,
    size: f64,
    bounds: Aabb<3>,
    options: ProjectionOptions,
}

/// Where a query has its foot, before the frame is known.
#[derive(Clone, Copy, Debug)]
struct Place {
    shape: usize,
    parameter: [f64; 2],
    status: Status,
}

impl SurfaceField {
    /// The distance from one surface.
    ///
    /// # Errors
    /// [`Error::Shape`] when the coordinates are too large to compute with.
    pub fn new(surface: &BsplineSurface) -> Result<Self, Error> {
        Self::for_model(std::slice::from_ref(surface))
    }

    /// The distance from the nearest of several surfaces.
    ///
    /// # Errors
    /// [`Error::Footpoint`] when there are none; [`Error::Shape`] when coordinates are too large to compute with.
    pub fn for_model(surfaces: &[BsplineSurface]) -> Result<Self, Error> {
        let projector = SurfaceProjector::for_model(surfaces)?;
        let boxes = surfaces.iter().map(|s| s.bounding_box(1e-3));
        let bounds = boxes.reduce(|a, b| a.merged(&b)).unwrap_or_else(|| Aabb::of_point(Vector3::zeros()));
        let centre = bounds.centre();
        let local: Vec<BsplineSurface> =
            surfaces.iter().map(|s| s.translated(&-centre)).collect::<Result<_, _>>()?;
        let size = 0.5 * bounds.sides().amax();
        let borders = local.iter().map(|s| Borders::new(s, size)).collect();
        let options = ProjectionOptions::default();
        Ok(Self { projector, surfaces: local, borders, centre, size, bounds, options })
    }

    /// The same field with other options for global searches.
    ///
    /// # Errors
    /// [`Error::Footpoint`] when an option is invalid.
    pub fn with_projection(self, options: ProjectionOptions) -> Result<Self, Error> {
        options.validate()?;
        Ok(Self { options, ..self })
    }

    /// The projector that finds the feet.
    #[must_use]
    pub fn projector(&self) -> &SurfaceProjector {
        &self.projector
    }

    /// Number of surfaces.
    #[must_use]
    pub fn surface_count(&self) -> usize {
        self.surfaces.len()
    }

    /// The place of a foot of the projector; `None` where there is nothing to evaluate.
    fn place(foot: &SurfaceFootpoint) -> Place {
        Place { shape: foot.shape, parameter: foot.parameter, status: foot.status }
    }

    fn jet(&self, place: &Place) -> SurfaceJet {
        self.surfaces[place.shape].jet(place.parameter[0], place.parameter[1])
    }

    /// The frame at a place from its jet; `x` relative to the centre.
    #[inline]
    fn frame_at(&self, place: &Place, jet: &SurfaceJet, x: &Vector3<f64>) -> PrincipalFrame<3> {
        let residual = x - jet.point;
        if !residual.iter().all(|c| c.is_finite()) {
            return PrincipalFrame::invalid(failure(place.status));
        }
        let (geometry, on_boundary) =
            self.borders[place.shape].geometry(&self.surfaces[place.shape], place.parameter, jet, &residual);
        PrincipalFrame {
            foot: jet.point + self.centre,
            axes: geometry.axes,
            curvatures: geometry.curvatures,
            tangent_dimension: geometry.tangent_dimension,
            distance: geometry.distance,
            on_boundary,
            hint: Hint::new(place.shape, place.parameter),
            status: place.status,
        }
    }

    /// The place to which one step of Newton's method leads, within the domain.
    #[inline]
    fn step(&self, place: &Place, jet: &SurfaceJet, x: &Vector3<f64>) -> Place {
        let borders = &self.borders[place.shape];
        let mut step = newton_surface(jet, x).unwrap_or([0.0; 2]);
        for k in 0..2 {
            if borders.blocks(k, place.parameter[k], step[k]) {
                let along = newton_curve(&line(jet, 1 - k), x).unwrap_or(0.0);
                step[k] = 0.0;
                step[1 - k] = if borders.blocks(1 - k, place.parameter[1 - k], along) { 0.0 } else { along };
                break;
            }
        }
        Place { parameter: [0, 1].map(|k| borders.moved(k, place.parameter[k], step[k])), ..*place }
    }

    /// Judges a place reached by one step from `before`: its status, or `None` when it is no improvement.
    #[inline]
    fn judge(
        &self,
        before: &SurfaceJet,
        after: &SurfaceJet,
        frame: &PrincipalFrame<3>,
        x: &Vector3<f64>,
    ) -> Option<Status> {
        let (old, residual) = (x - before.point, x - after.point);
        let noise = ORTHOGONAL.1 * self.size;
        // Not so either when a number is NaN.
        let nearer = residual.norm_squared() <= old.norm_squared() + noise * noise;
        if !nearer {
            return None;
        }
        let normal = frame.axes.column(2) * frame.distance;
        let tangential = (residual - normal).norm();
        Some(if tangential > ORTHOGONAL.0 * frame.distance.abs() + noise {
            Status::MaxIterations
        } else if frame.on_boundary {
            Status::OnBoundary
        } else {
            Status::Converged
        })
    }

    /// One step from the hint.
    fn one_step(&self, x: &Vector3<f64>, start: &Place) -> PrincipalFrame<3> {
        let before = self.jet(start);
        let place = self.step(start, &before, x);
        self.after_step(x, start, &before, &place, &self.jet(&place))
    }

    #[inline]
    fn after_step(
        &self,
        x: &Vector3<f64>,
        start: &Place,
        before: &SurfaceJet,
        place: &Place,
        after: &SurfaceJet,
    ) -> PrincipalFrame<3> {
        let mut frame = self.frame_at(place, after, x);
        if let Some(status) = self.judge(before, after, &frame, x) {
            frame.status = status;
            return frame;
        }
        let foot = self.projector.project_from(&(x + self.centre), start.shape, start.parameter);
        self.frame_of(&foot, x)
    }

    /// The frame at a foot of the projector; `x` relative to the centre.
    fn frame_of(&self, foot: &SurfaceFootpoint, x: &Vector3<f64>) -> PrincipalFrame<3> {
        let place = Self::place(foot);
        if !usable(&place) {
            return PrincipalFrame::invalid(failure(place.status));
        }
        self.frame_at(&place, &self.jet(&place), x)
    }

    /// Whether a hint can be a start.
    fn start(&self, hint: &Hint) -> Option<Place> {
        let shape = hint.element_below(self.surfaces.len())?;
        Some(Place { shape, parameter: hint.parameter, status: Status::MaxIterations })
    }

    /// The feet of all points by a global search.
    fn searched(&self, points: &[Vector3<f64>]) -> Vec<SurfaceFootpoint> {
        // No error is reached: the options were checked when they were set.
        self.projector
            .project_many(points, &self.options, &no_progress)
            .unwrap_or_else(|_| vec![previous(None); points.len()])
    }

    /// The feet of all points: from the hints that there are, the others by a global search.
    fn feet(&self, points: &[Vector3<f64>], hints: &[Hint]) -> Vec<SurfaceFootpoint> {
        if hints.is_empty() {
            return self.searched(points);
        }
        let previous: Vec<SurfaceFootpoint> =
            (0..points.len()).map(|i| previous(hints.get(i).and_then(|hint| self.start(hint)))).collect();
        let Ok(mut feet) = self.projector.update_many(points, &previous) else {
            return self.searched(points);
        };
        let missing: Vec<usize> = (0..points.len())
            .filter(|&i| !previous[i].parameter[0].is_finite() && points[i].iter().all(|c| c.is_finite()))
            .collect();
        if !missing.is_empty() {
            let left: Vec<Vector3<f64>> = missing.iter().map(|&i| points[i]).collect();
            let found = self.searched(&left);
            for (index, foot) in missing.into_iter().zip(found) {
                feet[index] = foot;
            }
        }
        feet
    }

    /// The jets at many places, with as few evaluations as there are.
    fn jets(&self, places: &[Place], jets: &mut Vec<SurfaceJet>) {
        let zero = Vector3::zeros();
        let empty = SurfaceJet { point: zero, du: zero, dv: zero, duu: zero, duv: zero, dvv: zero };
        jets.resize(places.len(), empty);
        if let [surface] = self.surfaces.as_slice() {
            let parameters: Vec<[f64; 2]> = places.iter().map(|p| p.parameter).collect();
            if surface.jets(&parameters, jets).is_ok() {
                return;
            }
        }
        for (place, jet) in places.iter().zip(jets) {
            *jet = self.jet(place);
        }
    }

    /// A place that can be evaluated whatever the foot is.
    fn evaluable(&self, place: Place) -> Place {
        if usable(&place) { place } else { Place { shape: 0, parameter: self.borders[0].centre(), ..place } }
    }

    fn frames_of(&self, points: &[Vector3<f64>], feet: &[SurfaceFootpoint]) -> Vec<PrincipalFrame<3>> {
        let mut out = vec![PrincipalFrame::invalid(Status::InvalidPoint); points.len()];
        parallel::fill(&mut out, CHUNK, |first, out| {
            let feet = &feet[first..first + out.len()];
            let places: Vec<Place> = feet.iter().map(|f| self.evaluable(Self::place(f))).collect();
            let mut jets = Vec::new();
            self.jets(&places, &mut jets);
            for (i, frame) in out.iter_mut().enumerate() {
                *frame = if usable(&Self::place(&feet[i])) {
                    self.frame_at(&places[i], &jets[i], &(points[first + i] - self.centre))
                } else {
                    PrincipalFrame::invalid(failure(feet[i].status))
                };
            }
        });
        out
    }

    fn frames_after_one_step(&self, points: &[Vector3<f64>], hints: &[Hint]) -> Vec<PrincipalFrame<3>> {
        let mut out = vec![PrincipalFrame::invalid(Status::InvalidPoint); points.len()];
        parallel::fill(&mut out, CHUNK, |first, out| {
            let starts: Vec<Option<Place>> =
                (0..out.len()).map(|i| hints.get(first + i).and_then(|hint| self.start(hint))).collect();
            let nowhere = Place { shape: usize::MAX, parameter: [0.0; 2], status: Status::InvalidPoint };
            let mut places: Vec<Place> =
                starts.iter().map(|start| self.evaluable(start.unwrap_or(nowhere))).collect();
            let (mut before, mut after) = (Vec::new(), Vec::new());
            self.jets(&places, &mut before);
            for (i, place) in places.iter_mut().enumerate() {
                let next = self.step(place, &before[i], &(points[first + i] - self.centre));
                if usable(&next) {
                    *place = next;
                }
            }
            self.jets(&places, &mut after);
            for (i, frame) in out.iter_mut().enumerate() {
                let x = points[first + i];
                *frame = match &starts[i] {
                    Some(start) => {
                        self.after_step(&(x - self.centre), start, &before[i], &places[i], &after[i])
                    }
                    None => self.frame(&x, Search::Global, &Hint::NONE),
                };
            }
        });
        out
    }
}

impl DistanceField<3> for SurfaceField {
    fn frame(&self, x: &Vector3<f64>, search: Search, hint: &Hint) -> PrincipalFrame<3> {
        let local = x - self.centre;
        let start =
            self.start(hint).filter(|_| search != Search::Global && local.iter().all(|c| c.is_finite()));
        match start {
            None => match self.projector.project_with(x, &self.options) {
                Ok(foot) => self.frame_of(&foot, &local),
                // Not reached: the options were checked when they were set.
                Err(_) => PrincipalFrame::invalid(Status::Diverged),
            },
            Some(start) if search == Search::OneStep => self.one_step(&local, &start),
            Some(start) => {
                self.frame_of(&self.projector.project_from(x, start.shape, start.parameter), &local)
            }
        }
    }

    fn frames(&self, points: &[Vector3<f64>], search: Search, hints: &[Hint]) -> Vec<PrincipalFrame<3>> {
        match search {
            Search::OneStep if !hints.is_empty() => self.frames_after_one_step(points, hints),
            Search::Global => self.frames_of(points, &self.feet(points, &[])),
            Search::Local | Search::OneStep => self.frames_of(points, &self.feet(points, hints)),
        }
    }

    fn bounding_box(&self) -> Aabb<3> {
        self.bounds
    }
}

/// Whether a surface can be evaluated at a place.
fn usable(place: &Place) -> bool {
    place.shape != usize::MAX && place.parameter.iter().all(|p| p.is_finite())
}

/// The status of a frame that could not be computed.
fn failure(status: Status) -> Status {
    if status.is_converged() { Status::Diverged } else { status }
}

/// A previous answer that a batch can start from; NaN for none.
fn previous(start: Option<Place>) -> SurfaceFootpoint {
    SurfaceFootpoint {
        shape: start.map_or(0, |s| s.shape),
        parameter: start.map_or([f64::NAN; 2], |s| s.parameter),
        point: Vector3::zeros(),
        distance: 0.0,
        signed_distance: 0.0,
        status: Status::MaxIterations,
        location: Location::Interior,
        multiplicity: Multiplicity::Unknown,
        lower_bound: 0.0,
        iterations: 0,
    }
}
