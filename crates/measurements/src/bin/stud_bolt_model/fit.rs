//! Where the bolt lies in its scan.

use crate::nominal::{self, PITCH};
use industrial_geometry::nurbs::nalgebra::{Matrix3, Point3, SMatrix, SVector, SymmetricEigen, Vector3};
use std::f64::consts::TAU;

/// Radial deviation in mm at which a point counts half (Cauchy weights): the scanner does not see to the bottom of every root.
const SCALE: f64 = 0.15;

/// Axis of the bolt and start of its thread.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Placement {
    /// A point on the axis, at the height of the centroid.
    pub(crate) origin: Vector3<f64>,
    /// Unit direction of the axis.
    pub(crate) axis: Vector3<f64>,
    /// Unit direction at right angles to the axis, from which angles are counted.
    pub(crate) e1: Vector3<f64>,
    /// Height of the middle of a crest at angle 0.
    pub(crate) phase: f64,
    /// 1 for a right-handed thread, −1 for a left-handed one.
    pub(crate) hand: f64,
}

impl Placement {
    fn new(origin: Vector3<f64>, axis: Vector3<f64>, phase: f64, hand: f64) -> Self {
        let axis = axis.normalize();
        Self { origin, axis, e1: axis.cross(&Vector3::z()).normalize(), phase, hand }
    }

    /// The point with these cylinder coordinates.
    pub(crate) fn point(&self, radius: f64, angle: f64, height: f64) -> Vector3<f64> {
        let e2 = self.axis.cross(&self.e1);
        self.origin + (self.e1 * angle.cos() + e2 * angle.sin()) * radius + self.axis * height
    }

    /// Radius, angle and height of a point.
    pub(crate) fn coordinates(&self, point: &Point3<f64>) -> [f64; 3] {
        let d = point.coords - self.origin;
        let (x, y) = (d.dot(&self.e1), d.dot(&self.axis.cross(&self.e1)));
        [x.hypot(y), y.atan2(x), d.dot(&self.axis)]
    }

    /// Radial deviation from the nominal thread.
    fn deviation(&self, point: &Point3<f64>) -> f64 {
        let [radius, angle, height] = self.coordinates(point);
        let position = (height - self.phase - PITCH * self.hand * angle / TAU) / PITCH;
        radius - nominal::radius(position - position.round())
    }

    /// The placement moved by two shifts and two tilts across the axis, and a shift of the phase.
    fn moved(&self, by: &SVector<f64, 5>) -> Self {
        let (e1, e2) = (self.e1, self.axis.cross(&self.e1));
        let origin = self.origin + e1 * by[0] + e2 * by[1];
        Self::new(origin, self.axis + e1 * by[2] + e2 * by[3], self.phase + by[4], self.hand)
    }
}

/// Fits the placement to the points between two heights; returns the weighted root mean square of the radial deviations too.
pub(crate) fn place(points: &[Point3<f64>], heights: [f64; 2]) -> Result<(Placement, f64), String> {
    let centroid = points.iter().map(|p| p.coords).sum::<Vector3<f64>>() / points.len() as f64;
    let spread: Matrix3<f64> =
        points.iter().map(|p| (p.coords - centroid) * (p.coords - centroid).transpose()).sum();
    let eigen = SymmetricEigen::new(spread);
    let axis: Vector3<f64> = eigen.eigenvectors.column(eigen.eigenvalues.imax()).into();
    // The direction of an eigenvector is arbitrary; along +x it is not.
    let axis = axis * axis.x.signum();
    let start = |hand, phase| Placement::new(centroid, axis, phase, hand);
    let [low, high] = heights;
    let is_thread = |p: &&Point3<f64>| (low..high).contains(&start(1.0, 0.0).coordinates(p)[2]);
    let thread: Vec<Point3<f64>> = points.iter().filter(is_thread).copied().collect();

    let mut best: Option<(Placement, f64)> = None;
    for hand in [1.0, -1.0] {
        for phase in 0..14 {
            let mut placement = start(hand, f64::from(phase) / 14.0 * PITCH);
            for _ in 0..30 {
                placement = placement.moved(&step(&placement, &thread)?);
            }
            let cost = cost(&placement, &thread);
            if best.is_none_or(|(_, lowest)| cost < lowest) {
                best = Some((placement, cost));
            }
        }
    }
    let (mut placement, _) = best.ok_or("there are no points on the thread")?;
    placement.phase = placement.phase.rem_euclid(PITCH);
    Ok((placement, weighted_rms(&placement, &thread)))
}

fn weight(deviation: f64) -> f64 {
    1.0 / (1.0 + (deviation / SCALE).powi(2))
}

/// Sum of the Cauchy losses.
fn cost(placement: &Placement, points: &[Point3<f64>]) -> f64 {
    points.iter().map(|p| (1.0 + (placement.deviation(p) / SCALE).powi(2)).ln()).sum()
}

fn weighted_rms(placement: &Placement, points: &[Point3<f64>]) -> f64 {
    let deviations: Vec<f64> = points.iter().map(|p| placement.deviation(p)).collect();
    let weights: f64 = deviations.iter().map(|&d| weight(d)).sum();
    (deviations.iter().map(|&d| weight(d) * d * d).sum::<f64>() / weights).sqrt()
}

/// One step of Gauss-Newton with weights; derivatives are central differences.
fn step(placement: &Placement, points: &[Point3<f64>]) -> Result<SVector<f64, 5>, String> {
    const H: f64 = 1e-5;
    let basis = |k: usize, h: f64| SVector::<f64, 5>::from_fn(|i, _| if i == k { h } else { 0.0 });
    let moved: [[Placement; 2]; 5] =
        std::array::from_fn(|k| [placement.moved(&basis(k, H)), placement.moved(&basis(k, -H))]);
    let mut matrix = SMatrix::<f64, 5, 5>::zeros();
    let mut right = SVector::<f64, 5>::zeros();
    for p in points {
        let deviation = placement.deviation(p);
        let gradient = SVector::<f64, 5>::from_fn(|k, _| {
            (moved[k][0].deviation(p) - moved[k][1].deviation(p)) / (2.0 * H)
        });
        let w = weight(deviation);
        matrix += gradient * gradient.transpose() * w;
        right -= gradient * (deviation * w);
    }
    matrix.cholesky().map(|factors| factors.solve(&right)).ok_or_else(|| "the fit is singular".to_owned())
}
