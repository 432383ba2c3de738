//! Shortest ways around polygons in the plane, exact.

use super::Lattice;
use super::sight::Polygon;
use crate::{Error, parallel};
use nalgebra::Vector2;

/// A source and polygonal obstacles in a rectangle.
///
/// The shortest way to a point bends at convex corners of the obstacles only, so that its length is the least sum of the distance of
/// a corner from the source and of the corner from the point, over the corners in sight. Boundaries of obstacles are free.
#[derive(Clone, Debug)]
pub struct Scene {
    polygons: Vec<Polygon>,
    /// The source first, then the corners that can be reached, by their distance from the source.
    roots: Vec<Root>,
}

/// Where ways from the source bend.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Root {
    point: Vector2<f64>,
    distance: f64,
    /// The root before it.
    before: usize,
}

/// A shortest way.
#[derive(Clone, Debug, PartialEq)]
pub struct Path {
    /// From the source to the target.
    pub points: Vec<Vector2<f64>>,
    /// Its length.
    pub length: f64,
}

impl Scene {
    /// The scene in the rectangle from `low` to `high`, which ways do not leave. Obstacles may reach beyond it, and overlap.
    ///
    /// # Errors
    /// [`Error::Grid`] for numbers that are not finite, polygons without area, or a source inside of one or outside of the rectangle.
    pub fn new(
        low: Vector2<f64>,
        high: Vector2<f64>,
        source: Vector2<f64>,
        obstacles: &[Vec<Vector2<f64>>],
    ) -> Result<Self, Error> {
        let fail = |what: String| Error::Grid { what };
        let is_finite = |p: &Vector2<f64>| p.iter().all(|c| c.is_finite());
        if ![low, high, source].iter().all(is_finite) {
            return Err(fail("the rectangle and the source of a scene must be finite".to_owned()));
        }
        let is_within = |p: &Vector2<f64>| (0..2).all(|k| low[k] <= p[k] && p[k] <= high[k]);
        if !is_within(&source) {
            return Err(fail(format!("the source {:?} lies outside of the scene", source.as_slice())));
        }
        let mut polygons = Vec::with_capacity(obstacles.len());
        for (index, vertices) in obstacles.iter().enumerate() {
            if !vertices.iter().all(is_finite) {
                return Err(fail(format!("obstacle {index} (from 0) has a vertex that is not finite")));
            }
            let polygon = Polygon::new(vertices).ok_or_else(|| {
                fail(format!("obstacle {index} (from 0) has no area: give three vertices or more"))
            })?;
            polygons.push(polygon);
        }
        if let Some(index) = polygons.iter().position(|polygon| polygon.holds(&source)) {
            return Err(fail(format!("the source lies inside of obstacle {index} (from 0)")));
        }
        let mut corners: Vec<Vector2<f64>> = polygons.iter().flat_map(Polygon::corners).collect();
        corners.retain(|p| is_within(p) && !polygons.iter().any(|polygon| polygon.holds(p)));
        let mut scene = Self { polygons, roots: vec![Root { point: source, distance: 0.0, before: 0 }] };
        scene.reach(corners);
        Ok(scene)
    }

    /// Finds the distances of the corners, in the order of their distances (Dijkstra on the visibility graph).
    fn reach(&mut self, mut open: Vec<Vector2<f64>>) {
        let mut tentative = vec![(f64::INFINITY, 0usize); open.len()];
        let mut latest = 0;
        loop {
            let root = self.roots[latest];
            for (corner, best) in open.iter().zip(&mut tentative) {
                let distance = root.distance + (corner - root.point).norm();
                if distance < best.0 && self.sees(&root.point, corner) {
                    *best = (distance, latest);
                }
            }
            let nearest = (0..open.len()).min_by(|&i, &j| tentative[i].0.total_cmp(&tentative[j].0));
            let Some(nearest) = nearest.filter(|&i| tentative[i].0.is_finite()) else { return };
            let (distance, before) = tentative.swap_remove(nearest);
            let point = open.swap_remove(nearest);
            self.roots.push(Root { point, distance, before });
            latest = self.roots.len() - 1;
        }
    }

    fn sees(&self, p: &Vector2<f64>, q: &Vector2<f64>) -> bool {
        !self.polygons.iter().any(|polygon| polygon.blocks(p, q))
    }

    /// Whether a point lies inside of an obstacle, not on its boundary.
    #[must_use]
    pub fn is_blocked(&self, x: &Vector2<f64>) -> bool {
        self.polygons.iter().any(|polygon| polygon.holds(x))
    }

    /// The last bend on the shortest way to a free point, and the length; `guess` is a root that is likely.
    fn root_of(&self, x: &Vector2<f64>, guess: usize) -> Option<(usize, f64)> {
        let mut best: Option<(usize, f64)> = None;
        let order = std::iter::once(guess).chain(0..self.roots.len());
        for (place, index) in order.enumerate() {
            let root = &self.roots[index];
            let least = best.map_or(f64::INFINITY, |(_, least)| least);
            // Those that follow are farther from the source alone.
            if place > 0 && root.distance >= least {
                break;
            }
            let length = root.distance + (x - root.point).norm();
            if length < least && self.sees(&root.point, x) {
                best = Some((index, length));
            }
        }
        best
    }

    /// The length of the shortest way to a point: infinite where there is none, `None` inside of an obstacle.
    #[must_use]
    pub fn distance(&self, x: &Vector2<f64>) -> Option<f64> {
        (!self.is_blocked(x)).then(|| self.root_of(x, 0).map_or(f64::INFINITY, |(_, length)| length))
    }

    /// The lengths of the shortest ways to the nodes of a grid: −1 inside of obstacles, infinite where there is no way.
    #[must_use]
    pub fn distances(&self, lattice: &Lattice<2>) -> Vec<f64> {
        let mut values = vec![f64::INFINITY; lattice.len()];
        parallel::fill(&mut values, lattice.counts()[1], |first, row| {
            // The root of a neighbour is a likely one.
            let mut guess = 0;
            for (column, value) in row.iter_mut().enumerate() {
                let x = lattice.point(first + column);
                if self.is_blocked(&x) {
                    *value = -1.0;
                } else if let Some((root, length)) = self.root_of(&x, guess) {
                    (guess, *value) = (root, length);
                }
            }
        });
        values
    }

    /// The shortest way to a point; `None` if there is none.
    #[must_use]
    pub fn path(&self, target: &Vector2<f64>) -> Option<Path> {
        if self.is_blocked(target) {
            return None;
        }
        let (mut root, length) = self.root_of(target, 0)?;
        let mut points = vec![*target];
        loop {
            let Root { point, before, .. } = self.roots[root];
            if points.last() != Some(&point) {
                points.push(point);
            }
            if root == 0 {
                break;
            }
            root = before;
        }
        points.reverse();
        Some(Path { points, length })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn square(low: f64, high: f64) -> Vec<Vector2<f64>> {
        [[low, low], [high, low], [high, high], [low, high]].map(Vector2::from).to_vec()
    }

    fn scene(source: [f64; 2], obstacles: &[Vec<Vector2<f64>>]) -> Result<Scene, Error> {
        Scene::new(Vector2::zeros(), Vector2::new(1.0, 1.0), source.into(), obstacles)
    }

    #[test]
    fn ways_bend_at_corners() {
        let scene = scene([0.1, 0.1], &[square(0.25, 0.75)]).unwrap();
        let target = Vector2::new(0.9, 0.9);
        let path = scene.path(&target).unwrap();
        let half = (0.65f64).hypot(0.15);
        assert!((path.length - 2.0 * half).abs() < 1e-15);
        assert_eq!(path.points.len(), 3);
        assert_eq!(scene.distance(&Vector2::new(0.5, 0.5)), None);
        assert_eq!(scene.distance(&Vector2::new(0.1, 0.6)), Some(0.5));
        // On the boundary.
        assert_eq!(scene.distance(&Vector2::new(0.25, 0.25)), Some((0.15f64).hypot(0.15)));
    }

    #[test]
    fn what_is_walled_in_cannot_be_reached() {
        // A ring of four walls that overlap at their ends.
        let wall = |x: [f64; 2], y: [f64; 2]| {
            [[x[0], y[0]], [x[1], y[0]], [x[1], y[1]], [x[0], y[1]]].map(Vector2::from).to_vec()
        };
        let walls = [
            wall([0.2, 0.8], [0.2, 0.3]),
            wall([0.2, 0.8], [0.7, 0.8]),
            wall([0.2, 0.3], [0.2, 0.8]),
            wall([0.7, 0.8], [0.2, 0.8]),
        ];
        let scene = scene([0.1, 0.1], &walls).unwrap();
        assert_eq!(scene.distance(&Vector2::new(0.5, 0.5)), Some(f64::INFINITY));
        assert_eq!(scene.path(&Vector2::new(0.5, 0.5)), None);
        let lattice = Lattice::new(Vector2::zeros(), Vector2::new(1.0, 1.0), [11, 11]).unwrap();
        let values = scene.distances(&lattice);
        assert!(values[5 * 11 + 5].is_infinite() && values[11 * 10 + 10] > 1.2);
    }

    #[test]
    fn bad_scenes_are_refused() {
        assert!(scene([0.5, 0.5], &[square(0.25, 0.75)]).is_err());
        assert!(scene([1.5, 0.5], &[]).is_err());
        assert!(scene([0.5, f64::NAN], &[]).is_err());
        assert!(scene([0.1, 0.1], &[vec![Vector2::zeros(), Vector2::x()]]).is_err());
    }
}
