//! Whether a cloud is dense enough to show a surface.

use mesh_core::CloudIndex;
use nalgebra::{Matrix3, Point3, SymmetricEigen, Vector3};

use crate::neighbourhood::FLAT;
use crate::parallel;

/// Places of the cloud that are looked at, and the neighbours of each: as many as a surface of a cloud is estimated from.
const PLACES: usize = 400;
const NEIGHBOURS: usize = 24;
/// Share of the places with a surface below which the cloud shows none.
const HARDLY_ANY: f64 = 0.1;

/// Whether the neighbourhoods of a cloud show a surface: `false` where the points of a sheet, taken from both sides, are farther apart than
/// the sheet is thick, or noise is as large as the distance of neighbours.
///
/// Fewer than a tenth of the neighbourhoods of 24 points are flat then, of which nine in ten are on densely sampled parts with edges.
/// Of too few points nothing is known, and the answer is `true`.
#[must_use]
pub fn shows_a_surface(points: &[Point3<f64>]) -> bool {
    let finite: Vec<Point3<f64>> =
        points.iter().copied().filter(|p| p.iter().all(|c| c.is_finite())).collect();
    let Some(index) = CloudIndex::new(&finite).ok().filter(|_| finite.len() > NEIGHBOURS) else {
        return true;
    };
    let step = finite.len().div_ceil(PLACES).max(1);
    let places: Vec<usize> = (0..finite.len()).step_by(step).collect();
    let flat = parallel::map(places.len(), |k| {
        let near = index.nearest_n(&finite[places[k]], NEIGHBOURS + 1);
        let points = || near.iter().map(|n| finite[n.index].coords);
        let mean = points().sum::<Vector3<f64>>() / near.len().max(1) as f64;
        let spread = points().fold(Matrix3::zeros(), |sum, x| sum + (x - mean) * (x - mean).transpose());
        if !spread.iter().all(|value| value.is_finite()) {
            return true;
        }
        let mut widths: [f64; 3] = SymmetricEigen::new(spread).eigenvalues.into();
        widths.sort_by(f64::total_cmp);
        widths[0] <= FLAT * widths[1]
    });
    flat.iter().filter(|flat| **flat).count() as f64 >= HARDLY_ANY * places.len() as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::start::random::Random;

    /// Both sides of a plate of 100 by 60.
    fn plate(count: usize, thickness: f64) -> Vec<Point3<f64>> {
        let mut random = Random::new(3);
        let side = |k: usize| if k.is_multiple_of(2) { 0.0 } else { thickness };
        (0..count).map(|k| Point3::new(100.0 * random.unit(), 60.0 * random.unit(), side(k))).collect()
    }

    #[test]
    fn a_plate_whose_points_are_farther_apart_than_its_sides_shows_none() {
        assert!(!shows_a_surface(&plate(4000, 2.0)));
        assert!(shows_a_surface(&plate(40_000, 2.0)));
        assert!(shows_a_surface(&plate(4000, 20.0)));
        // Seen from so far that both sides are one.
        assert!(shows_a_surface(&plate(400, 0.5)));
        assert!(shows_a_surface(&plate(10, 2.0)));
        assert!(shows_a_surface(&[]));
    }
}
