//! The normal equations of one step: quadratic models summed up in the unknowns of a motion.

use crate::motion::rotation::cross;
use crate::motion::{MAX_UNKNOWNS, rigid_unknowns, rotations};
use nalgebra::{SMatrix, SVector, Vector3};

/// A square matrix in the unknowns of a step.
pub(crate) type Matrix = SMatrix<f64, MAX_UNKNOWNS, MAX_UNKNOWNS>;
/// A vector of the unknowns of a step.
pub(crate) type Unknowns = SVector<f64, MAX_UNKNOWNS>;

/// Half the second order expansion of `Σ ωᵢ F_i(xᵢ + v(xᵢ))` in the unknowns `u` of the velocity:
/// `½ cost + bᵀu + ½ uᵀHu` (\[P05, sec. 5\]).
///
/// Points are relative to the origin of the motion. The unknowns are the translation, the rotation and the growth. All
/// error terms have the same `b`; of `H` there are the part that all have and what two of them add.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct NormalSystem<const D: usize> {
    /// `H` of the tangent term: only directions in which the foot cannot move. `JᵀJ` of a Gauss-Newton method.
    pub(crate) tangent: Matrix,
    /// What the chosen error term adds to it.
    pub(crate) term: Matrix,
    /// What the exact second derivatives add to it, but for those of the motion.
    pub(crate) taylor: Matrix,
    /// `b`, half the gradient of the cost.
    pub(crate) vector: Unknowns,
    /// `S = Σ ω g xᵀ` with the half gradients `g = x − f`: all that the second order of the motion needs.
    pub(crate) moment: SMatrix<f64, D, D>,
    /// `G = Σ ω g`.
    pub(crate) force: SVector<f64, D>,
    /// `Σ ω F(x)`.
    pub(crate) cost: f64,
    /// `Σ ω d²`.
    pub(crate) squares: f64,
    /// `Σ ω`.
    pub(crate) weight: f64,
    /// Number of points with a weight.
    pub(crate) count: usize,
}

impl<const D: usize> Default for NormalSystem<D> {
    fn default() -> Self {
        Self {
            tangent: Matrix::zeros(),
            term: Matrix::zeros(),
            taylor: Matrix::zeros(),
            vector: Unknowns::zeros(),
            moment: SMatrix::zeros(),
            force: SVector::zeros(),
            cost: 0.0,
            squares: 0.0,
            weight: 0.0,
            count: 0,
        }
    }
}

impl<const D: usize> NormalSystem<D> {
    /// Adds the gradient `ω g` at `x`, along the direction `e`: `slope` is `ω ⟨e, g⟩`, `row` that of `e` at `x`.
    #[inline]
    pub(crate) fn add_gradient(&mut self, row: &Unknowns, slope: f64) {
        self.vector += row * slope;
    }

    /// Adds what the second order of the motion needs: the half gradient `ω g` at `x`.
    #[inline]
    pub(crate) fn add_moment(&mut self, gradient: &SVector<f64, D>, x: &SVector<f64, D>) {
        self.moment += gradient * x.transpose();
        self.force += gradient;
    }

    /// Adds the sums of other points.
    pub(crate) fn merge(&mut self, other: &Self) {
        self.tangent += other.tangent;
        self.term += other.term;
        self.taylor += other.taylor;
        self.vector += other.vector;
        self.moment += other.moment;
        self.force += other.force;
        self.cost += other.cost;
        self.squares += other.squares;
        self.weight += other.weight;
        self.count += other.count;
    }

    /// Copies the upper triangle, which is what the sums fill, to the lower one.
    pub(crate) fn mirror(&mut self) {
        for matrix in [&mut self.tangent, &mut self.term, &mut self.taylor] {
            matrix.fill_lower_triangle_with_upper_triangle();
        }
    }

    /// Adds the second order of a unit that grows with the cloud to the exact second derivatives: half of `e^{-2g} Σ ω d²` in the
    /// growth `g` and the other unknowns `u`, beyond the squares of the rows, is `−g Σ ω d ⟨row, (u, g)⟩ + ½ g² Σ ω d²` with the
    /// rows before the growth of the unit is taken from them.
    pub(crate) fn add_second_order_of_unit(&mut self) {
        let growth = rigid_unknowns(D);
        for i in 0..growth {
            self.taylor[(i, growth)] -= self.vector[i];
            self.taylor[(growth, i)] -= self.vector[i];
        }
        self.taylor[(growth, growth)] -= 2.0 * self.vector[growth] + self.squares;
    }

    /// The second derivatives that come from the motion, not from the models, for the helical motion of a velocity:
    /// `Σ ω ⟨g, ½ A (A x + c̄)⟩` with `A` the matrix of `c ×`. In the rotation this is `sym S − tr(S) I`; with the
    /// translation it is `½ G ×`, which vanishes at an unconstrained minimum.
    pub(crate) fn helical_curvature(&self) -> Matrix {
        let mut out = self.pivot_curvature(&SVector::zeros());
        let n = rotations(D);
        for k in 0..n {
            let mut axis = Vector3::zeros();
            axis[k] = 1.0;
            // ⟨G, e_k × c̄⟩ = ⟨G, W c̄⟩.
            let share = cross::<D>(&axis).tr_mul(&self.force) * 0.5;
            for i in 0..D {
                out[(i, D + k)] += share[i];
                out[(D + k, i)] += share[i];
            }
        }
        out
    }

    /// The same for a turn about a pivot that itself moves on a straight line; the unknowns are the velocity of the
    /// pivot, the rotation and the growth about it.
    pub(crate) fn pivot_curvature(&self, pivot: &SVector<f64, D>) -> Matrix {
        let moment = self.moment - self.force * pivot.transpose();
        let mut out = Matrix::zeros();
        let (n, growth) = (rotations(D), rigid_unknowns(D));
        for k in 0..n {
            for l in 0..n {
                let (mut a, mut b) = (Vector3::zeros(), Vector3::zeros());
                a[k] = 1.0;
                b[l] = 1.0;
                let (a, b) = (cross::<D>(&a), cross::<D>(&b));
                // Σ ⟨g, ½ (AB + BA) x⟩ = ½ ⟨AB + BA, S⟩.
                out[(D + k, D + l)] = 0.5 * (a * b + b * a).dot(&moment);
            }
            let mut axis = Vector3::zeros();
            axis[k] = 1.0;
            let share = cross::<D>(&axis).dot(&moment);
            out[(D + k, growth)] = share;
            out[(growth, D + k)] = share;
        }
        out[(growth, growth)] = moment.trace();
        out
    }
}

/// Adds `factor · row rowᵀ` to the upper triangle of a matrix in the unknowns of a motion in `R^D`.
#[inline]
pub(crate) fn add_square<const D: usize>(matrix: &mut Matrix, row: &Unknowns, factor: f64) {
    let used = rigid_unknowns(D) + 1;
    for j in 0..used {
        let scaled = factor * row[j];
        for i in 0..=j {
            matrix[(i, j)] += scaled * row[i];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Velocity;

    /// Half of Σ |s R x + t − f|² after a motion: its second differences are the matrix that Newton's method needs.
    fn cost(points: &[[Vector3<f64>; 2]], u: &Unknowns, pivot: Option<&Vector3<f64>>) -> f64 {
        let v = Velocity::<3>::from_unknowns(u);
        let step = pivot.map_or_else(|| v.helical(), |q| about(&v, q));
        0.5 * points.iter().map(|[x, f]| (step.apply(x) - f).norm_squared()).sum::<f64>()
    }

    /// The turn about a pivot, the unknowns being those of the pivot.
    fn about(v: &Velocity<3>, pivot: &Vector3<f64>) -> crate::Displacement<3> {
        let shifted =
            Velocity { translation: v.translation - v.rotation.cross(pivot) - pivot * v.growth, ..*v };
        shifted.about(pivot)
    }

    #[test]
    fn second_differences_of_the_motion() {
        let points = [
            [Vector3::new(1.0, 0.2, -0.3), Vector3::new(0.4, 0.7, 0.1)],
            [Vector3::new(-0.5, 1.2, 0.8), Vector3::new(-1.0, 1.5, 0.0)],
            [Vector3::new(0.3, -0.9, 0.4), Vector3::new(0.9, -0.2, 1.1)],
        ];
        let pivot = Vector3::new(0.7, -1.1, 0.2);
        for pivot in [None, Some(pivot)] {
            let mut system = NormalSystem::<3>::default();
            let origin = pivot.unwrap_or_else(Vector3::zeros);
            for [x, f] in &points {
                for i in 0..3 {
                    let e = Vector3::from_fn(|j, _| f64::from(u8::from(i == j)));
                    let row = Velocity::<3>::row(&e, &(x - origin));
                    add_square::<3>(&mut system.tangent, &row, 1.0);
                    system.add_gradient(&row, (x - f)[i]);
                }
                system.add_moment(&(x - f), x);
            }
            system.mirror();
            let curvature = match &pivot {
                None => system.helical_curvature(),
                Some(pivot) => system.pivot_curvature(pivot),
            };
            let hessian = system.tangent + curvature;
            let h = 1e-3;
            for i in 0..7 {
                for j in 0..7 {
                    let at = |a: f64, b: f64| {
                        let mut u = Unknowns::zeros();
                        u[i] += a * h;
                        u[j] += b * h;
                        cost(&points, &u, pivot.as_ref())
                    };
                    let second =
                        (at(1.0, 1.0) - at(1.0, -1.0) - at(-1.0, 1.0) + at(-1.0, -1.0)) / (4.0 * h * h);
                    assert!(
                        (second - hessian[(i, j)]).abs() < 1e-4,
                        "{pivot:?} {i} {j}: {second} {}",
                        hessian[(i, j)]
                    );
                }
                let mut u = Unknowns::zeros();
                u[i] = h;
                let first =
                    (cost(&points, &u, pivot.as_ref()) - cost(&points, &-u, pivot.as_ref())) / (2.0 * h);
                assert!((first - system.vector[i]).abs() < 1e-4);
            }
        }
    }
}
