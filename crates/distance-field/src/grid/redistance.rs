//! The signed distance from the zero set of a level function, of fourth order: closest points carried from node to node.

use crate::level_set::{GridSpline, ZeroSet, crossings};
use crate::{Error, Grid};
use footpoint::Status;
use nalgebra::SVector;
use std::cmp::Ordering;
use std::collections::BinaryHeap;

/// Two feet further apart than this, in steps of the grid, belong to different parts of the zero set as seen from a node.
const SAME_FOOT: f64 = 2.0;

/// Distance from the zero set, as a share of the size of the grid, of a point that counts as lying on it.
const ON_SET: f64 = 1e-12;

/// A level function made into a distance.
#[derive(Clone, Debug, PartialEq)]
pub struct Redistanced<const D: usize> {
    /// The signed distances, with the sign of the level function at each node; zero counts as positive.
    pub grid: Grid<D>,
    /// Nodes beyond the band: their values are plus or minus its width.
    pub beyond: usize,
    /// Nodes whose iteration did not converge: at centres of curvature, and where the zero set is singular. They have the nearest
    /// point of the zero set that was seen.
    pub unresolved: usize,
}

/// A node that waits for its closest point to be carried on; the least distance comes first, of equal ones the first node.
#[derive(Clone, Copy, PartialEq)]
struct Front {
    distance: f64,
    node: usize,
}

impl Eq for Front {}

impl Ord for Front {
    fn cmp(&self, other: &Self) -> Ordering {
        other.distance.total_cmp(&self.distance).then(other.node.cmp(&self.node))
    }
}

impl PartialOrd for Front {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

/// Turns a level function into the signed distance from its zero set, at most `band` from it if one is given.
///
/// The closest point of a node is the foot on the zero set of the cubic spline through the values, found by Newton's method on the
/// equations of Lagrange from the closest point of a neighbour; nodes are taken in the order of their distance (as in
/// \[P05, sec. 3.1\], with closest points in the place of arrival times). The error is that of the spline: of fourth order in the
/// spacing where the level function is smooth and its gradient does not vanish on the zero set. The level function need not be
/// near to a distance.
///
/// ```
/// use distance_field::{Grid, grid::redistance};
/// use nalgebra::Vector2;
///
/// let ellipse = |p: &Vector2<f64>| (p.x / 2.0).powi(2) + p.y.powi(2) - 1.0;
/// let grid = Grid::sample(Vector2::new(-3.0, -2.0), Vector2::repeat(0.05), [121, 81], ellipse)?;
/// let distance = redistance(&grid, None)?.grid;
/// // On the long axis, at (3, 0): one unit from the vertex.
/// let node = 120 * 81 + 40;
/// assert!((grid.position(node) - Vector2::new(3.0, 0.0)).norm() < 1e-12);
/// assert!((distance.values()[node] - 1.0).abs() < 1e-9);
/// # Ok::<(), distance_field::Error>(())
/// ```
///
/// # Errors
/// [`Error::NoPoints`] where the values do not change their sign, and [`Error::Option`] for a band that is not positive.
pub fn redistance<const D: usize>(grid: &Grid<D>, band: Option<f64>) -> Result<Redistanced<D>, Error> {
    if let Some(value) = band.filter(|band| !(*band > 0.0 && band.is_finite())) {
        return Err(Error::Option { option: "band", value, what: "it must be a positive length" });
    }
    let spline = GridSpline::new(grid);
    let (places, jump) = crossings(grid, &|place| spline.taylor(place).value);
    if places.is_empty() {
        return Err(Error::NoPoints { count: grid.values().len() });
    }
    let counts = grid.counts();
    let size = (0..D).map(|k| grid.spacing()[k] * counts[k] as f64).fold(0.0, f64::max);
    let mut search = Carrier {
        set: ZeroSet { grid, spline: &spline, jump, size },
        nearest: vec![None; grid.values().len()],
        front: BinaryHeap::new(),
        step: grid.spacing().norm(),
    };
    for place in &places {
        search.around(place);
    }
    search.carry(band.unwrap_or(f64::INFINITY));
    let (mut beyond, mut unresolved) = (0, 0);
    let mut values = Vec::with_capacity(grid.values().len());
    for (value, nearest) in grid.values().iter().zip(&search.nearest) {
        let distance = match nearest {
            Some(nearest) => {
                unresolved += usize::from(!nearest.is_foot);
                nearest.distance
            }
            None => f64::INFINITY,
        };
        let distance = match band {
            Some(band) if distance >= band => {
                beyond += 1;
                band
            }
            _ => distance,
        };
        values.push(if *value < 0.0 { -distance } else { distance });
    }
    Ok(Redistanced { grid: grid.with_values(values)?, beyond, unresolved })
}

/// The closest point of a node.
#[derive(Clone, Copy)]
struct Nearest<const D: usize> {
    /// In units of the spacing.
    place: SVector<f64, D>,
    distance: f64,
    /// Whether it is the foot of the node, not only that of a neighbour.
    is_foot: bool,
}

struct Carrier<'a, const D: usize> {
    set: ZeroSet<'a, D>,
    nearest: Vec<Option<Nearest<D>>>,
    front: BinaryHeap<Front>,
    /// Diagonal of a cell.
    step: f64,
}

impl<const D: usize> Carrier<'_, D> {
    /// Tries a point of the zero set on the nodes of the cells around it.
    fn around(&mut self, place: &SVector<f64, D>) {
        let counts = self.set.grid.counts();
        for corner in 0..1usize << D {
            let mut node = Some(0);
            for k in 0..D {
                let low = place[k].floor() + (corner >> k & 1) as f64;
                let index = (low >= 0.0 && low < counts[k] as f64).then(|| to_index(low));
                node = node.zip(index).map(|(node, index)| node * counts[k] + index);
            }
            if let Some(node) = node {
                self.try_on(node, place);
            }
        }
    }

    /// Whether a start leads to a closest point that is nearer than the one that is known.
    fn try_on(&mut self, node: usize, start: &SVector<f64, D>) {
        let grid = self.set.grid;
        let x = grid.position(node);
        let far = |place: &SVector<f64, D>| (grid.point(place) - x).norm();
        let reach = far(start);
        if let Some(known) = self.nearest[node] {
            // The foot to which a start of the same part leads is the one that is known; that of another part is nearer than its
            // start by what a step along the zero set makes of the distance.
            let apart = (grid.point(start) - grid.point(&known.place)).norm();
            let gain = self.step * self.step / known.distance.max(self.step);
            if known.is_foot && (apart < SAME_FOOT * self.step || reach > known.distance + gain) {
                return;
            }
        }
        let foot = self.set.foot(&x, start);
        let is_foot = matches!(foot.status, Status::Converged | Status::OnBoundary);
        let distance = far(&foot.place);
        let height = (foot.taylor.value / foot.taylor.gradient.norm()).abs();
        let is_on_set = is_foot || height <= ON_SET * self.set.size;
        let found = if is_on_set && distance <= reach * (1.0 + 1e-12) {
            Nearest { place: foot.place, distance, is_foot }
        } else {
            Nearest { place: *start, distance: reach, is_foot: false }
        };
        let is_better = self.nearest[node].is_none_or(|known| {
            found.distance < known.distance
                || found.is_foot && !known.is_foot && found.distance <= known.distance
        });
        if is_better {
            self.nearest[node] = Some(found);
            self.front.push(Front { distance: found.distance, node });
        }
    }

    /// Carries closest points from node to node up to a distance.
    fn carry(&mut self, band: f64) {
        let counts = self.set.grid.counts();
        while let Some(Front { distance, node }) = self.front.pop() {
            let Some(nearest) = self.nearest[node].filter(|nearest| nearest.distance == distance) else {
                continue;
            };
            if distance > band {
                return;
            }
            let mut at = [0; D];
            let mut rest = node;
            for k in (0..D).rev() {
                at[k] = rest % counts[k];
                rest /= counts[k];
            }
            for offset in 0..3usize.pow(u32::try_from(D).unwrap_or(3)) {
                let mut rest = offset;
                let mut other = Some(0);
                for k in 0..D {
                    let index = (at[k] + rest % 3).checked_sub(1).filter(|&index| index < counts[k]);
                    other = other.zip(index).map(|(sum, index)| sum * counts[k] + index);
                    rest /= 3;
                }
                if let Some(other) = other.filter(|&other| other != node) {
                    self.try_on(other, &nearest.place);
                }
            }
        }
    }
}

/// A whole number that is an index.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "between 0 and the number of nodes along an axis"
)]
fn to_index(value: f64) -> usize {
    value as usize
}
