//! Open curves whose ends are given.

use super::options::CurveEnd;
use super::work::{COARSE, State, Work};
use crate::constraint::normals;
use crate::options::Smoothing;
use crate::{Constraints, Error};
use nalgebra::SVector;
use nurbs_core::{BsplineCurve, ParametricCurve};

/// Length of the first leg of the control polygon at an end with a given tangent, at least, as a share of what it was before.
const SHORTEST: f64 = 0.1;

impl<const D: usize> Work<'_, D> {
    /// The fit once more with the ends where they are given, as side conditions: exactly there, and in exactly these directions.
    pub(super) fn with_ends(&mut self, state: State<D>, centre: &SVector<f64, D>) -> Result<State<D>, Error> {
        let given: Vec<CurveEnd> = self.options.ends.into_iter().flatten().collect();
        if given.is_empty() || self.cancelled {
            return Ok(state);
        }
        let curve = self.with_room(state.curve.clamped()?)?;
        let ends = [curve.domain().start(), curve.domain().end()].map(|t| curve.point(t));
        let away = |k: usize, end: &CurveEnd| (ends[k] - end.place(centre)).norm();
        let is_swapped = match &given[..] {
            [one] => away(1, one) < away(0, one),
            [one, other, ..] => away(1, one) + away(0, other) < away(0, one) + away(1, other),
            [] => false,
        };
        let (knots, mut net, _) = curve.into_parts();
        let last = net.len() - 1;
        let mut constraints = Constraints::none();
        let mut legs = Vec::new();
        for (k, end) in given.iter().enumerate() {
            let [first, next] = if (k == 1) == is_swapped { [0, 1] } else { [last, last - 1] };
            let place = end.place(centre);
            let length = (net[next] - net[first]).norm();
            net[first] = place;
            constraints = constraints.with_held(first, place);
            let direction = end.direction.map(|d| SVector::<f64, D>::from_fn(|i, _| d[i]));
            if let Some(direction) = direction.and_then(|d| d.try_normalize(0.0)) {
                net[next] = place + direction * length;
                legs.push((first, next, direction * length));
                for normal in normals(&direction) {
                    constraints = constraints.with_plane(next, normal, normal.dot(&place));
                }
            }
        }
        // Without energy the curve would follow the points up to the end, and turn into the given direction in no length; with full steps to the
        // nearest feet it would slide along itself there.
        let lambda = state.report.lambda.max(COARSE);
        let follows = std::mem::replace(&mut self.follows, true);
        let fit = self.loop_options().with_smoothing(Smoothing::Fixed { lambda });
        self.follows = follows;
        let start = BsplineCurve::new(knots, net, None)?;
        let mut found = self.run_within(self.points, start.clone(), &constraints, &fit, "ends")?;
        // The side conditions leave the sense of a tangent open: where the points want another direction it may turn back.
        let net = found.curve.control_points();
        let is_short = |(first, next, leg): &(usize, usize, SVector<f64, D>)| {
            (net[*next] - net[*first]).dot(leg) < SHORTEST * leg.norm_squared()
        };
        if legs.iter().any(is_short) && !self.cancelled {
            for (_, next, _) in &legs {
                constraints = constraints.with_held(*next, start.control_points()[*next]);
            }
            found = self.run_within(self.points, start, &constraints, &fit, "ends")?;
        }
        self.keep(&found);
        Ok(found)
    }

    /// The curve with so many control points that given ends and tangents leave some free, unless their number was asked for.
    fn with_room(&self, curve: BsplineCurve<D>) -> Result<BsplineCurve<D>, Error> {
        let knots = curve.knots();
        if self.options.controls.is_some() || knots.basis_count() >= 2 * (knots.degree() + 1) {
            return Ok(curve);
        }
        let middles: Vec<f64> = knots.spans().map(|span| knots.span_interval(span).midpoint()).collect();
        Ok(curve.refine(&middles)?)
    }
}
