//! Polygonal lines.

use nalgebra::{Point, SVector};

use crate::bvh::{Aabb, Bvh};
use crate::{Error, parallel};

/// Straight segments from vertex to vertex in the plane (`D` = 2) or in space (`D` = 3), open or closed.
///
/// Vertices are finite, and there are at least two; they may coincide. Segment `i` joins the vertices `i` and `i + 1`;
/// in a closed polyline the last one leads back to vertex 0.
///
/// ```
/// use mesh_core::{Polyline, nalgebra::Point2};
///
/// let corners = [(0.0, 0.0), (4.0, 0.0), (4.0, 3.0)].map(|(x, y)| Point2::new(x, y));
/// let triangle = Polyline::new(corners.to_vec(), true)?;
/// assert_eq!((triangle.segment_count(), triangle.length()), (3, 12.0));
/// let foot = triangle.closest(&Point2::new(3.0, -2.0))?;
/// assert_eq!((foot.segment, foot.parameter, foot.vertex, foot.distance), (0, 0.75, None, 2.0));
/// # Ok::<(), mesh_core::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct Polyline<const D: usize> {
    vertices: Vec<Point<f64, D>>,
    closed: bool,
    /// Length from vertex 0 to the beginning of each segment, and the whole length.
    lengths: Vec<f64>,
    bvh: Bvh<D>,
}

/// The closest point on a polyline.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PolylineFootpoint<const D: usize> {
    /// Index of the segment; the smallest where several are equally near.
    pub segment: usize,
    /// Place on the segment, 0 at its first vertex, 1 at its second.
    pub parameter: f64,
    /// The vertex, if the closest point is one; otherwise it lies within the segment.
    pub vertex: Option<usize>,
    /// The closest point.
    pub point: Point<f64, D>,
    /// Distance to it.
    pub distance: f64,
    /// Length of the polyline from vertex 0 to the closest point.
    pub arc_length: f64,
}

impl<const D: usize> Polyline<D> {
    /// A polyline through the vertices.
    ///
    /// # Errors
    /// [`Error::TooFew`] for less than two vertices, [`Error::NonFiniteVertex`] for the first vertex that is not finite,
    /// [`Error::TooMany`] beyond 32-bit indices.
    pub fn new(vertices: Vec<Point<f64, D>>, closed: bool) -> Result<Self, Error> {
        let count = vertices.len();
        if count < 2 {
            return Err(Error::TooFew { what: "vertices", count, least: 2 });
        }
        if u32::try_from(count).is_err() {
            return Err(Error::TooMany { what: "vertices", count });
        }
        if let Some(index) = vertices.iter().position(|vertex| !vertex.iter().all(|value| value.is_finite()))
        {
            return Err(Error::NonFiniteVertex { index });
        }
        let segments = if closed { count } else { count - 1 };
        let ends = |segment: usize| [vertices[segment], vertices[(segment + 1) % count]];
        let boxes: Vec<_> = (0..segments).map(|segment| Aabb::of_points(&ends(segment))).collect();
        let mut lengths = Vec::with_capacity(segments + 1);
        let mut length = 0.0;
        lengths.push(length);
        for segment in 0..segments {
            let [from, to] = ends(segment);
            length += (to - from).norm();
            lengths.push(length);
        }
        Ok(Self { bvh: Bvh::new(&boxes), vertices, closed, lengths })
    }

    /// The vertices.
    #[must_use]
    pub fn vertices(&self) -> &[Point<f64, D>] {
        &self.vertices
    }

    /// Whether the last vertex is joined to the first.
    #[must_use]
    pub const fn is_closed(&self) -> bool {
        self.closed
    }

    /// Number of segments.
    #[must_use]
    pub const fn segment_count(&self) -> usize {
        self.lengths.len() - 1
    }

    /// Both ends of a segment, if it exists.
    #[must_use]
    pub fn segment(&self, segment: usize) -> Option<[Point<f64, D>; 2]> {
        (segment < self.segment_count()).then(|| self.ends(segment))
    }

    /// Sum of the lengths of the segments.
    #[must_use]
    pub fn length(&self) -> f64 {
        self.lengths[self.segment_count()]
    }

    /// Lengths from vertex 0 to the beginnings of all segments, and the whole length.
    #[must_use]
    pub fn cumulative_lengths(&self) -> &[f64] {
        &self.lengths
    }

    /// The point at a length from vertex 0, held between the ends; on a closed polyline lengths repeat instead.
    #[must_use]
    pub fn point_at(&self, arc_length: f64) -> Point<f64, D> {
        let whole = self.length();
        let s = if self.closed && whole > 0.0 {
            arc_length.rem_euclid(whole)
        } else {
            arc_length.clamp(0.0, whole)
        };
        let segment = self.lengths[1..].partition_point(|&end| end < s).min(self.segment_count() - 1);
        let [from, to] = self.ends(segment);
        let length = self.lengths[segment + 1] - self.lengths[segment];
        let parameter = if length > 0.0 { (s - self.lengths[segment]) / length } else { 0.0 };
        from + (to - from) * parameter
    }

    /// Unit direction of a segment; `None` if it does not exist or has no length.
    #[must_use]
    pub fn direction(&self, segment: usize) -> Option<SVector<f64, D>> {
        self.segment(segment).and_then(|[from, to]| (to - from).try_normalize(0.0))
    }

    /// The closest point to `x`.
    ///
    /// # Errors
    /// [`Error::NonFiniteQuery`] if a coordinate of `x` is not finite or the squared distance overflows.
    pub fn closest(&self, x: &Point<f64, D>) -> Result<PolylineFootpoint<D>, Error> {
        let mut best: Option<(f64, usize, f64, Point<f64, D>)> = None;
        if x.iter().all(|value| value.is_finite()) {
            let mut limit = f64::INFINITY;
            self.bvh.nearest(x, |place| {
                let segment = self.bvh.order[place] as usize;
                let (parameter, point) = self.closest_on_segment(segment, x);
                let distance_sq = (x - point).norm_squared();
                let tied = best.is_some_and(|(least, other, ..)| distance_sq == least && segment < other);
                if distance_sq < limit || tied {
                    limit = distance_sq;
                    best = Some((distance_sq, segment, parameter, point));
                }
                limit
            });
        }
        let (distance_sq, segment, parameter, point) =
            best.ok_or_else(|| Error::NonFiniteQuery { x: x.iter().copied().collect() })?;
        let next = (segment + 1) % self.vertices.len();
        let vertex = if parameter == 0.0 { Some(segment) } else { Some(next).filter(|_| parameter == 1.0) };
        let length = self.lengths[segment + 1] - self.lengths[segment];
        Ok(PolylineFootpoint {
            segment,
            parameter,
            vertex,
            point,
            distance: distance_sq.sqrt(),
            arc_length: self.lengths[segment] + parameter * length,
        })
    }

    /// The closest points to many points, in their order, on all threads. See [`Polyline::closest`].
    #[must_use]
    pub fn closest_many(&self, points: &[Point<f64, D>]) -> Vec<Result<PolylineFootpoint<D>, Error>> {
        parallel::map(points, |i| self.closest(&points[i]))
    }

    fn ends(&self, segment: usize) -> [Point<f64, D>; 2] {
        [self.vertices[segment], self.vertices[(segment + 1) % self.vertices.len()]]
    }

    fn closest_on_segment(&self, segment: usize, x: &Point<f64, D>) -> (f64, Point<f64, D>) {
        let [from, to] = self.ends(segment);
        let along = to - from;
        let parameter = (x - from).dot(&along) / along.norm_squared();
        // A segment without length gives NaN and counts as its start.
        if parameter >= 1.0 {
            (1.0, to)
        } else if parameter > 0.0 {
            (parameter, from + along * parameter)
        } else {
            (0.0, from)
        }
    }
}
