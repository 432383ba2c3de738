//! Surfaces that continue others across a common edge.

use super::compatible::snapped;
use crate::{BsplineCurve, BsplineSurface, Direction, Error, MAX_DEGREE, ParametricCurve, basis};
use nalgebra::{DMatrix, Vector3};

/// Samples by which sides and edges are compared.
const SAMPLES: usize = 33;
/// Share of the size up to which places are the same.
const SAME: f64 = 1e-6;

/// A side of a surface that is open there.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(rename_all = "snake_case"))]
pub enum Side {
    /// Where `u` begins.
    UStart,
    /// Where `u` ends.
    UEnd,
    /// Where `v` begins.
    VStart,
    /// Where `v` ends.
    VEnd,
}

impl Side {
    /// All of them, in the order of arrays with an entry for each.
    pub const ALL: [Self; 4] = [Self::UStart, Self::UEnd, Self::VStart, Self::VEnd];

    /// Its place in such an array.
    #[must_use]
    pub fn index(self) -> usize {
        self as usize
    }

    /// The parameter that is constant on it.
    #[must_use]
    pub fn constant(self) -> Direction {
        match self {
            Self::UStart | Self::UEnd => Direction::U,
            Self::VStart | Self::VEnd => Direction::V,
        }
    }

    /// Whether it is where that parameter ends.
    #[must_use]
    pub fn is_end(self) -> bool {
        matches!(self, Self::UEnd | Self::VEnd)
    }
}

impl std::fmt::Display for Side {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let what = if self.is_end() { "end" } else { "start" };
        write!(f, "the {what} of {}", self.constant())
    }
}

/// How a surface continues another one.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(rename_all = "snake_case"))]
pub enum Continuity {
    /// The edge is common (G0).
    Position,
    /// And so are the tangent planes along it (G1).
    #[default]
    TangentPlane,
}

impl Continuity {
    /// Rows of control points at a side that it decides.
    #[must_use]
    pub fn rows(self) -> usize {
        match self {
            Self::Position => 1,
            Self::TangentPlane => 2,
        }
    }
}

/// A surface that was joined to others.
#[derive(Clone, Debug, PartialEq)]
pub struct Joined {
    /// The surface: its sides are edges of the others.
    pub surface: BsplineSurface,
    /// Rows of control points at each side ([`Side::ALL`]) that must stay so.
    pub held: [usize; 4],
    /// For each neighbour the side of the surface, and that of the neighbour.
    pub sides: Vec<[Side; 2]>,
}

/// Moves sides of a surface to the nearest edges of its neighbours, with a common edge or common tangent planes along it; the rest of it stays.
///
/// `held` says how many rows of control points at each side ([`Side::ALL`]) are given already, as by boundary curves: what they contradict is refused.
/// For tangent planes the degree along the side becomes at least one more than that of the edge: the derivative across the side is
/// `a(t) T(t) + b(t) E'(t)` with the derivative `T` of the neighbour across its edge `E`, and linear `a` and `b` that fit the given surface at the two
/// ends. This is exact, for polynomial surfaces.
///
/// # Errors
/// [`Error::Incompatible`] for rational neighbours, sides that are not open, more neighbours than sides, edges that do not fit to what is held, and
/// neighbours over which the surface would run back.
pub fn joined(
    surface: BsplineSurface,
    held: [usize; 4],
    neighbours: &[BsplineSurface],
    continuity: Continuity,
) -> Result<Joined, Error> {
    if surface.weights().is_some() || neighbours.iter().any(|n| n.weights().is_some()) {
        return Err(refused("surfaces with weights cannot be joined; approximate them by ones without"));
    }
    let mut out = Joined { surface, held, sides: Vec::with_capacity(neighbours.len()) };
    for (k, neighbour) in neighbours.iter().enumerate() {
        let used: Vec<Side> = out.sides.iter().map(|[side, _]| *side).collect();
        let Some(found) = nearest(&out.surface, &used, neighbour)? else {
            return Err(refused(&format!(
                "neighbour {k} (from 0) has no open edge, or the surface no open side that is left for it"
            )));
        };
        let slack = SAME * out.surface.control_box().diagonal();
        if out.held[found.side.index()] > 0 && found.distance > slack {
            return Err(refused(&format!(
                "no edge of neighbour {k} (from 0) is one of the boundary curves: the nearest is {:.3e} from {}",
                found.distance, found.side
            )));
        }
        let canonical = turned(&out.surface, found.side)?;
        let [left, right] = beside(found.side).map(|side| out.held[side.index()]);
        let given = Given { own: out.held[found.side.index()], left, right, slack };
        let moved = moved_side(canonical, &found, continuity, given).map_err(|what| {
            refused(&format!("neighbour {k} (from 0) at {} of the surface: {what}", found.side))
        })?;
        out.surface = turned_back(&moved, found.side)?;
        let rows = &mut out.held[found.side.index()];
        *rows = (*rows).max(continuity.rows());
        out.sides.push([found.side, found.of]);
    }
    Ok(out)
}

fn refused(what: &str) -> Error {
    Error::Incompatible { what: what.to_owned() }
}

/// The edge of a surface at a side, and its derivative across, out of the surface.
fn edge(surface: &BsplineSurface, side: Side) -> Result<[BsplineCurve<3>; 2], Error> {
    let direction = side.constant();
    let domain = [surface.knots_u(), surface.knots_v()][direction.index()].domain();
    let t = if side.is_end() { domain.end() } else { domain.start() };
    let across = surface.derivative_surface(direction)?.iso_curve(direction, t)?;
    let across = if side.is_end() { across } else { across.scaled(-1.0, &Vector3::zeros())? };
    Ok([surface.iso_curve(direction, t)?.clamped()?, across.clamped()?])
}

/// Sides that a surface has: those of open directions along which the other direction is open, too.
fn open_sides(surface: &BsplineSurface) -> impl Iterator<Item = Side> {
    let is_open = !surface.knots_u().is_periodic() && !surface.knots_v().is_periodic();
    Side::ALL.into_iter().filter(move |_| is_open)
}

/// An edge of a neighbour and the side of the surface to which it is nearest.
struct Found {
    side: Side,
    of: Side,
    edge: BsplineCurve<3>,
    across: BsplineCurve<3>,
    distance: f64,
}

fn nearest(
    surface: &BsplineSurface,
    used: &[Side],
    neighbour: &BsplineSurface,
) -> Result<Option<Found>, Error> {
    let places = |curve: &BsplineCurve<3>| -> Vec<Vector3<f64>> {
        (0..SAMPLES).map(|k| curve.point(curve.domain().lerp(k as f64 / (SAMPLES - 1) as f64))).collect()
    };
    // The mean distance of each from the nearest of the other, so that parameters do not matter.
    let apart = |a: &[Vector3<f64>], b: &[Vector3<f64>]| {
        a.iter().map(|p| b.windows(2).map(|e| from_segment(p, e)).fold(f64::INFINITY, f64::min)).sum::<f64>()
            / a.len() as f64
    };
    let mut best: Option<Found> = None;
    for side in open_sides(surface).filter(|side| !used.contains(side)) {
        let own = places(&edge(surface, side)?[0]);
        for of in open_sides(neighbour) {
            let [edge, across] = edge(neighbour, of)?;
            let other = places(&edge);
            let distance = apart(&own, &other).max(apart(&other, &own));
            if best.as_ref().is_some_and(|best| best.distance <= distance) {
                continue;
            }
            let [first, last] = [own[0], own[SAMPLES - 1]];
            let along = (first - other[0]).norm() + (last - other[SAMPLES - 1]).norm();
            let against = (first - other[SAMPLES - 1]).norm() + (last - other[0]).norm();
            let (edge, across) =
                if against < along { (edge.reversed()?, across.reversed()?) } else { (edge, across) };
            best = Some(Found { side, of, edge, across, distance });
        }
    }
    Ok(best)
}

fn from_segment(p: &Vector3<f64>, ends: &[Vector3<f64>]) -> f64 {
    let way = ends[1] - ends[0];
    let share = ((p - ends[0]).dot(&way) / way.norm_squared().max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
    (p - ends[0] - way * share).norm()
}

/// The surface turned so that the side is where `u` begins.
fn turned(surface: &BsplineSurface, side: Side) -> Result<BsplineSurface, Error> {
    let from_start = if side.is_end() { surface.reversed(side.constant())? } else { surface.clone() };
    let clamped = from_start.clamped(Direction::U)?.clamped(Direction::V)?;
    if side.constant() == Direction::V { clamped.transposed() } else { Ok(clamped) }
}

fn turned_back(surface: &BsplineSurface, side: Side) -> Result<BsplineSurface, Error> {
    let untransposed = if side.constant() == Direction::V { surface.transposed()? } else { surface.clone() };
    if side.is_end() { untransposed.reversed(side.constant()) } else { Ok(untransposed) }
}

/// The sides at the beginning and the end of a side.
fn beside(side: Side) -> [Side; 2] {
    match side.constant() {
        Direction::U => [Side::VStart, Side::VEnd],
        Direction::V => [Side::UStart, Side::UEnd],
    }
}

/// Rows of control points that are given: at the side itself, and at those beside it; and by how much what is new may differ from them.
#[derive(Clone, Copy)]
struct Given {
    own: usize,
    left: usize,
    right: usize,
    slack: f64,
}

/// The surface with its side `u` = start on the edge.
fn moved_side(
    surface: BsplineSurface,
    found: &Found,
    continuity: Continuity,
    given: Given,
) -> Result<BsplineSurface, String> {
    let said = |error: Error| error.to_string();
    let domain = surface.knots_v().domain();
    let tangent = continuity == Continuity::TangentPlane;
    let edge = found.edge.reparameterized(domain).map_err(said)?;
    let across = found.across.reparameterized(domain).map_err(said)?;
    // A linear function times the derivative across has a degree more than the edge.
    let degree = surface.degree_v().max(edge.degree() + usize::from(tangent));
    let surface = surface.elevated(Direction::V, degree - surface.degree_v()).map_err(said)?;
    let edge = edge.elevated(degree - edge.degree()).map_err(said)?;
    let edge = snapped(&edge, surface.knots_v()).map_err(said)?;
    let common = surface.knots_v().merged(edge.knots()).map_err(said)?;
    let surface = surface.refine(Direction::V, &surface.knots_v().missing(&common)).map_err(said)?;
    let edge = edge.refine(&edge.knots().missing(&common)).map_err(said)?;
    if surface.n_u() < 2 * continuity.rows() {
        return Err(format!("it has {} rows of control points, too few; take more", surface.n_u()));
    }
    let n = surface.n_v();
    let (knots_u, knots_v, mut net, _) = surface.into_parts();
    let is_given = |i: usize, j: usize| i < given.own || j < given.left || j + given.right >= n;
    let mut rows = vec![edge.control_points().to_vec()];
    if tangent {
        let step = |j: usize| {
            // What is given beside the side decides; otherwise the surface goes on as it did.
            if is_given(1, j) { net[n + j] - edge.control_points()[j] } else { net[n + j] - net[j] }
        };
        let ends = [(0, domain.start()), (n - 1, domain.end())];
        let mut factors = [[0.0; 2]; 2];
        for ((j, t), factors) in ends.into_iter().zip(&mut factors) {
            *factors =
                shares(&step(j), &across.point(t), &edge.jet(t).d1, is_given(1, j).then_some(given.slack))?;
        }
        let [[a0, b0], [a1, b1]] = factors;
        let derivative = |t: f64| {
            let share = domain.fraction(t);
            across.point(t) * (a0 + (a1 - a0) * share) + edge.jet(t).d1 * (b0 + (b1 - b0) * share)
        };
        let steps = coefficients(&knots_v, derivative)?;
        rows.push(edge.control_points().iter().zip(steps).map(|(p, step)| p + step).collect());
    }
    for (i, row) in rows.iter().enumerate() {
        for (j, place) in row.iter().enumerate() {
            let old = &mut net[i * n + j];
            if !is_given(i, j) {
                *old = *place;
            } else if (*old - place).norm() > given.slack {
                return Err(format!(
                    "its edge, or its tangent plane there, contradicts what is given at the corner or along the side, by {:.3e}",
                    (*old - place).norm()
                ));
            }
        }
    }
    BsplineSurface::new(knots_u, knots_v, net, None).map_err(said)
}

/// Shares of the derivative across an edge and along it in a step; exactly, up to a slack, where one is given.
fn shares(
    step: &Vector3<f64>,
    across: &Vector3<f64>,
    along: &Vector3<f64>,
    slack: Option<f64>,
) -> Result<[f64; 2], String> {
    let (aa, ab, bb) = (across.norm_squared(), across.dot(along), along.norm_squared());
    let determinant = aa * bb - ab * ab;
    if determinant.is_nan() || determinant <= 1e-12 * aa * bb {
        return Err("the neighbour has no tangent plane at an end of its edge".to_owned());
    }
    let (x, y) = (step.dot(across), step.dot(along));
    let found = [(x * bb - y * ab) / determinant, (y * aa - x * ab) / determinant];
    if let Some(slack) = slack {
        let off = (across * found[0] + along * found[1] - step).norm();
        if off > slack {
            return Err(format!(
                "the boundary at the corner leaves the tangent plane of the neighbour by {off:.3e}: only a common edge is possible there"
            ));
        }
    }
    if found[0] > 0.0 {
        return Ok(found);
    }
    if slack.is_some() {
        return Err("the surface would run back over the neighbour".to_owned());
    }
    // The surface that is given says nothing useful: straight on, by as much as it went.
    Ok([step.norm() / aa.sqrt(), 0.0])
}

/// The control points of a spline over knots by its values at the Greville abscissae.
fn coefficients(
    knots: &crate::KnotVector,
    at: impl Fn(f64) -> Vector3<f64>,
) -> Result<Vec<Vector3<f64>>, String> {
    let places = knots.greville();
    let n = places.len();
    let mut matrix = DMatrix::<f64>::zeros(n, n);
    let mut values = DMatrix::<f64>::zeros(n, 3);
    for (row, &t) in places.iter().enumerate() {
        let span = knots.span(t);
        let mut weights = [0.0; MAX_DEGREE + 1];
        basis::values(knots, span, t, &mut weights);
        let p = knots.degree();
        for (k, weight) in weights[..=p].iter().enumerate() {
            matrix[(row, span - p + k)] = *weight;
        }
        let value = at(t);
        (0..3).for_each(|c| values[(row, c)] = value[c]);
    }
    let solved = matrix.lu().solve(&values).ok_or("its knots admit no interpolation")?;
    Ok((0..n).map(|k| Vector3::new(solved[(k, 0)], solved[(k, 1)], solved[(k, 2)])).collect())
}
