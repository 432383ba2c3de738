//! Poses that lay principal axes on principal axes.

use nalgebra::{Matrix3, Rotation3, SymmetricEigen, Vector3};

use super::{OrientedPoints, placement::Placement};

/// Squared axes whose ratio is nearer to 1 than this do not tell their directions.
const TIE: f64 = 0.25;

/// Rotations about an axis whose partners tie.
const TURNS: usize = 12;

/// Mean and principal axes of points, the axes a right-handed system with variances in decreasing order.
struct Inertia {
    mean: Vector3<f64>,
    axes: Matrix3<f64>,
    variances: [f64; 3],
}

impl Inertia {
    fn new(points: &[Vector3<f64>]) -> Self {
        let count = points.len().max(1) as f64;
        let mean = points.iter().sum::<Vector3<f64>>() / count;
        let mut covariance = Matrix3::zeros();
        for point in points {
            let offset = point - mean;
            covariance += offset * offset.transpose() / count;
        }
        let eigen = SymmetricEigen::new(covariance);
        let mut order = [0, 1, 2];
        order.sort_by(|&i, &j| eigen.eigenvalues[j].total_cmp(&eigen.eigenvalues[i]));
        let [first, second] = [0, 1].map(|i| eigen.eigenvectors.column(order[i]).into_owned());
        Self {
            mean,
            axes: Matrix3::from_columns(&[first, second, first.cross(&second)]),
            variances: order.map(|i| eigen.eigenvalues[i]),
        }
    }

    fn tie(&self, i: usize) -> bool {
        self.variances[i + 1] > (1.0 - TIE) * self.variances[i]
    }
}

/// The mean of points, and their principal axes as the columns of a rotation.
pub(crate) fn principal_axes(points: &[Vector3<f64>]) -> (Vector3<f64>, Matrix3<f64>) {
    let Inertia { mean, axes, .. } = Inertia::new(points);
    (mean, axes)
}

/// The four rotations that keep the order of the axes; where two variances nearly tie, rotations about the third axis in
/// between as well; where all three do, none is preferred and all the rotations of a cube, turned about each axis, are tried.
pub(crate) fn candidates(cloud: &OrientedPoints, model: &OrientedPoints) -> Vec<Placement> {
    let (from, to) = (Inertia::new(cloud.points()), Inertia::new(model.points()));
    let ties = [0, 1].map(|i| from.tie(i) || to.tie(i));
    let turn = |axis: Vector3<f64>, count: usize| -> Vec<Matrix3<f64>> {
        let angle = std::f64::consts::TAU / count as f64;
        (0..count).map(|k| Rotation3::from_scaled_axis(axis * (angle * k as f64)).into_inner()).collect()
    };
    let (about_x, about_z) = (turn(Vector3::x(), 2), turn(Vector3::z(), 2));
    let halves = product(&about_x, &about_z);
    let rotations = match ties {
        [false, false] => halves,
        [true, false] => product(&turn(Vector3::z(), TURNS), &about_x),
        [false, true] => product(&turn(Vector3::x(), TURNS), &about_z),
        [true, true] => product(
            &product(&turn(Vector3::z(), TURNS), &turn(Vector3::x(), TURNS / 2)),
            &turn(Vector3::z(), TURNS),
        ),
    };
    rotations
        .into_iter()
        .map(|inner| {
            let rotation = to.axes * inner * from.axes.transpose();
            Placement { rotation, shift: to.mean - rotation * from.mean }
        })
        .collect()
}

fn product(left: &[Matrix3<f64>], right: &[Matrix3<f64>]) -> Vec<Matrix3<f64>> {
    left.iter().flat_map(|a| right.iter().map(move |b| a * b)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Points on the axes of an ellipsoid and one more that breaks all symmetries.
    fn body(sides: [f64; 3]) -> OrientedPoints {
        let mut points = vec![Vector3::new(0.01, 0.02, 0.03)];
        for (axis, side) in sides.into_iter().enumerate() {
            for sign in [-1.0, 1.0] {
                points.push(Vector3::ith(axis, sign * side));
            }
        }
        let normals = vec![Vector3::z(); points.len()];
        OrientedPoints::new(&points, &normals).unwrap()
    }

    fn best(sides: [f64; 3]) -> (usize, f64) {
        let model = body(sides);
        let motion = Rotation3::from_euler_angles(1.0, -2.0, 0.7);
        let moved: Vec<_> = model.points().iter().map(|x| motion * x + Vector3::new(3.0, 1.0, 2.0)).collect();
        let cloud = OrientedPoints::new(&moved, model.normals()).unwrap();
        let all = candidates(&cloud, &model);
        let error = |placement: &Placement| {
            let gaps = moved.iter().zip(model.points()).map(|(x, y)| (placement.apply(x) - y).norm());
            gaps.fold(0.0, f64::max)
        };
        (all.len(), all.iter().map(error).fold(f64::INFINITY, f64::min))
    }

    #[test]
    fn one_of_the_candidates_is_the_pose() {
        let (count, error) = best([3.0, 2.0, 1.0]);
        assert_eq!(count, 4);
        assert!(error < 1e-12, "{error}");
        // Near ties: within half a turn of 30° of the pose.
        for (sides, expected) in [([2.0, 2.0, 1.0], 24), ([2.0, 1.0, 1.0], 24), ([2.0, 2.0, 2.0], 864)] {
            let (count, error) = best(sides);
            assert_eq!(count, expected);
            assert!(error < 2.0 * 0.7, "{error}");
        }
    }
}
