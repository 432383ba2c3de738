//! Bounded projection onto curves.

use super::axis::{Axis, Cell, Side};
use super::escape::{ESCAPE_TRIALS, is_lower};
use super::line_search::{largest_distance, search};
use super::location::curve_location;
use super::options::residual_noise;
use super::step::CurveResidual;
use super::{LocalOptions, Start};
use crate::{CurveFootpoint, Location, Multiplicity, Status};
use nalgebra::SVector;
use nurbs_core::{CurveJet, ParametricCurve};

/// Derivatives shorter than this share of the coordinates (over the whole domain) are rounding error.
pub(crate) const VANISHING: f64 = 1e-12;

/// A footpoint of `x` on the curve, reached from `start` (a parameter, or a [`Start`]).
///
/// The iteration stays in the domain (wrapping where the curve closes), stops at kinks and crosses them
/// when the distance decreases behind, shortens steps that would increase the distance, and leaves maxima
/// of the distance and points with `c' = 0`. It is local: from a poor start it may end at a footpoint that
/// is not the nearest. The status tells whether the optimality conditions hold:
///
/// - `Converged`: the residual is normal to the curve, or at a kink in the cone of normals;
/// - `OnBoundary`: an end of the curve, where the distance would decrease outside only;
/// - `Stalled`, `MaxIterations`, `Diverged` (the curve has a value that is not finite): not a footpoint;
/// - `InvalidPoint`: `x` is not finite.
///
/// ```
/// use footpoint::{Status, local::{LocalOptions, project_curve}};
/// use nurbs_core::{BsplineCurve, nalgebra::Vector2};
///
/// let points = vec![Vector2::new(0.0, 0.0), Vector2::new(1.0, 2.0), Vector2::new(2.0, 0.0)];
/// let parabola = BsplineCurve::bezier(points, None)?;
/// let foot = project_curve(&parabola, &Vector2::new(1.0, 3.0), 0.3, &LocalOptions::default());
/// assert_eq!(foot.status, Status::Converged);
/// assert!((foot.parameter - 0.5).abs() < 1e-12 && (foot.distance - 2.0).abs() < 1e-12);
/// # Ok::<(), nurbs_core::Error>(())
/// ```
pub fn project_curve<const D: usize, C: ParametricCurve<D> + ?Sized>(
    curve: &C,
    x: &SVector<f64, D>,
    start: impl Into<Start<f64>>,
    options: &LocalOptions,
) -> CurveFootpoint<D> {
    project_on_axis(curve, &Axis::of_curve(curve), x, start.into(), options)
}

/// [`project_curve`] when the axis of the curve is known already.
pub(crate) fn project_on_axis<const D: usize, C: ParametricCurve<D> + ?Sized>(
    curve: &C,
    axis: &Axis,
    x: &SVector<f64, D>,
    start: Start<f64>,
    options: &LocalOptions,
) -> CurveFootpoint<D> {
    let problem = Problem { curve, axis, x, options };
    if !x.iter().all(|c| c.is_finite()) {
        return problem.report(axis.domain.start(), Status::InvalidPoint, 0);
    }
    let start = start.on_curve(curve, x);
    let (cell, t) = axis.cell(start, Side::Above);
    problem.run(problem.evaluate(cell, t))
}

struct Problem<'a, const D: usize, C: ?Sized> {
    curve: &'a C,
    axis: &'a Axis,
    x: &'a SVector<f64, D>,
    options: &'a LocalOptions,
}

/// A point of the curve, seen from inside one cell.
#[derive(Clone, Copy, Debug)]
struct Here<const D: usize> {
    cell: Cell,
    t: f64,
    jet: CurveJet<D>,
    distance: f64,
    noise: f64,
    /// `None` at singular points.
    residual: Option<CurveResidual>,
}

impl<const D: usize> Here<D> {
    /// Signed tangential residual, 0 at singular points.
    fn slope(&self) -> f64 {
        self.residual.map_or(0.0, |r| r.tangential)
    }

    /// By how much the optimality conditions of the cell are violated, as a length.
    fn violation(&self) -> f64 {
        let slope = self.slope();
        match self.cell.at(self.t) {
            [true, _] => slope.max(0.0),
            [_, true] => (-slope).max(0.0),
            _ => slope.abs(),
        }
    }
}

impl<const D: usize, C: ParametricCurve<D> + ?Sized> Problem<'_, D, C> {
    fn evaluate(&self, cell: Cell, t: f64) -> Here<D> {
        let jet = self.curve.jet(self.axis.evaluation(&cell, t));
        let magnitude = jet.point.norm();
        let length = self.axis.domain.length();
        let vanishing = VANISHING * (magnitude + jet.d2.norm() * length * length);
        let regular = jet.d1.norm() * length > vanishing;
        Here {
            cell,
            t,
            distance: (self.x - jet.point).norm(),
            noise: residual_noise(magnitude + self.x.norm()),
            residual: CurveResidual::new(&jet, self.x).filter(|_| regular),
            jet,
        }
    }

    fn run(&self, start: Here<D>) -> CurveFootpoint<D> {
        let mut here = start;
        let mut iterations = 0;
        // Set when the last step was negligible or none was possible: judge, and go on only elsewhere.
        let mut settled = false;
        loop {
            if !here.distance.is_finite() {
                return self.report(here.t, Status::Diverged, iterations);
            }
            let violation = here.violation();
            settled |= self.options.angle_stops(violation, here.distance);
            let acceptable = self.options.accepts(violation, here.distance, here.noise);
            let exhausted = iterations >= self.options.max_iterations;
            if violation <= here.noise || settled || exhausted {
                let verdict = if exhausted { Status::MaxIterations } else { Status::Stalled };
                if !acceptable {
                    return self.report(here.t, verdict, iterations);
                }
                match self.leave(&here) {
                    None => return self.report(here.t, Status::Converged, iterations),
                    Some(_) if exhausted => return self.report(here.t, verdict, iterations),
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
                    let moved = (next.t - here.t).abs();
                    settled = moved <= self.options.parameter_tolerance * self.axis.domain.length();
                    here = next;
                }
            }
        }
    }

    /// One safeguarded step inside the cell.
    fn advance(&self, here: &Here<D>) -> Option<Here<D>> {
        let residual = here.residual?;
        let delta = self.options.method.descending_curve_step(&here.jet, self.x)?;
        search(
            self.axis,
            &here.cell,
            here.t,
            delta,
            |t| self.evaluate(here.cell, t),
            |next| {
                let promise = residual.tangential * residual.speed * (next.t - here.t);
                next.distance <= largest_distance(here.distance, promise, here.noise)
            },
        )
    }

    /// A better point than one that is optimal inside its cell: behind a kink, or beside a maximum.
    fn leave(&self, here: &Here<D>) -> Option<Here<D>> {
        let [low, high] = here.cell.at(here.t);
        if (low && here.cell.open[0]) || (high && here.cell.open[1]) {
            let side = if low { Side::Below } else { Side::Above };
            let (cell, t) = self.axis.cell(here.t, side);
            let other = self.evaluate(cell, t);
            if !self.options.accepts(other.violation(), other.distance, other.noise) {
                return Some(other);
            }
        }
        let blocked = here.slope() < -here.noise && low || here.slope() > here.noise && high;
        let scale = match here.residual {
            None => 0.25 * self.axis.domain.length(),
            // A maximum of the distance: x is beyond the centre of curvature.
            Some(r) if r.offset > 1.0 + 1e-9 && !blocked => 1.0 / (r.curvature * r.speed),
            Some(_) => return None,
        };
        (0..ESCAPE_TRIALS).find_map(|k| {
            let delta = scale * 0.5_f64.powi(k);
            let trials = [delta, -delta].map(|d| self.evaluate(here.cell, here.cell.clamp(here.t + d)));
            let [a, b] = trials;
            let best = if a.distance <= b.distance { a } else { b };
            is_lower(best.distance, here.distance, here.noise).then_some(best)
        })
    }

    /// The footpoint at a cell parameter; `Converged` becomes `OnBoundary` at an end.
    fn report(&self, t: f64, status: Status, iterations: u32) -> CurveFootpoint<D> {
        let parameter = self.axis.normalize(t);
        let point = self.curve.point(parameter);
        let location = curve_location(self.axis, parameter);
        let on_boundary = status == Status::Converged && location == Location::Edge;
        CurveFootpoint {
            shape: 0,
            parameter,
            point,
            distance: (self.x - point).norm(),
            status: if on_boundary { Status::OnBoundary } else { status },
            location,
            multiplicity: Multiplicity::Unknown,
            lower_bound: 0.0,
            iterations,
        }
    }
}
