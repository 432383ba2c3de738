//! Curves to start from.

use super::front;
use super::nodes::principal;
use super::options::CurveOptions;
use super::parts::Asked;
use super::path::{Path, along_order, is_ordered, through};
use super::report::{Closure, CurveStart};
use super::shortest::shortest;
use crate::Error;
use distance_field::quantile_in_place;
use nalgebra::{DMatrix, SVector};
use nurbs_core::{BsplineCurve, CurveFitOptions, Interval, KnotVector, ParametricCurve};
use sdm_core::Robust;

/// Width of a cloud as a share of its length below which it is a line.
const LINE: f64 = 1e-9;
/// Distance from a path that passes for near to it: in units of the scatter of the points about it, and as a share of the standard deviation of
/// the points along their main axis.
const SCATTER: f64 = 3.0;
const FAITHFUL: f64 = 1e-2;
/// Share of the distances that the standard deviation does not exceed, and what lies off the path, in units of that and of the spacing.
const DEVIATION: f64 = 0.6827;
const OUTLYING: f64 = 6.0;
const SPACINGS: f64 = 1.0;
/// Times that knots are inserted for that, and share of the largest distance up to which it is done where their number is given.
const ROUNDS: usize = 24;
const WORST: f64 = 0.3;
/// Bending of the first curve, which bridges spans without nodes; where all spans have nodes, and short ones are to bend.
const BRIDGE: f64 = 1e-7;
const FINE_BRIDGE: f64 = 1e-13;

/// How a cloud lies.
#[derive(Clone, Debug)]
pub(crate) struct Layout<const D: usize> {
    pub(crate) kind: CurveStart,
    pub(crate) closed: bool,
    pub(crate) closure: Closure,
    /// Whether the points show no path.
    pub(crate) lost: bool,
    path: Option<Path<D>>,
    axes: Vec<(SVector<f64, D>, f64)>,
    centre: SVector<f64, D>,
}

impl<const D: usize> Layout<D> {
    /// Looks at points of which at least two differ, along the path that is the shortest.
    pub(crate) fn shortest(points: &[SVector<f64, D>], options: &CurveOptions) -> Result<Self, Error> {
        Self::along(points, options, || Ok(shortest(points)))
    }

    /// Looks at points of which at least two differ, along a path that goes straight on where it can.
    ///
    /// # Errors
    /// [`Error::SeveralParts`] where there are several.
    pub(crate) fn straight(points: &[SVector<f64, D>], options: &CurveOptions) -> Result<Self, Error> {
        Self::along(points, options, || {
            let mut paths = paths(points, options);
            if paths.len() > 1 {
                let sizes = members(points, &paths).iter().map(Vec::len).collect();
                return Err(Error::SeveralParts { sizes });
            }
            Ok(paths.pop())
        })
    }

    fn along(
        points: &[SVector<f64, D>],
        options: &CurveOptions,
        path: impl FnOnce() -> Result<Option<Path<D>>, Error>,
    ) -> Result<Self, Error> {
        let (centre, axes) = axes(points);
        let (length, width) = (axes.first().map_or(0.0, |a| a.1), axes.get(1).map_or(0.0, |a| a.1));
        if length <= 0.0 {
            return Err(Error::Degenerate { shape: "a curve", what: "all at one place" });
        }
        if width <= LINE * length {
            if options.closed == Some(true) {
                return Err(Error::Degenerate { shape: "a closed curve", what: "on a line" });
            }
            let closure = if options.closed.is_some() { Closure::Asked } else { Closure::Line };
            let mut sorted = points.to_vec();
            sorted.sort_by(|a, b| (a - b).dot(&axes[0].0).total_cmp(&0.0));
            let ends: Vec<_> = sorted.first().into_iter().chain(sorted.last()).copied().collect();
            let path = Path { nodes: ends, gap: f64::INFINITY, gap_limit: 0.0, ordered: false };
            let kind = CurveStart::Line;
            return Ok(Self { kind, closed: false, closure, lost: false, path: Some(path), axes, centre });
        }
        if options.search {
            if options.closed == Some(false) {
                return Err(Error::Option {
                    name: "search",
                    value: 1.0,
                    allowed: "false (0) for open curves",
                });
            }
            let nodes = front::contours(points, None, 1)?.pop();
            let path = nodes.map(|nodes| Path { nodes, gap: 0.0, gap_limit: 1.0, ordered: false });
            return Ok(Self {
                kind: CurveStart::Contour,
                closed: true,
                closure: Closure::Asked,
                lost: false,
                path,
                axes,
                centre,
            });
        }
        let path = path()?;
        let kind = match &path {
            Some(path) if path.ordered => CurveStart::Order,
            Some(_) => CurveStart::Skeleton,
            None => CurveStart::Ellipse,
        };
        let (closed, closure) = match (options.closed, &path) {
            (Some(closed), _) => (closed, Closure::Asked),
            (None, Some(path)) => (path.is_closed(), Closure::Gap { gap: path.gap, limit: path.gap_limit }),
            // Without a path the cloud is a blob: its outline is closed.
            (None, None) => (true, Closure::Gap { gap: 0.0, limit: 0.0 }),
        };
        let kind = if kind == CurveStart::Ellipse && !closed { CurveStart::Line } else { kind };
        Ok(Self { kind, closed, closure, lost: path.is_none(), path, axes, centre })
    }

    /// Whether the path is the same.
    pub(crate) fn is_along(&self, other: &Self) -> bool {
        self.path == other.path && self.closed == other.closed
    }

    /// The same cloud seen as one without a path.
    pub(crate) fn as_ellipse(&self) -> Self {
        Self { kind: CurveStart::Ellipse, path: None, ..self.clone() }
    }

    /// The first curve with a number of control points.
    pub(crate) fn curve(&self, degree: usize, controls: usize) -> Result<BsplineCurve<D>, Error> {
        self.curve_on(if self.closed {
            KnotVector::uniform_periodic(degree, controls)?
        } else {
            KnotVector::uniform_clamped(degree, controls)?
        })
    }

    /// A distance from the path that passes for near to it: what the points scatter about it, or a small share of the size.
    pub(crate) fn nearness(&self, points: &[SVector<f64, D>]) -> f64 {
        let size = self.axes.first().map_or(0.0, |a| a.1);
        self.scatter(points).max(FAITHFUL * size)
    }

    /// The points but for those that lie much further from the path than most; all of them without one.
    pub(crate) fn inliers(&self, points: &[SVector<f64, D>]) -> Vec<SVector<f64, D>> {
        let Some(path) = self.path.as_ref().filter(|_| self.kind != CurveStart::Line) else {
            return points.to_vec();
        };
        let distances = crate::parallel::map(points.len(), |i| path.distance(&points[i]));
        let spread = quantile_in_place(&mut distances.clone(), DEVIATION);
        let spacing = path.lengths(self.closed).1 / points.len() as f64;
        let limit = OUTLYING * spread + SPACINGS * spacing;
        points.iter().zip(distances).filter(|(_, d)| *d <= limit).map(|(p, _)| *p).collect()
    }

    /// How often the path crosses itself.
    pub(crate) fn crossings(&self) -> usize {
        self.path.as_ref().map_or(0, |path| path.crossings(self.closed))
    }

    /// How far from the path points lie.
    pub(crate) fn scatter(&self, points: &[SVector<f64, D>]) -> f64 {
        self.path.as_ref().map_or(0.0, |path| SCATTER * path.scatter(points))
    }

    /// A first curve with knots where the path bends, so near to it (up to a limit) that it takes no short cut from one side of what is
    /// narrow to the other; `None` without a path.
    pub(crate) fn faithful(
        &self,
        degree: usize,
        most: usize,
        limit: f64,
    ) -> Result<Option<BsplineCurve<D>>, Error> {
        self.adapted(degree, most, limit, 0.0)
    }

    /// A first curve of a number of control points, with more knots where the path bends; `None` without a path.
    pub(crate) fn bent(&self, degree: usize, controls: usize) -> Result<Option<BsplineCurve<D>>, Error> {
        self.adapted(degree, controls, 0.0, WORST)
    }

    /// Knots are inserted in the middle of spans from which the path is further away than a limit, and than a share of the largest
    /// distance.
    fn adapted(
        &self,
        degree: usize,
        most: usize,
        limit: f64,
        share: f64,
    ) -> Result<Option<BsplineCurve<D>>, Error> {
        let Some(path) = self.path.as_ref().filter(|_| self.kind != CurveStart::Line) else {
            return Ok(None);
        };
        let (lengths, total) = path.lengths(self.closed);
        let mut curve = self.curve(degree, (degree + 5).min(most))?;
        for _ in 0..ROUNDS {
            let knots = curve.knots();
            let mut far = vec![(0, 0.0f64); knots.basis_count()];
            for (length, node) in lengths.iter().zip(&path.nodes) {
                let t = Interval::UNIT.lerp(length / total);
                let span = &mut far[knots.span(t)];
                *span = (span.0 + 1, span.1.max((curve.point(t) - node).norm()));
            }
            // Spans without a node in them would bend as they please.
            let split: Vec<usize> = knots.spans().filter(|&span| far[span].0 > 3).collect();
            let largest = split.iter().map(|&span| far[span].1).fold(0.0, f64::max);
            let mut wanted: Vec<(f64, f64)> = split
                .into_iter()
                .filter(|&span| far[span].1 > limit.max(share * largest))
                .map(|span| (far[span].1, knots.span_interval(span).lerp(0.5)))
                .collect();
            wanted.sort_by(|a, b| b.0.total_cmp(&a.0));
            wanted.truncate(most.saturating_sub(knots.distinct_count()));
            if wanted.is_empty() {
                break;
            }
            let mut values: Vec<f64> = wanted.into_iter().map(|w| w.1).collect();
            values.sort_by(f64::total_cmp);
            curve = self.bridged(curve.refine(&values)?.knots().clone(), FINE_BRIDGE)?;
        }
        Ok(Some(curve))
    }

    /// The first curve on given knots with the domain [0, 1].
    pub(crate) fn curve_on(&self, knots: KnotVector) -> Result<BsplineCurve<D>, Error> {
        self.bridged(knots, BRIDGE)
    }

    fn bridged(&self, knots: KnotVector, bridge: f64) -> Result<BsplineCurve<D>, Error> {
        let degree = knots.degree();
        let Some(path) = self.path.as_ref().filter(|p| p.nodes.len() >= 2) else {
            return self.about_axes(knots);
        };
        let (lengths, total) = path.lengths(self.closed);
        let parameters: Vec<f64> = lengths.iter().map(|l| Interval::UNIT.lerp(l / total)).collect();
        let options = CurveFitOptions::default().with_regularization(if degree > 1 { bridge } else { 0.0 });
        match BsplineCurve::approximate(knots.clone(), &parameters, &path.nodes, &options) {
            Ok(fitted) => Ok(fitted.shape),
            // Too few nodes for a polygon of this many corners: take their places along the path.
            Err(_) => Ok(self.sampled(path, knots)?),
        }
    }

    /// Control points on the path, at the Greville parameters.
    fn sampled(&self, path: &Path<D>, knots: KnotVector) -> Result<BsplineCurve<D>, Error> {
        let (lengths, total) = path.lengths(self.closed);
        let mut nodes = path.nodes.clone();
        let mut lengths = lengths;
        if self.closed {
            nodes.push(nodes[0]);
            lengths.push(total);
        }
        let at = |t: f64| {
            let length = t * total;
            let k = lengths.partition_point(|l| *l <= length).clamp(1, nodes.len() - 1);
            let step = (lengths[k] - lengths[k - 1]).max(f64::MIN_POSITIVE);
            let share = ((length - lengths[k - 1]) / step).clamp(0.0, 1.0);
            nodes[k - 1] + (nodes[k] - nodes[k - 1]) * share
        };
        let count = knots.distinct_count();
        let greville = knots.greville();
        let mut points: Vec<_> = greville[..count].iter().map(|&t| at(knots.normalize(t))).collect();
        points.extend_from_within(..knots.basis_count() - count);
        Ok(BsplineCurve::new(knots, points, None)?)
    }

    /// An ellipse with the moments of the cloud, or the main axis of it.
    fn about_axes(&self, knots: KnotVector) -> Result<BsplineCurve<D>, Error> {
        let count = knots.distinct_count();
        let axis = |k: usize| self.axes.get(k).map_or(SVector::zeros(), |(e, s)| e * *s);
        let greville = knots.greville();
        let place = |&t: &f64| {
            if self.closed {
                // Points on an ellipse have the variance a²/2 along an axis.
                let (sine, cosine) = (std::f64::consts::TAU * t).sin_cos();
                self.centre + (axis(0) * cosine + axis(1) * sine) * std::f64::consts::SQRT_2
            } else {
                // Those on a segment that of a third of the square of its half.
                self.centre + axis(0) * (3f64.sqrt() * (2.0 * t - 1.0))
            }
        };
        let mut points: Vec<_> = greville[..count].iter().map(place).collect();
        points.extend_from_within(..knots.basis_count() - count);
        Ok(BsplineCurve::new(knots, points, None)?)
    }
}

/// The paths along points, none of them if there are none.
pub(super) fn paths<const D: usize>(points: &[SVector<f64, D>], options: &CurveOptions) -> Vec<Path<D>> {
    let outliers = options.fit.robust != Robust::None;
    let asked = Asked { closed: options.closed, gap: options.max_gap, outliers };
    let ordered = if is_ordered(points) { along_order(points, asked) } else { None };
    ordered.or_else(|| through(points, asked)).unwrap_or_default()
}

/// For each path the points that are nearest to it.
pub(super) fn members<const D: usize>(points: &[SVector<f64, D>], paths: &[Path<D>]) -> Vec<Vec<usize>> {
    let nearest = crate::parallel::map(points.len(), |i| {
        let distance = |k: &usize| paths[*k].distance(&points[i]);
        (0..paths.len()).min_by(|a, b| distance(a).total_cmp(&distance(b))).unwrap_or(0)
    });
    let mut out = vec![Vec::new(); paths.len()];
    nearest.into_iter().enumerate().for_each(|(i, k)| out[k].push(i));
    out
}

/// The mean of points and their principal axes with the standard deviation along each, the longest first.
fn axes<const D: usize>(points: &[SVector<f64, D>]) -> (SVector<f64, D>, Vec<(SVector<f64, D>, f64)>) {
    let centre = points.iter().sum::<SVector<f64, D>>() / points.len() as f64;
    let mut rest: Vec<SVector<f64, D>> = points.iter().map(|p| p - centre).collect();
    let mut out = Vec::new();
    for _ in 0..D {
        let mut moments = DMatrix::zeros(D, D);
        for r in &rest {
            for a in 0..D {
                for b in 0..D {
                    moments[(a, b)] += r[a] * r[b] / points.len() as f64;
                }
            }
        }
        let Some((direction, values)) = principal::<D>(moments) else { break };
        out.push((direction, values.first().copied().unwrap_or(0.0).max(0.0).sqrt()));
        // From the points, not from the moments, whose rounding would hide a small width.
        rest.iter_mut().for_each(|r| *r -= direction * direction.dot(r));
    }
    (centre, out)
}
