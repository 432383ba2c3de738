//! The parameter line of one direction: its ends, whether it closes, and where it is split.

use nurbs_core::{Break, Interval, ParametricCurve, ParametricSurface};

/// Largest gap, relative to the coordinates, across which a shape counts as closed.
const CLOSURE: f64 = 1e-13;

/// Fractions of the way along an edge at which closure and collapse are looked at.
pub(crate) const PROBES: [f64; 6] = [0.0, 0.219, 0.437, 0.618, 0.813, 1.0];

/// What an iteration has to know about one parameter.
#[derive(Clone, Debug)]
pub(crate) struct Axis {
    pub(crate) domain: Interval,
    /// Whether the parameter wraps around: the shape is periodic, or closed with a kink at the seam.
    pub(crate) wraps: bool,
    /// Where steps must stop, because the first derivative may jump; increasing, inside the domain. The
    /// seam of a closed shape that is not periodic is one of them.
    kinks: Vec<f64>,
    /// Where only the second derivative jumps.
    pub(crate) curvature_breaks: Vec<f64>,
}

/// A smooth interval of an axis, in parameters that may lie outside the domain of a wrapping axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Cell {
    pub(crate) low: f64,
    pub(crate) high: f64,
    /// Whether another cell follows at the lower and upper end.
    pub(crate) open: [bool; 2],
    /// How far inside an open end the shape is evaluated, so that it is this cell's piece that is met.
    nudge: f64,
}

/// The side of a parameter on which a cell is asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Side {
    Below,
    Above,
}

impl Axis {
    pub(crate) fn of_curve<const D: usize, C: ParametricCurve<D> + ?Sized>(curve: &C) -> Self {
        let domain = curve.domain();
        let periodic = curve.period().is_some();
        let closed = !periodic && {
            let (a, b) = (curve.point(domain.start()), curve.point(domain.end()));
            (a - b).norm() <= CLOSURE * (a.norm() + b.norm())
        };
        Self::new(domain, periodic, closed, &curve.derivative_breaks())
    }

    pub(crate) fn of_surface<S: ParametricSurface + ?Sized>(surface: &S) -> [Self; 2] {
        let domains = surface.domain();
        let periods = surface.period();
        let breaks = surface.derivative_breaks();
        [0, 1].map(|k| {
            let periodic = periods[k].is_some();
            let closed = !periodic
                && PROBES.iter().all(|&s| {
                    let other = domains[1 - k].lerp(s);
                    let at = |t: f64| if k == 0 { surface.point(t, other) } else { surface.point(other, t) };
                    let (a, b) = (at(domains[k].start()), at(domains[k].end()));
                    (a - b).norm() <= CLOSURE * (a.norm() + b.norm())
                });
            Self::new(domains[k], periodic, closed, &breaks[k])
        })
    }

    fn new(domain: Interval, periodic: bool, closed: bool, breaks: &[Break]) -> Self {
        let with = |wanted: fn(usize) -> bool| {
            breaks.iter().filter(move |b| wanted(b.continuity)).map(|b| b.parameter)
        };
        let mut kinks: Vec<f64> = with(|c| c == 0).collect();
        if closed {
            kinks.insert(0, domain.start());
        }
        Self { domain, wraps: periodic || closed, kinks, curvature_breaks: with(|c| c == 1).collect() }
    }

    /// `t` brought into the domain: wrapped or clamped.
    pub(crate) fn normalize(&self, t: f64) -> f64 {
        if self.wraps { self.domain.wrap(t) } else { self.domain.clamp(t) }
    }

    /// The cell on one side of `t`, and `t` in the parameters of that cell.
    pub(crate) fn cell(&self, t: f64, side: Side) -> (Cell, f64) {
        let mut t = self.normalize(t);
        let (start, length) = (self.domain.start(), self.domain.length());
        let magnitude = start.abs().max(self.domain.end().abs());
        let nudge = 4.0 * f64::EPSILON * (magnitude + length);
        let below = self.kinks.partition_point(|&k| if side == Side::Above { k <= t } else { k < t });
        let lower = below.checked_sub(1).map(|i| self.kinks[i]);
        let upper = self.kinks.get(below).copied();
        if !self.wraps {
            let (low, high) = (lower.unwrap_or(start), upper.unwrap_or(self.domain.end()));
            let cell = Cell { low, high, open: [lower.is_some(), upper.is_some()], nudge };
            return (cell, cell.clamp(t));
        }
        let (low, high) = match (lower, upper, self.kinks.first(), self.kinks.last()) {
            (Some(low), Some(high), ..) => (low, high),
            (Some(low), None, Some(first), _) => (low, first + length),
            (None, Some(_), Some(first), Some(last)) => {
                t += length;
                (*last, first + length)
            }
            _ => (f64::NEG_INFINITY, f64::INFINITY),
        };
        (Cell { low, high, open: [true, true], nudge }, t)
    }

    /// Whether `t` is the place where a wrapping axis closes.
    pub(crate) fn at_seam(&self, t: f64) -> bool {
        self.wraps && (t == self.domain.start() || t == self.domain.end())
    }

    /// Whether `t` is an end of the domain with nothing behind it.
    pub(crate) fn at_end(&self, t: f64) -> bool {
        !self.wraps && (t == self.domain.start() || t == self.domain.end())
    }

    /// The parameter of the shape at which the cell parameter `t` is evaluated.
    pub(crate) fn evaluation(&self, cell: &Cell, t: f64) -> f64 {
        let mut t = t;
        if cell.open[0] {
            t = t.max(cell.low + cell.nudge);
        }
        if cell.open[1] {
            t = t.min(cell.high - cell.nudge);
        }
        if self.wraps { self.domain.wrap(t) } else { t }
    }

    /// The first break of the second derivative strictly between two cell parameters, seen from `from`.
    pub(crate) fn curvature_break_between(&self, from: f64, to: f64) -> Option<f64> {
        // In the parameters of the turn in which the interval begins; later turns are rare and harmless.
        let shift = self.normalize(from) - from;
        let shift = if self.wraps { shift } else { 0.0 };
        let (low, high) = (from.min(to) + shift, from.max(to) + shift);
        let mut inside = self.curvature_breaks.iter().copied().filter(|&b| low < b && b < high);
        let found = if from < to { inside.next() } else { inside.next_back() };
        found.map(|b| b - shift)
    }
}

impl Cell {
    /// `t` brought into the cell; next to an end it is the end. A bound that is missed by less than the
    /// rounding of a parameter would never count as reached, and each step towards it would be cut to nothing.
    pub(crate) fn clamp(&self, t: f64) -> f64 {
        if t - self.low <= self.nudge {
            self.low
        } else if self.high - t <= self.nudge {
            self.high
        } else {
            t
        }
    }

    /// Whether `t` is at the lower or the upper end.
    pub(crate) fn at(&self, t: f64) -> [bool; 2] {
        [t == self.low, t == self.high]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn axis(periodic: bool, closed: bool, kinks: &[f64]) -> Axis {
        let breaks: Vec<_> = kinks.iter().map(|&parameter| Break { parameter, continuity: 0 }).collect();
        Axis::new(Interval::UNIT, periodic, closed, &breaks)
    }

    #[test]
    fn cells_of_an_open_axis() {
        let a = axis(false, false, &[0.25, 0.5]);
        let cell = |t, side| {
            let (c, t) = a.cell(t, side);
            (c.low, c.high, c.open, t)
        };
        assert_eq!(cell(0.1, Side::Above), (0.0, 0.25, [false, true], 0.1));
        assert_eq!(cell(0.25, Side::Above), (0.25, 0.5, [true, true], 0.25));
        assert_eq!(cell(0.25, Side::Below), (0.0, 0.25, [false, true], 0.25));
        assert_eq!(cell(7.0, Side::Above), (0.5, 1.0, [true, false], 1.0));
    }

    #[test]
    fn cells_of_wrapping_axes() {
        let smooth = axis(true, false, &[]).cell(1.25, Side::Above);
        assert_eq!((smooth.0.low, smooth.0.high, smooth.1), (f64::NEG_INFINITY, f64::INFINITY, 0.25));
        let one_kink = axis(true, false, &[0.5]);
        let (cell, t) = one_kink.cell(0.25, Side::Above);
        assert_eq!((cell.low, cell.high, t), (0.5, 1.5, 1.25));
        assert!(one_kink.evaluation(&cell, 1.5) < 0.5);
        assert!(one_kink.evaluation(&cell, 0.5) > 0.5);
        let closed = axis(false, true, &[]);
        let (cell, t) = closed.cell(0.0, Side::Below);
        assert_eq!((cell.low, cell.high, t), (0.0, 1.0, 1.0));
        assert!(closed.evaluation(&cell, 1.0) > 0.999);
    }

    #[test]
    fn curvature_breaks_are_seen_in_the_direction_of_the_step() {
        let breaks = [0.2, 0.4].map(|parameter| Break { parameter, continuity: 1 });
        let a = Axis::new(Interval::UNIT, true, false, &breaks);
        assert_eq!(a.curvature_break_between(0.1, 0.9), Some(0.2));
        assert_eq!(a.curvature_break_between(0.9, 0.1), Some(0.4));
        let next_turn = a.curvature_break_between(1.1, 1.3).unwrap();
        assert!((next_turn - 1.2).abs() < 1e-15);
        assert_eq!(a.curvature_break_between(0.2, 0.4), None);
    }
}
