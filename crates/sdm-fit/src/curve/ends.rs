//! Open curves whose ends are given.

use super::adapt;
use super::options::CurveEnd;
use super::work::{State, Work};
use crate::constraint::normals;
use crate::{Constraints, Error};
use nalgebra::SVector;
use nurbs_core::{BsplineCurve, ParametricCurve};

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
        for (k, end) in given.iter().enumerate() {
            let [first, next] = if (k == 1) == is_swapped { [0, 1] } else { [last, last - 1] };
            let place = end.place(centre);
            let length = (net[next] - net[first]).norm();
            net[first] = place;
            constraints = constraints.with_held(first, place);
            let direction = end.direction.map(|d| SVector::<f64, D>::from_fn(|i, _| d[i]));
            if let Some(direction) = direction.and_then(|d| d.try_normalize(0.0)) {
                net[next] = place + direction * length;
                for normal in normals(&direction) {
                    constraints = constraints.with_plane(next, normal, normal.dot(&place));
                }
            }
        }
        let fit = adapt::warm(self);
        let start = BsplineCurve::new(knots, net, None)?;
        let next = self.run_within(self.points, start, &constraints, &fit, "ends")?;
        self.keep(&next);
        Ok(next)
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
