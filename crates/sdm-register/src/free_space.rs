//! Whether a scan leaves free what another one saw through.
//!
//! Between a scanner and the points that it saw there is nothing. A pose that puts points of another scan there, in front of a
//! surface that was seen through them, contradicts the scan, however well the rest of the points fits.

use crate::{Doubt, parallel};
use mesh_core::CloudIndex;
use nalgebra::{Point3, Vector3};
use std::fmt;

/// Share of the normals that have to face the direction from which a scan was seen, for it to be one.
const FACING: f64 = 0.97;
/// Length of the mean of the unit normals from which it tells a direction.
const CLEAR: f64 = 0.4;
/// Rays around a point that all have to end behind it, and how far they may be from it, in spacings of the rays.
const RAYS: usize = 4;
const BESIDE: f64 = 2.0;
/// Most points that are tested, and points by which the spacing of the rays is measured.
const TESTED: usize = 4000;
const MEASURED: usize = 1000;
/// Floating points, and their share of those on rays, that contradict a pose; fewer may be outliers.
const FLOATING: usize = 30;
const CONTRADICTION: f64 = 0.1;
/// Share of the points of a scan that may lie in front of its own rays.
const OWN: f64 = 0.03;
/// Floating points over those that lie where the rays ended from which they are no outliers.
const PREVAILING: f64 = 0.75;

/// From where a scan was seen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Viewpoint {
    /// From a scanner at this place, in the frame of the scan.
    Origin(Vector3<f64>),
    /// From far away, in this direction from the scan.
    Direction(Vector3<f64>),
}

impl Viewpoint {
    /// The direction from which a scan was seen whose normals point to the scanner; `None` if they do not all face one direction, as
    /// those of several scans put together, or of one whose normals point to either side.
    #[must_use]
    pub fn of_normals(normals: &[Vector3<f64>]) -> Option<Self> {
        let units = || {
            normals.iter().filter_map(|n| n.try_normalize(0.0)).filter(|n| n.iter().all(|c| c.is_finite()))
        };
        let count = units().count();
        let mean = units().sum::<Vector3<f64>>() / count.max(1) as f64;
        let facing = units().filter(|n| n.dot(&mean) > 0.0).count();
        let is_one = mean.norm() >= CLEAR && facing as f64 >= FACING * count as f64;
        is_one.then(|| Self::Direction(mean.normalize()))
    }
}

/// What the rays of one scan say about the points of another.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct FreeSpace {
    /// Points that lie on rays of the scan.
    pub tested: usize,
    /// Those of them that lie where the rays ended, within the margin.
    pub meeting: usize,
    /// Those of them that float in front of what the rays met.
    pub floating: usize,
    /// Median of their distances in front of it; 0 where none floats.
    pub depth: f64,
}

/// The rays of a scan: where they passed, and how far they went.
#[derive(Debug)]
pub struct Rays {
    viewpoint: Viewpoint,
    /// Their ends on a sphere, or a plane, around the scanner.
    index: CloudIndex<3>,
    depths: Vec<f64>,
    /// The distance of neighbours on it.
    spacing: f64,
}

impl Rays {
    /// The rays of a scan in its own frame; `None` if the scan has too few points to tell.
    #[must_use]
    pub fn new(scan: &[Vector3<f64>], viewpoint: &Viewpoint) -> Option<Self> {
        let (ends, depths): (Vec<Point3<f64>>, Vec<f64>) =
            scan.iter().filter_map(|x| ray(viewpoint, x)).unzip();
        let index = CloudIndex::new(&ends).ok().filter(|_| ends.len() > RAYS)?;
        let step = ends.len().div_ceil(MEASURED).max(1);
        let mut spacings: Vec<f64> = ends
            .iter()
            .step_by(step)
            .filter_map(|end| index.nearest_n(end, RAYS).last().map(mesh_core::Neighbour::distance))
            .collect();
        let spacing = median(&mut spacings)?;
        Some(Self { viewpoint: *viewpoint, index, depths, spacing })
    }

    /// [`Rays::new`], unless the scan itself has surfaces behind others by more than `margin`, which no scanner at this viewpoint sees:
    /// files may state places of scanners for clouds that are from several, or from none.
    #[must_use]
    pub fn consistent(scan: &[Vector3<f64>], viewpoint: &Viewpoint, margin: f64) -> Option<Self> {
        // Half of the points on the rays of the other half: each would lie on its own one.
        let half = |first: usize| scan.iter().skip(first).step_by(2).copied().collect::<Vec<_>>();
        let own = Self::new(&half(0), viewpoint)?.meet(&half(1), margin);
        if own.share() <= OWN { Self::new(scan, viewpoint) } else { None }
    }

    /// Looks where the points of another scan, in the frame of this one, lie on its rays: those floating by more than `margin`, a
    /// length, contradict it.
    #[must_use]
    pub fn meet(&self, others: &[Vector3<f64>], margin: f64) -> FreeSpace {
        let step = others.len().div_ceil(TESTED).max(1);
        let some: Vec<&Vector3<f64>> = others.iter().step_by(step).collect();
        let found = parallel::map(some.len(), |k| {
            let (end, depth) = ray(&self.viewpoint, some[k])?;
            let near = self.index.nearest_n(&end, RAYS);
            let beside = near.last().is_none_or(|last| last.distance() > BESIDE * self.spacing);
            // Depths grow away from the scanner: all rays around the point have to go on behind it.
            let ahead = near.iter().map(|ray| self.depths[ray.index] - depth);
            let [least, nearest] = ahead.fold([f64::INFINITY; 2], |[least, nearest], ahead| {
                [least.min(ahead), nearest.min(ahead.abs())]
            });
            (!beside).then_some([least, nearest])
        });
        let found: Vec<[f64; 2]> = found.into_iter().flatten().collect();
        let ahead: Vec<f64> = found.iter().map(|one| one[0]).collect();
        let mut floating: Vec<f64> = ahead.iter().copied().filter(|ahead| *ahead > margin).collect();
        FreeSpace {
            tested: ahead.len(),
            meeting: found.iter().filter(|one| one[1] <= margin).count(),
            floating: floating.len(),
            depth: median(&mut floating).unwrap_or(0.0),
        }
    }
}

impl FreeSpace {
    /// What the rays of one scan say about another one: [`Rays::meet`] for a single pose.
    ///
    /// `None` if the scan has too few points to tell.
    #[must_use]
    pub fn of(
        scan: &[Vector3<f64>],
        viewpoint: &Viewpoint,
        others: &[Vector3<f64>],
        margin: f64,
    ) -> Option<Self> {
        Some(Rays::new(scan, viewpoint)?.meet(others, margin))
    }

    /// Whether so many points float that the pose contradicts the scan: a tenth of those on its rays, at least 30, and three quarters of
    /// those that lie where the rays ended. Outliers float as well, but where the pose is right they are the smaller part.
    #[must_use]
    pub fn doubt(&self) -> Option<Doubt> {
        let prevails = self.floating as f64 > PREVAILING * self.meeting as f64;
        (self.floating >= FLOATING && self.share() > CONTRADICTION && prevails).then_some(Doubt::FreeSpace)
    }

    /// Share of the points on rays that float.
    #[must_use]
    pub fn share(&self) -> f64 {
        self.floating as f64 / self.tested.max(1) as f64
    }
}

impl fmt::Display for FreeSpace {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let share = 100.0 * self.share();
        write!(
            f,
            "{share:.1} % of {} points on its rays float in front of what they met, by {:.3e}",
            self.tested, self.depth
        )
    }
}

/// Where the ray through a point ends on a sphere, or a plane, around the scanner, and how far along the ray the point lies; `None`
/// at the scanner itself.
fn ray(viewpoint: &Viewpoint, x: &Vector3<f64>) -> Option<(Point3<f64>, f64)> {
    let (end, depth) = match viewpoint {
        Viewpoint::Origin(origin) => {
            let offset = x - origin;
            let depth = offset.norm();
            (offset / depth, depth)
        }
        Viewpoint::Direction(towards) => {
            let depth = -x.dot(towards);
            (x + towards * depth, depth)
        }
    };
    (depth.is_finite() && end.iter().all(|c| c.is_finite())).then(|| (end.into(), depth))
}

fn median(values: &mut [f64]) -> Option<f64> {
    let middle = values.len() / 2;
    (!values.is_empty()).then(|| *values.select_nth_unstable_by(middle, f64::total_cmp).1)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn wall(z: f64) -> Vec<Vector3<f64>> {
        (0..2500u16).map(|i| Vector3::new(f64::from(i % 50), f64::from(i / 50), z)).collect()
    }

    #[test]
    fn points_between_scanner_and_wall_float() {
        let far = Viewpoint::Direction(Vector3::z());
        let near = Viewpoint::Origin(Vector3::new(25.0, 25.0, 60.0));
        for viewpoint in [far, near] {
            let in_front = FreeSpace::of(&wall(0.0), &viewpoint, &wall(5.0), 1.0).unwrap();
            assert!(in_front.share() > 0.99 && in_front.tested > 1500, "{in_front}");
            assert!(in_front.depth > 4.9 && in_front.depth < 8.0, "{in_front}");
            for z in [-5.0, 0.0, 0.5] {
                let other = FreeSpace::of(&wall(0.0), &viewpoint, &wall(z), 1.0).unwrap();
                assert_eq!(other.floating, 0, "{z}: {other}");
                assert_eq!(other.meeting > 0, z.abs() < 1.0, "{z}: {other}");
            }
            assert!(in_front.doubt().is_some());
            // A third of the points are outliers in front of the wall.
            let mixed: Vec<_> = wall(0.0).into_iter().chain(wall(5.0).into_iter().step_by(2)).collect();
            let outliers = FreeSpace::of(&wall(0.0), &viewpoint, &mixed, 1.0).unwrap();
            assert!(outliers.share() > 0.2 && outliers.doubt().is_none(), "{outliers}");
        }
        // Beside the wall there are no rays.
        let aside: Vec<_> = wall(5.0).iter().map(|x| x + Vector3::x() * 100.0).collect();
        assert_eq!(FreeSpace::of(&wall(0.0), &far, &aside, 1.0).unwrap().tested, 0);
        assert_eq!(FreeSpace::of(&[], &far, &aside, 1.0), None);
    }

    #[test]
    fn normals_to_all_sides_tell_no_direction() {
        let one = [Vector3::z(), Vector3::new(0.5, 0.0, 1.0), Vector3::new(0.0, -0.7, 1.0)];
        assert!(matches!(Viewpoint::of_normals(&one), Some(Viewpoint::Direction(w)) if w.z > 0.9));
        assert_eq!(Viewpoint::of_normals(&[Vector3::z(), -Vector3::z(), Vector3::x()]), None);
        assert_eq!(Viewpoint::of_normals(&[]), None);
        assert_eq!(Viewpoint::of_normals(&[Vector3::repeat(f64::NAN)]), None);
    }

    #[test]
    fn places_of_scanners_that_a_scan_contradicts_are_not_believed() {
        // Two walls one behind the other, seen from between them, and from in front of both.
        let both: Vec<_> = wall(0.0).into_iter().chain(wall(30.0)).collect();
        let between = Viewpoint::Origin(Vector3::new(25.0, 25.0, 15.0));
        let in_front = Viewpoint::Origin(Vector3::new(25.0, 25.0, 90.0));
        assert!(Rays::consistent(&both, &between, 1.0).is_some());
        assert!(Rays::new(&both, &in_front).is_some() && Rays::consistent(&both, &in_front, 1.0).is_none());
    }
}
