//! Nearest neighbours in a cloud.

use std::cmp::Ordering;
use std::num::NonZeroUsize;

use nalgebra::Point;

use crate::kd_tree::KdTree;
use crate::{Error, parallel};

/// How much farther than those of the query before the neighbours of a query are expected to be at most.
const MARGIN: f64 = 1.15;

/// A point of a cloud near a query.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Neighbour {
    /// Index of the point in the cloud.
    pub index: usize,
    /// Squared distance from the query.
    pub distance_sq: f64,
}

impl Neighbour {
    /// Distance from the query.
    #[must_use]
    pub fn distance(&self) -> f64 {
        self.distance_sq.sqrt()
    }
}

/// Answers nearest neighbour queries on points in the plane (`D` = 2) or in space (`D` = 3).
///
/// Built once per cloud in O(n log n); a query takes O(log n) in practice. Points that are not finite are left out
/// and counted ([`CloudIndex::skipped`]). Any number of points may share a position. Where distances are equal,
/// smaller indices come first, so that answers depend on cloud and query alone. Queries that are not finite, or so
/// far away that the squared distance overflows, have no neighbours, and neither has any query on an empty cloud.
///
/// ```
/// use mesh_core::{CloudIndex, nalgebra::Point2};
///
/// let index = CloudIndex::new(&[Point2::new(0.0, 0.0), Point2::new(f64::NAN, 0.0), Point2::new(3.0, 4.0)])?;
/// assert_eq!((index.len(), index.skipped()), (2, 1));
/// let nearest = index.nearest(&Point2::new(3.0, 3.0)).unwrap();
/// assert_eq!((nearest.index, nearest.distance_sq), (2, 1.0));
/// assert_eq!(index.within(&Point2::origin(), 5.0).len(), 2);
/// # Ok::<(), mesh_core::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct CloudIndex<const D: usize> {
    /// The different positions, numbered by their first points; `None` if there is no finite point.
    tree: Option<KdTree<D>>,
    /// Indices of the points by position, ascending within a position.
    members: Vec<u32>,
    /// Where the points of each position begin in `members`, and the end of the last; `None` if no two points
    /// share a position.
    starts: Option<Vec<u32>>,
    /// Position of each point, `u32::MAX` of one that is not finite; `None` where every point is a position of its own.
    positions: Option<Vec<u32>>,
    skipped: usize,
}

impl<const D: usize> CloudIndex<D> {
    /// Prepares a cloud for queries.
    ///
    /// # Errors
    /// [`Error::TooMany`] beyond 32-bit indices.
    pub fn new(points: &[Point<f64, D>]) -> Result<Self, Error> {
        if u32::try_from(points.len()).is_err() {
            return Err(Error::TooMany { what: "points", count: points.len() });
        }
        let finite: Vec<u32> = (points.iter().zip(0u32..))
            .filter(|(point, _)| point.iter().all(|value| value.is_finite()))
            .map(|(_, index)| index)
            .collect();
        let skipped = points.len() - finite.len();
        let (members, starts) = group_by_position(points, finite);
        let coordinates = |index: u32| points[index as usize].coords.into();
        let positions: Vec<[f64; D]> = match &starts {
            Some(starts) => (starts[..starts.len() - 1].iter())
                .map(|&start| coordinates(members[start as usize]))
                .collect(),
            None => members.iter().copied().map(coordinates).collect(),
        };
        let tree = KdTree::new(&positions)?;
        let mut index = Self { tree, members, starts, positions: None, skipped };
        if skipped > 0 || index.starts.is_some() {
            let mut of_points = vec![u32::MAX; points.len()];
            for position in (0u32..).take(positions.len()) {
                for &member in index.points_at(position) {
                    of_points[member as usize] = position;
                }
            }
            index.positions = Some(of_points);
        }
        Ok(index)
    }

    /// Number of points that take part.
    #[must_use]
    pub const fn len(&self) -> usize {
        self.members.len()
    }

    /// Whether no point takes part, so that no query has an answer.
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.members.is_empty()
    }

    /// Number of points left out because a coordinate is not finite.
    #[must_use]
    pub const fn skipped(&self) -> usize {
        self.skipped
    }

    /// Number of points that share their position with a point of smaller index.
    #[must_use]
    pub fn repeated(&self) -> usize {
        self.starts.as_ref().map_or(0, |starts| self.members.len() + 1 - starts.len())
    }

    /// The nearest point, the one of smallest index where several are equally near.
    #[must_use]
    pub fn nearest(&self, x: &Point<f64, D>) -> Option<Neighbour> {
        self.nearest_near(x, None)
    }

    /// [`CloudIndex::nearest`], in less time if the nearest point is the one of the given index or near it; which point is given
    /// does not change the answer.
    #[must_use]
    pub fn nearest_near(&self, x: &Point<f64, D>, guess: Option<usize>) -> Option<Neighbour> {
        let guess = guess.and_then(|index| match &self.positions {
            Some(positions) => positions.get(index).copied(),
            None => u32::try_from(index).ok(),
        });
        let (distance_sq, position) = self.tree_for(x)?.nearest(&x.coords.into(), guess);
        // Positions are numbered by their first points, so the smallest number is that of the smallest index.
        // So far away that all squared distances overflow, no point is the nearest.
        let index = distance_sq.is_finite().then(|| self.points_at(position).first()).flatten()?;
        Some(Neighbour { index: *index as usize, distance_sq })
    }

    /// The nearest point, as [`CloudIndex::nearest`] tells it, if it lies within a distance; takes less time than that where
    /// few points do. A radius that is NaN or negative contains nothing.
    #[must_use]
    pub fn nearest_within(&self, x: &Point<f64, D>, radius: f64) -> Option<Neighbour> {
        let limit_sq = radius * radius;
        let tree = self.tree_for(x).filter(|_| radius >= 0.0)?;
        let mut best: Option<(f64, u32)> = None;
        tree.visit_within(&x.coords.into(), limit_sq.min(f64::MAX), |distance_sq, position| {
            // As in `nearest`: the smallest position of those that are equally near.
            let is_nearer = best
                .is_none_or(|(least, first)| distance_sq < least || distance_sq == least && position < first);
            if distance_sq <= limit_sq && is_nearer {
                best = Some((distance_sq, position));
            }
        });
        let (distance_sq, position) = best.filter(|(distance_sq, _)| distance_sq.is_finite())?;
        Some(Neighbour { index: *self.points_at(position).first()? as usize, distance_sq })
    }

    /// The `count` nearest points, nearest first; fewer if the cloud has no more.
    #[must_use]
    pub fn nearest_n(&self, x: &Point<f64, D>, count: usize) -> Vec<Neighbour> {
        let mut found = Vec::new();
        self.nearest_n_into(x, count, &mut Vec::new(), &mut found);
        found
    }

    /// All points up to a distance, nearest first. A radius that is NaN or negative contains nothing.
    #[must_use]
    pub fn within(&self, x: &Point<f64, D>, radius: f64) -> Vec<Neighbour> {
        let mut found = Vec::new();
        let limit_sq = radius * radius;
        if let Some(tree) = self.tree_for(x).filter(|_| radius >= 0.0) {
            tree.visit_within(&x.coords.into(), limit_sq.min(f64::MAX), |distance_sq, position| {
                if distance_sq <= limit_sq && distance_sq.is_finite() {
                    found.extend(self.neighbours_at(position, distance_sq));
                }
            });
        }
        sort(&mut found);
        found
    }

    /// [`CloudIndex::nearest`] for many points, in their order, on all threads.
    #[must_use]
    pub fn nearest_many(&self, points: &[Point<f64, D>]) -> Vec<Option<Neighbour>> {
        parallel::map(points, |i| self.nearest(&points[i]))
    }

    /// `f(i, neighbours)` of the `count` nearest neighbours of every point `i`, in order, on all threads.
    ///
    /// See [`CloudIndex::nearest_n`]. Nothing is kept of the neighbours but what `f` makes of them.
    pub fn map_nearest_n<T: Send>(
        &self,
        points: &[Point<f64, D>],
        count: usize,
        f: impl Fn(usize, &[Neighbour]) -> T + Sync,
    ) -> Vec<T> {
        let scratch = || (Vec::new(), Vec::new(), None);
        parallel::map_with(points, scratch, |(positions, found, before), i| {
            let x = &points[i];
            let expected = before.map(|radius: f64| radius * MARGIN);
            if !self.nearest_n_within(x, count, expected, found) {
                self.nearest_n_into(x, count, positions, found);
            }
            *before = found.last().map(Neighbour::distance);
            f(i, found)
        })
    }

    /// `f(i, neighbours)` of all points up to a distance from every point `i`, in order, on all threads.
    ///
    /// See [`CloudIndex::within`]. Nothing is kept of the neighbours but what `f` makes of them.
    pub fn map_within<T: Send>(
        &self,
        points: &[Point<f64, D>],
        radius: f64,
        f: impl Fn(usize, &[Neighbour]) -> T + Sync,
    ) -> Vec<T> {
        parallel::map(points, |i| f(i, &self.within(&points[i], radius)))
    }

    /// [`CloudIndex::nearest_n`] where so many points lie within the radius; else `false`, and nothing is found.
    ///
    /// Takes less time if the radius is little more than needed.
    fn nearest_n_within(
        &self,
        x: &Point<f64, D>,
        count: usize,
        radius: Option<f64>,
        found: &mut Vec<Neighbour>,
    ) -> bool {
        found.clear();
        let (Some(tree), Some(radius)) = (self.tree_for(x), radius) else { return false };
        let limit_sq = radius * radius;
        tree.visit_within(&x.coords.into(), limit_sq, |distance_sq, position| {
            if distance_sq <= limit_sq {
                // No more of one position: many points may share it.
                found.extend(self.neighbours_at(position, distance_sq).take(count));
            }
        });
        let is_enough = found.len() >= count && limit_sq.is_finite();
        if is_enough && count > 0 {
            if found.len() > count {
                found.select_nth_unstable_by(count - 1, by_distance);
                found.truncate(count);
            }
            found.sort_unstable_by(by_distance);
        }
        is_enough
    }

    /// [`CloudIndex::nearest_n`] into memory that is used again.
    fn nearest_n_into(
        &self,
        x: &Point<f64, D>,
        count: usize,
        positions: &mut Vec<(f64, u32)>,
        found: &mut Vec<Neighbour>,
    ) {
        positions.clear();
        found.clear();
        let (Some(tree), Some(count)) = (self.tree_for(x), NonZeroUsize::new(count)) else { return };
        tree.nearest_n(&x.coords.into(), count, positions);
        for &(distance_sq, position) in positions.iter().filter(|(distance_sq, _)| distance_sq.is_finite()) {
            found.extend(self.neighbours_at(position, distance_sq).take(count.get()));
        }
        sort(found);
        found.truncate(count.get());
    }

    fn tree_for(&self, x: &Point<f64, D>) -> Option<&KdTree<D>> {
        self.tree.as_ref().filter(|_| x.iter().all(|value| value.is_finite()))
    }

    fn points_at(&self, position: u32) -> &[u32] {
        let position = position as usize;
        match &self.starts {
            Some(starts) => &self.members[starts[position] as usize..starts[position + 1] as usize],
            None => &self.members[position..=position],
        }
    }

    fn neighbours_at(&self, position: u32, distance_sq: f64) -> impl Iterator<Item = Neighbour> {
        self.points_at(position).iter().map(move |&index| Neighbour { index: index as usize, distance_sq })
    }
}

fn sort(neighbours: &mut [Neighbour]) {
    neighbours.sort_unstable_by(by_distance);
}

fn by_distance(one: &Neighbour, other: &Neighbour) -> Ordering {
    // Bits of numbers that are not negative are in the order of the numbers.
    let key = |near: &Neighbour| u128::from(near.distance_sq.to_bits()) << 64 | near.index as u128;
    key(one).cmp(&key(other))
}

/// Groups ascending indices by position, groups in the order of their first indices, and says where groups begin;
/// `None` where every group has one member.
fn group_by_position<const D: usize>(
    points: &[Point<f64, D>],
    indices: Vec<u32>,
) -> (Vec<u32>, Option<Vec<u32>>) {
    // Both zeros are one position.
    let key = |index: u32| points[index as usize].coords.map(|value| (value + 0.0).to_bits());
    let hash = |index: u32| {
        key(index).iter().fold(0u64, |hash, &bits| {
            let product = u128::from(hash ^ bits ^ 0x9e37_79b9_7f4a_7c15) * 0xd129_0d7b_53a4_1be5;
            #[expect(clippy::cast_possible_truncation, reason = "both halves are mixed")]
            let halves = (product as u64, (product >> 64) as u64);
            halves.0 ^ halves.1
        })
    };
    let mut hashed: Vec<(u64, u32)> = indices.iter().map(|&index| (hash(index), index)).collect();
    hashed.sort_unstable();
    if hashed.windows(2).all(|pair| pair[0].0 != pair[1].0) {
        return (indices, None);
    }
    // Different positions may share a hash.
    for equal in hashed.chunk_by_mut(|one, other| one.0 == other.0) {
        equal.sort_unstable_by(|one, other| {
            key(one.1).iter().cmp(key(other.1).iter()).then(one.1.cmp(&other.1))
        });
    }
    let mut groups: Vec<&[(u64, u32)]> =
        hashed.chunk_by(|one, other| one.0 == other.0 && key(one.1) == key(other.1)).collect();
    groups.sort_unstable_by_key(|group| group[0].1);
    let mut members = Vec::with_capacity(indices.len());
    let mut starts = vec![0u32];
    for group in groups {
        members.extend(group.iter().map(|&(_, index)| index));
        starts.extend(starts.last().map(|&start| start + group.iter().map(|_| 1u32).sum::<u32>()));
    }
    (members, Some(starts))
}
