//! Bounded projection onto surfaces.

use super::axis::{Axis, Cell, Side};
use super::escape::{ESCAPE_TRIALS, is_lower};
use super::line_search::largest_distance;
use super::location::surface_location;
use super::pole;
use super::step::{CurveResidual, PrincipalTangents, Tangent, first_order_surface};
use super::surface_state::Here;
use super::{LocalOptions, Start};
use crate::{Location, Multiplicity, Status, SurfaceFootpoint};
use nalgebra::Vector3;
use nurbs_core::{Interval, ParametricSurface};

/// Halvings of a step tried before its direction is given up.
const MAX_TRIALS: usize = 60;

/// Share of the domain by which a pole is left to find out on which side of the surface a point lies.
const SIDE_STEP: f64 = 1e-4;

/// A footpoint of `x` on the surface, reached from `start` (parameters `[u, v]`, or a [`Start`]).
///
/// The iteration stays in the domain by an active set: where a bound is active and the step points
/// outwards it continues along that edge with the step for curves, and leaves the edge when the distance
/// decreases inwards. Closed directions wrap; kinks stop a step and are crossed when the distance decreases
/// behind; poles count as points with many directions; maxima and saddles of the distance are left. It is
/// local: from a poor start it may end at a footpoint that is not the nearest. Statuses as for
/// [`project_curve`](super::project_curve).
///
/// ```
/// use footpoint::{Location, local::{LocalOptions, project_surface}};
/// use nurbs_core::{BsplineSurface, Interval, KnotVector, nalgebra::Vector3};
///
/// let knots = KnotVector::bezier(1, Interval::UNIT)?;
/// let net = [[0.0, 0.0], [0.0, 1.0], [1.0, 0.0], [1.0, 1.0]].map(|[x, y]| Vector3::new(x, y, 0.0));
/// let square = BsplineSurface::new(knots.clone(), knots, net.to_vec(), None)?;
/// let foot = project_surface(&square, &Vector3::new(3.0, 0.25, 1.0), [0.5, 0.5], &LocalOptions::default());
/// assert_eq!((foot.parameter, foot.location), ([1.0, 0.25], Location::Edge));
/// # Ok::<(), nurbs_core::Error>(())
/// ```
pub fn project_surface<S: ParametricSurface + ?Sized>(
    surface: &S,
    x: &Vector3<f64>,
    start: impl Into<Start<[f64; 2]>>,
    options: &LocalOptions,
) -> SurfaceFootpoint {
    project_on_axes(surface, &Axis::of_surface(surface), x, start.into(), options)
}

/// [`project_surface`] when the axes of the surface are known already.
pub(crate) fn project_on_axes<S: ParametricSurface + ?Sized>(
    surface: &S,
    axes: &[Axis; 2],
    x: &Vector3<f64>,
    start: Start<[f64; 2]>,
    options: &LocalOptions,
) -> SurfaceFootpoint {
    let problem = Problem { surface, axes, x, options };
    if !x.iter().all(|c| c.is_finite()) {
        return problem.report(&axes.each_ref().map(|a| a.domain.start()), Status::InvalidPoint, 0);
    }
    let start = start.on_surface(surface, x);
    let [(cell_u, u), (cell_v, v)] = [0, 1].map(|k| axes[k].cell(start[k], Side::Above));
    problem.run(problem.evaluate([cell_u, cell_v], [u, v]))
}

struct Problem<'a, S: ?Sized> {
    surface: &'a S,
    axes: &'a [Axis; 2],
    x: &'a Vector3<f64>,
    options: &'a LocalOptions,
}

impl<S: ParametricSurface + ?Sized> Problem<'_, S> {
    fn evaluate(&self, cells: [Cell; 2], at: [f64; 2]) -> Here {
        Here::new(self.surface, self.axes, self.x, cells, at)
    }

    fn accepts(&self, here: &Here, violation: f64) -> bool {
        self.options.accepts(violation, here.distance, here.noise)
    }

    fn run(&self, start: Here) -> SurfaceFootpoint {
        let mut here = start;
        let mut iterations = 0;
        // Set when the last step was negligible or none was possible: judge, and go on only elsewhere.
        let mut settled = false;
        loop {
            if !here.distance.is_finite() {
                return self.report(&here.at, Status::Diverged, iterations);
            }
            let violation = here.violation();
            settled |= self.options.angle_stops(violation, here.distance);
            let exhausted = iterations >= self.options.max_iterations;
            if violation <= here.noise || settled || exhausted {
                let verdict = if exhausted { Status::MaxIterations } else { Status::Stalled };
                if !self.accepts(&here, violation) {
                    return self.report(&here.at, verdict, iterations);
                }
                match self.leave(&here) {
                    None => return self.report(&here.at, Status::Converged, iterations),
                    Some(_) if exhausted => return self.report(&here.at, verdict, iterations),
                    Some(next) => {
                        here = next;
                        iterations += 1;
                        settled = false;
                        continue;
                    }
                }
            }
            iterations += 1;
            match self.advance(&here) {
                None => settled = true,
                Some(next) => {
                    // A step cut short by a bound says nothing about the other parameter.
                    settled = (0..2).all(|k| {
                        let tolerance = self.options.parameter_tolerance * self.axes[k].domain.length();
                        (next.at[k] - here.at[k]).abs() <= tolerance && next.at_end(k) == here.at_end(k)
                    });
                    here = next;
                }
            }
        }
    }

    /// One safeguarded step inside the cell.
    fn advance(&self, here: &Here) -> Option<Here> {
        let free = [0, 1].map(|k| !here.dead[k] && !here.blocked(k));
        let delta = match free {
            [true, true] => self.free_step(here)?,
            [true, false] => self.line_step(here, 0)?,
            [false, true] => self.line_step(here, 1)?,
            [false, false] => return None,
        };
        self.search(here, delta)
    }

    /// The step with both parameters free, reduced to one where it would leave the cell at once.
    fn free_step(&self, here: &Here) -> Option<[f64; 2]> {
        // False for NaN too.
        let downhill = |d: &[f64; 2]| here.residual.dot(&(here.jet.du * d[0] + here.jet.dv * d[1])) > 0.0;
        let step = self.options.method.surface_step(&here.jet, self.x).filter(downhill);
        let step = step.or_else(|| first_order_surface(&here.jet, self.x).filter(downhill));
        let violations = [0, 1].map(|k| here.violation_along(k));
        let Some(step) = step else {
            return self.line_step(here, if violations[0] >= violations[1] { 0 } else { 1 });
        };
        for k in 0..2 {
            let [low, high] = here.cells[k].at(here.at[k]);
            if (low && step[k] < 0.0) || (high && step[k] > 0.0) {
                // Along the edge, or, if that is done, away from it.
                let along = if violations[1 - k] > here.noise { 1 - k } else { k };
                return self.line_step(here, along);
            }
        }
        Some(step)
    }

    /// The curve step of parameter `k` alone.
    fn line_step(&self, here: &Here, k: usize) -> Option<[f64; 2]> {
        let mut delta = [0.0; 2];
        delta[k] = self.options.method.descending_curve_step(&here.line(k), self.x)?;
        Some(delta)
    }

    /// The longest acceptable step: clamped to the cell; else along the ray, first to the nearest bound,
    /// then to the first jump of a second derivative, then halved.
    fn search(&self, here: &Here, delta: [f64; 2]) -> Option<Here> {
        let slope = |d: [f64; 2]| here.residual.dot(&(here.jet.du * d[0] + here.jet.dv * d[1]));
        let half_turns =
            self.axes.each_ref().map(|a| if a.wraps { 0.5 * a.domain.length() } else { f64::INFINITY });
        let mut shorter = [0, 1].map(|k| delta[k].clamp(-half_turns[k], half_turns[k]));
        if shorter != delta && slope(shorter) <= 0.0 {
            // Next to a pole nearly all of a step may be a turn: what is left without it can lead uphill.
            let share = (0..2).map(|k| shorter[k] / delta[k]).filter(|s| *s < 1.0).fold(1.0, f64::min);
            shorter = delta.map(|d| d * share);
        }
        let delta = shorter;
        let accepts = |next: &Here| {
            let promise = slope([0, 1].map(|k| next.at[k] - here.at[k]));
            next.distance <= largest_distance(here.distance, promise, here.noise)
        };
        let clamped = [0, 1].map(|k| here.cells[k].clamp(here.at[k] + delta[k]));
        if clamped == here.at {
            return None;
        }
        let first = self.evaluate(here.cells, clamped);
        if accepts(&first) {
            return Some(first);
        }
        let fraction = |k: usize, to: f64| (to - here.at[k]) / delta[k];
        let mut share: f64 = 1.0;
        for k in 0..2 {
            if clamped[k] != here.at[k] + delta[k] {
                share = share.min(fraction(k, clamped[k]));
            }
        }
        let mut cut = (0..2)
            .filter_map(|k| Some(fraction(k, self.axes[k].curvature_break_between(here.at[k], clamped[k])?)))
            .filter(|s| *s > 1e-3)
            .reduce(f64::min);
        if share == 1.0 {
            share = cut.take().unwrap_or(0.5);
        }
        for _ in 0..MAX_TRIALS {
            let at = [0, 1].map(|k| here.cells[k].clamp(here.at[k] + share * delta[k]));
            if at == here.at {
                return None;
            }
            let next = self.evaluate(here.cells, at);
            if accepts(&next) {
                return Some(next);
            }
            share = cut.take().filter(|&s| s < share).unwrap_or(0.5 * share);
        }
        None
    }

    /// A better point than one that is optimal inside its cell: behind a kink, out of a pole, or beside a
    /// maximum or saddle.
    fn leave(&self, here: &Here) -> Option<Here> {
        if let Some(other) = self.neighbour(here) {
            return Some(other);
        }
        let dead = (0..2).find(|&k| here.dead[k] && !here.dead[1 - k]);
        if let Some(pole) = dead.and_then(|k| pole::survey(self.surface, self.axes, self.x, here, k)) {
            return (!self.accepts(here, pole.slope)).then_some(pole.steepest);
        }
        let lower = |d: &[f64; 2]| {
            (0..ESCAPE_TRIALS).find_map(|i| {
                let share = 0.5_f64.powi(i);
                let trials = [share, -share].map(|s| {
                    let at = [0, 1].map(|k| here.cells[k].clamp(here.at[k] + s * d[k]));
                    self.evaluate(here.cells, at)
                });
                let [a, b] = trials;
                let best = if a.distance <= b.distance { a } else { b };
                is_lower(best.distance, here.distance, here.noise).then_some(best)
            })
        };
        self.ascent_directions(here).iter().find_map(lower)
    }

    /// The same point in another cell in which the distance decreases.
    fn neighbour(&self, here: &Here) -> Option<Here> {
        let options = [0, 1].map(|k| {
            let [low, high] = here.cells[k].at(here.at[k]);
            let side = match here.cells[k].open {
                [true, _] if low => Side::Below,
                [_, true] if high => Side::Above,
                _ => return [Some((here.cells[k], here.at[k])), None],
            };
            [Some((here.cells[k], here.at[k])), Some(self.axes[k].cell(here.at[k], side))]
        });
        for (i, j) in [(1, 0), (0, 1), (1, 1)] {
            if let (Some((cell_u, u)), Some((cell_v, v))) = (options[0][i], options[1][j]) {
                let other = self.evaluate([cell_u, cell_v], [u, v]);
                if !self.accepts(&other, other.violation()) {
                    return Some(other);
                }
            }
        }
        None
    }

    /// Increments in whose direction the distance may have a maximum at a stationary point.
    fn ascent_directions(&self, here: &Here) -> Vec<[f64; 2]> {
        let lengths = self.axes.each_ref().map(|a| 0.25 * a.domain.length());
        if here.dead[0] || here.dead[1] {
            let mut directions = vec![[lengths[0], lengths[1]], [lengths[0], -lengths[1]]];
            directions.extend([[lengths[0], 0.0], [0.0, lengths[1]]]);
            return directions;
        }
        let beyond_centre = |offset: f64| offset > 1.0 + 1e-9;
        match here.tangent {
            Tangent::Plane(plane) if !here.at_end(0) && !here.at_end(1) => {
                let principal = PrincipalTangents::new(&plane, &here.jet);
                let normal = here.residual.dot(&plane.normal);
                (0..2)
                    .filter(|&i| beyond_centre(principal.curvatures[i] * normal))
                    .map(|i| principal.increments[i].map(|d| d / principal.curvatures[i].abs()))
                    .collect()
            }
            _ => (0..2)
                .filter(|&k| !here.at_end(k))
                .filter_map(|k| {
                    let r = CurveResidual::new(&here.line(k), self.x).filter(|r| beyond_centre(r.offset))?;
                    let mut direction = [0.0; 2];
                    direction[k] = 1.0 / (r.curvature * r.speed);
                    Some(direction)
                })
                .collect(),
        }
    }

    /// The footpoint at cell parameters; `Converged` becomes `OnBoundary` where the domain ends.
    fn report(&self, at: &[f64; 2], status: Status, iterations: u32) -> SurfaceFootpoint {
        let parameter = [0, 1].map(|k| self.axes[k].normalize(at[k]));
        let [(cell_u, u), (cell_v, v)] = [0, 1].map(|k| self.axes[k].cell(parameter[k], Side::Above));
        let here = self.evaluate([cell_u, cell_v], [u, v]);
        let point = self.surface.point(parameter[0], parameter[1]);
        let mut location = surface_location(self.axes, parameter);
        let mut on_boundary = matches!(location, Location::Edge | Location::Corner);
        let dead = (0..2).find(|&k| here.dead[k] && !here.dead[1 - k]);
        if let Some(pole) = dead.and_then(|k| pole::survey(self.surface, self.axes, self.x, &here, k)) {
            location = Location::Pole;
            // Flat in all directions: the pole is an inner point like any other.
            on_boundary = !self.accepts(&here, -pole.least_slope);
        }
        let distance = (self.x - point).norm();
        SurfaceFootpoint {
            shape: 0,
            parameter,
            point,
            distance,
            signed_distance: distance.copysign(self.side(parameter, point)),
            status: if status == Status::Converged && on_boundary { Status::OnBoundary } else { status },
            location,
            multiplicity: Multiplicity::Unknown,
            lower_bound: 0.0,
            iterations,
        }
    }

    /// Positive on the side of `s_u × s_v`; at singular points that of the surface nearby.
    fn side(&self, [u, v]: [f64; 2], point: Vector3<f64>) -> f64 {
        let normal_at = |u: f64, v: f64| match super::step::surface_tangent(&self.surface.jet(u, v)) {
            Tangent::Plane(plane) => Some(plane.normal),
            _ => None,
        };
        let inwards = |domain: Interval, t: f64| t + SIDE_STEP * (domain.midpoint() - t);
        let domains = self.axes.each_ref().map(|a| a.domain);
        let normal = normal_at(u, v).or_else(|| normal_at(inwards(domains[0], u), inwards(domains[1], v)));
        // `+ 0.0` turns −0 into 0: in the tangent plane counts as outside.
        normal.map_or(1.0, |n| (self.x - point).dot(&n) + 0.0)
    }
}
