//! One step of a registration whose points are on many machines: exact sums of parts, and the step that follows from them.
//!
//! The step is that of Gauss and Newton for the distances from the tangent planes at the footpoints (Chen and Medioni). Points whose
//! feet lie on the boundary of an open shape do not count. All sums are exact, so that the step is the same to the bit for any
//! tiles in any order.

use industrial_geometry::inspection::{Deviation, ExactSum, Nominal, Outcome, Place};
use industrial_geometry::mesh::nalgebra::{Matrix3, Matrix6, Point3, SymmetricEigen, Vector3, Vector6};
use industrial_geometry::register::{RegisterOptions, Velocity};
use serde::{Deserialize, Serialize};

/// Entries of the upper triangle of the matrix.
const ENTRIES: usize = 21;
/// Distance, as a share of the size of the model, below which the direction to a foot is rounding.
const NEAR: f64 = 1e-9;

/// Sums of the normal equations of a step, in the unknowns (translation, rotation vector) about an origin.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct StepSums {
    /// Origin of the motion and size of the model, as bits of doubles.
    frame: [u64; 4],
    /// Points that count.
    points: u64,
    /// `Σ r²` of the distances `r` from the tangent planes.
    squares: ExactSum,
    /// `Σ row rowᵀ`, the upper triangle by rows.
    matrix: Vec<ExactSum>,
    /// `Σ row r`.
    vector: Vec<ExactSum>,
}

impl crate::report::Results for Step {}

/// The step that follows from sums.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct Step {
    /// Points that count.
    pub(crate) points_used: u64,
    /// Root mean square of the distances from the tangent planes before the step.
    pub(crate) rms: f64,
    /// Origin of the motion: the centre of the model.
    pub(crate) origin: [f64; 3],
    /// `Σ row rowᵀ` by rows, in the unknowns (translation, rotation vector) about the origin.
    pub(crate) normal_matrix: [[f64; 6]; 6],
    /// `Σ row r`.
    pub(crate) normal_vector: [f64; 6],
    /// Translation of the origin, and rotation vector.
    pub(crate) step: [f64; 6],
    /// How far the points move, as a share of the size of the model.
    pub(crate) motion: f64,
    /// Motions that the points do not determine, and which are not made.
    pub(crate) free: usize,
    /// The pose after the step: the matrix by rows that takes the points of the files to the model.
    pub(crate) matrix: [[f64; 4]; 4],
}

impl StepSums {
    /// No points yet; `None` for a model without surfaces.
    pub(crate) fn new(nominal: &Nominal) -> Option<Self> {
        let bounds = nominal.bounds()?;
        let centre = bounds.min.coords * 0.5 + bounds.max.coords * 0.5;
        let frame = [centre.x, centre.y, centre.z, bounds.diagonal()].map(f64::to_bits);
        let zeros = |count| vec![ExactSum::default(); count];
        Some(Self {
            frame,
            points: 0,
            squares: ExactSum::default(),
            matrix: zeros(ENTRIES),
            vector: zeros(6),
        })
    }

    fn origin(&self) -> Vector3<f64> {
        Vector3::from_fn(|axis, _| f64::from_bits(self.frame[axis]))
    }

    fn size(&self) -> f64 {
        f64::from_bits(self.frame[3])
    }

    /// Adds points, where they were moved to, with what was measured of them.
    pub(crate) fn extend(&mut self, points: &[Point3<f64>], measured: &[(usize, Deviation)]) {
        let (origin, near) = (self.origin(), NEAR * self.size());
        for (index, deviation) in measured {
            let Some(point) = points.get(*index) else { continue };
            if deviation.outcome != Outcome::Measured || deviation.on_boundary {
                continue;
            }
            let to_point = point - deviation.foot;
            let length = to_point.norm();
            // On edges and vertices the distance grows along the line from the foot, not along a normal.
            let is_sharp =
                matches!(deviation.place, Place::TriangleEdge | Place::Vertex | Place::Edge | Place::Corner);
            let direction = if is_sharp && length > near { to_point / length } else { deviation.normal };
            let residual = direction.dot(&to_point);
            let turn = (point.coords - origin).cross(&direction);
            let row = [direction.x, direction.y, direction.z, turn.x, turn.y, turn.z];
            if !residual.is_finite() || row.iter().any(|value| !value.is_finite()) {
                continue;
            }
            self.points += 1;
            self.squares.add_square(residual);
            let mut entries = self.matrix.iter_mut();
            for (i, a) in row.iter().enumerate() {
                row[i..].iter().zip(&mut entries).for_each(|(b, sum)| sum.add(a * b));
            }
            self.vector.iter_mut().zip(row).for_each(|(sum, a)| sum.add(a * residual));
        }
    }

    /// Adds the sums of other points; false if they are about another origin, or damaged.
    pub(crate) fn merge(&mut self, other: &Self) -> bool {
        if self.frame != other.frame || (other.matrix.len(), other.vector.len()) != (ENTRIES, 6) {
            return false;
        }
        self.points = self.points.saturating_add(other.points);
        self.squares.merge(&other.squares);
        let sums = self.matrix.iter_mut().chain(&mut self.vector);
        sums.zip(other.matrix.iter().chain(&other.vector)).for_each(|(sum, more)| sum.merge(more));
        true
    }

    /// The step from a pose; `None` if the points determine no motion at all.
    pub(crate) fn step(&self, pose: Option<[[f64; 4]; 4]>) -> Option<Step> {
        let mut entries = self.matrix.iter().map(ExactSum::value);
        let mut matrix = Matrix6::zeros();
        for i in 0..6 {
            for j in i..6 {
                matrix[(i, j)] = entries.next()?;
                matrix[(j, i)] = matrix[(i, j)];
            }
        }
        let vector = Vector6::from_iterator(self.vector.iter().map(ExactSum::value));
        let (origin, size) = (self.origin(), self.size());
        // Turns are measured by the way of a point at half of the size, so that all unknowns are lengths.
        let half = 0.5 * size;
        let scale = Vector6::new(1.0, 1.0, 1.0, 1.0 / half, 1.0 / half, 1.0 / half);
        let scaled = Matrix6::from_fn(|i, j| matrix[(i, j)] * scale[i] * scale[j]);
        let largest = scaled.amax();
        if self.points == 0 || !(largest > 0.0 && largest.is_finite()) {
            return None;
        }
        let eigen = SymmetricEigen::new(scaled);
        let limit = RegisterOptions::<3>::default().null_tolerance * eigen.eigenvalues.max();
        let target = vector.component_mul(&scale);
        let mut step = Vector6::zeros();
        let mut free = 0;
        for (axis, value) in eigen.eigenvectors.column_iter().zip(eigen.eigenvalues.iter()) {
            if *value > limit {
                step -= axis * (axis.dot(&target) / value);
            } else {
                free += 1;
            }
        }
        let motion = step.norm() / size;
        let step = step.component_mul(&scale);
        let velocity = Velocity::<3> {
            translation: step.fixed_rows::<3>(0).into_owned(),
            rotation: step.fixed_rows::<3>(3).into_owned(),
            growth: 0.0,
        };
        let moved = velocity.helical();
        let rows =
            pose.unwrap_or([[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0; 4]]);
        let linear = moved.rotation * Matrix3::from_fn(|row, column| rows[row][column]);
        let before = Vector3::from_fn(|row, _| rows[row][3]);
        let translation = moved.rotation * (before - origin) + moved.translation + origin;
        let row = |i: usize| [linear[(i, 0)], linear[(i, 1)], linear[(i, 2)], translation[i]];
        Some(Step {
            points_used: self.points,
            rms: self.squares.root_mean(self.points),
            origin: origin.into(),
            normal_matrix: [0, 1, 2, 3, 4, 5].map(|i| [0, 1, 2, 3, 4, 5].map(|j| matrix[(i, j)])),
            normal_vector: vector.into(),
            step: step.into(),
            motion,
            free,
            matrix: [row(0), row(1), row(2), [0.0, 0.0, 0.0, 1.0]],
        })
    }
}
