//! The search for the nearest triangle, of one point or of many that lie close together.

use nalgebra::Point3;

use crate::bounds::is_finite;
use crate::bvh::Aabb;
use crate::triangle::TriangleFoot;
use crate::{Error, MeshFootpoint, MeshProjector, parallel};

/// Distances of feet are rounded by less than this share of the coordinates.
const ROUNDING: f64 = 16.0 * f64::EPSILON;
/// Points that share a search: a block of 4 by 4 by 4 nodes of a grid.
const PACKET: usize = 64;
/// Most leaves of the hierarchy that a packet looks at one after the other: with more of them a search of its own costs a point less.
const LEAVES: usize = 384;

/// The triangle that is nearest to a point.
pub(crate) struct Nearest {
    pub(crate) place: usize,
    pub(crate) foot: TriangleFoot,
    /// How far the point may move while it stays the nearest.
    pub(crate) slack: f64,
}

/// What is known of the nearest triangle so far.
struct Search<'a> {
    projector: &'a MeshProjector,
    x: &'a Point3<f64>,
    /// Feet are rounded by units of the coordinates: boxes that are farther by no more than that may hold the nearest one, or
    /// one as near with a smaller index. With this margin the answer is the least of all, wherever the search begins.
    margin: f64,
    best: Option<usize>,
    /// Squared distances: of the best, of the nearest other that was met, and beyond which nothing is looked for.
    limit: f64,
    others: f64,
    enough: f64,
}

impl<'a> Search<'a> {
    fn new(
        projector: &'a MeshProjector,
        x: &'a Point3<f64>,
        guess: Option<usize>,
        rounding: f64,
        wanted: f64,
    ) -> Self {
        let distance_sq = guess.map_or(f64::INFINITY, |place| projector.triangles[place].distance_sq(x));
        let is_known = distance_sq < f64::INFINITY;
        let mut search = Self {
            projector,
            x,
            margin: rounding + wanted,
            best: guess.filter(|_| is_known),
            limit: if is_known { distance_sq } else { f64::INFINITY },
            others: f64::INFINITY,
            enough: f64::INFINITY,
        };
        search.enough = search.bound();
        search
    }

    fn bound(&self) -> f64 {
        (self.limit.sqrt() + self.margin).powi(2)
    }

    /// Looks at a triangle; returns the squared distance beyond which no box is of interest.
    #[inline]
    fn visit(&mut self, place: usize) -> f64 {
        let triangle = &self.projector.triangles[place];
        if self.best == Some(place) || triangle.box_distance_sq(self.x) > self.enough {
            return self.enough;
        }
        let distance_sq = triangle.distance_sq(self.x);
        let indices = &self.projector.indices;
        let is_nearer = distance_sq < self.limit
            || distance_sq == self.limit && self.best.is_some_and(|best| indices[place] < indices[best]);
        if is_nearer {
            self.others = self.others.min(self.limit);
            (self.limit, self.best) = (distance_sq, Some(place));
            self.enough = self.bound();
        } else {
            self.others = self.others.min(distance_sq);
        }
        self.enough
    }

    fn found(self, rounding: f64) -> Option<Nearest> {
        let slack = (0.5 * (self.others.min(self.enough).sqrt() - self.limit.sqrt()) - rounding).max(0.0);
        let place = self.best?;
        Some(Nearest { place, foot: self.projector.triangles[place].closest(self.x), slack })
    }
}

/// A leaf of the hierarchy that may hold the nearest triangle of a point of a packet.
struct Leaf {
    bounds: Aabb,
    first: usize,
    last: usize,
    /// Squared distance from the middle of the packet.
    away: f64,
}

impl MeshProjector {
    fn rounding(&self, x: &Point3<f64>) -> f64 {
        ROUNDING * (self.reach + x.coords.amax())
    }

    /// The nearest triangle and its foot; the search begins at the distance of a guess, and goes on for `wanted` beyond the nearest.
    pub(crate) fn nearest(&self, x: &Point3<f64>, guess: Option<usize>, wanted: f64) -> Option<Nearest> {
        let rounding = self.rounding(x);
        let mut search = Search::new(self, x, guess, rounding, wanted);
        self.bvh.nearest_where(x, search.enough, |_| true, |place| search.visit(place));
        search.found(rounding)
    }

    /// The closest points to many points, in their order, on all threads. See [`MeshProjector::project`].
    #[must_use]
    pub fn project_many(&self, points: &[Point3<f64>]) -> Vec<Result<MeshFootpoint, Error>> {
        self.map_feet(points, |_, foot| foot)
    }

    /// `f(i, foot)` of the closest point to each point `i`, in their order, on all threads: [`MeshProjector::project_many`] for what of the
    /// closest points is wanted.
    pub fn map_feet<T: Send>(
        &self,
        points: &[Point3<f64>],
        f: impl Fn(usize, Result<MeshFootpoint, Error>) -> T + Sync,
    ) -> Vec<T> {
        parallel::packets(points, PACKET, |indices, out| self.packet(points, indices, &f, out))
    }

    /// The closest points of points next to each other.
    ///
    /// Of the triangles only those count that are no farther from the middle `c` of the points than the nearest is, and twice the
    /// radius `r` of the points: `d(c, t) ≤ d(x, t) + r`, and `d(x, t) ≤ d(c) + r` for the triangle `t` that is nearest to `x`. Feet are
    /// the same as those of [`MeshProjector::project`], bit for bit.
    fn packet<T>(
        &self,
        points: &[Point3<f64>],
        indices: &[u32],
        f: &impl Fn(usize, Result<MeshFootpoint, Error>) -> T,
        out: &mut Vec<T>,
    ) {
        let at = |index: &u32| &points[*index as usize];
        let mut guess = None;
        let leaves = if indices.iter().map(at).all(is_finite) {
            let (low, high) = indices.iter().map(at).fold(
                (Point3::from([f64::INFINITY; 3]), Point3::from([f64::NEG_INFINITY; 3])),
                |(a, b), x| (a.inf(x), b.sup(x)),
            );
            let middle = nalgebra::center(&low, &high);
            self.leaves_near(&middle, 0.5 * (high - low).norm(), &mut guess)
        } else {
            None
        };
        for index in indices {
            let x = at(index);
            let found = if is_finite(x) {
                let rounding = self.rounding(x);
                let mut search = Search::new(self, x, guess, rounding, 0.0);
                match &leaves {
                    Some(leaves) => {
                        for leaf in leaves {
                            if leaf.bounds.distance_sq(x) <= search.enough {
                                for place in leaf.first..leaf.last {
                                    search.visit(place);
                                }
                            }
                        }
                    }
                    None => {
                        self.bvh.nearest_where(x, search.enough, |_| true, |place| search.visit(place));
                    }
                }
                search.found(rounding).ok_or(Error::DistanceOverflow { x: x.x, y: x.y, z: x.z }).map(
                    |Nearest { place, foot, .. }| {
                        guess = Some(place);
                        self.footpoint(x, place, foot)
                    },
                )
            } else {
                Err(Error::NonFinitePoint { x: x.x, y: x.y, z: x.z })
            };
            out.push(f(*index as usize, found));
        }
    }

    /// The leaves that may hold the nearest triangle of a point within a radius, nearest first; `None` where there are many. `guess` becomes
    /// the nearest triangle of the middle.
    fn leaves_near(&self, middle: &Point3<f64>, radius: f64, guess: &mut Option<usize>) -> Option<Vec<Leaf>> {
        let nearest = self.nearest(middle, None, 0.0)?;
        *guess = Some(nearest.place);
        let reach = nearest.foot.distance_sq.sqrt() + 2.0 * (radius + self.rounding(middle));
        // Rounding of the middle, of the radius and of the boxes of larger points.
        let reach = reach * (1.0 + ROUNDING) + ROUNDING * radius;
        let mut leaves = Vec::with_capacity(LEAVES);
        let is_short = self.bvh.leaves_within(middle, reach * reach, |places, bounds, away| {
            leaves.push(Leaf { bounds: *bounds, first: places.start, last: places.end, away });
            leaves.len() < LEAVES
        });
        leaves.sort_by(|a, b| a.away.total_cmp(&b.away));
        is_short.then_some(leaves)
    }
}
