//! Linear side conditions on the unknowns.

use crate::Error;
use crate::freedom::Freedom;
use crate::layout::Factor;
use crate::shape::ActiveShape;
use nalgebra::{DMatrix, DVector, SVector};
use std::collections::BTreeMap;

/// Share of the largest singular value below which conditions depend on each other.
const DEPENDENT: f64 = 1e-12;
/// What may be left of a condition, as a share of its coefficients, before it counts as contradictory.
const CONTRADICTION: f64 = 1e-6;

/// `Σ ⟨aⱼ, dⱼ⟩ = value`.
#[derive(Clone, Debug, PartialEq)]
pub struct LinearCondition<const D: usize> {
    /// Coefficients of the shape with their factors `aⱼ`.
    pub terms: Vec<(usize, SVector<f64, D>)>,
    /// The right hand side.
    pub value: f64,
}

/// Side conditions of a fit: coefficients that stay, and linear equations.
///
/// Conditions may depend on each other but not contradict. Their cost is that of one solution of the system for each
/// equation; held coefficients, and a plane for each coefficient, cost nothing.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct Constraints<const D: usize> {
    /// Coefficients with a given place.
    pub held: BTreeMap<usize, SVector<f64, D>>,
    /// Equations between the others.
    pub conditions: Vec<LinearCondition<D>>,
}

impl<const D: usize> Constraints<D> {
    /// No side conditions.
    #[must_use]
    pub fn none() -> Self {
        Self { held: BTreeMap::new(), conditions: Vec::new() }
    }

    /// Whether there are none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.held.is_empty() && self.conditions.is_empty()
    }

    /// Gives a coefficient its place.
    #[must_use]
    pub fn with_held(mut self, coefficient: usize, place: SVector<f64, D>) -> Self {
        self.held.insert(coefficient, place);
        self
    }

    /// The shape passes through a point at a parameter.
    #[must_use]
    pub fn with_point<S: ActiveShape<D>>(
        mut self,
        shape: &S,
        parameter: [f64; 2],
        point: &SVector<f64, D>,
    ) -> Self {
        let cell = shape.cell(parameter);
        let columns = shape.cells().columns(cell);
        let mut values = vec![0.0; columns.len()];
        shape.basis(parameter, cell, &mut values);
        for c in 0..D {
            let axis = SVector::from_fn(|i, _| if i == c { 1.0 } else { 0.0 });
            let terms = columns.iter().zip(&values).filter(|(_, v)| **v != 0.0);
            let terms = terms.map(|(&column, &v)| (column, axis * v)).collect();
            self.conditions.push(LinearCondition { terms, value: point[c] });
        }
        self
    }

    /// The difference of two coefficients is parallel to a direction (not 0), as at the end of a clamped curve whose
    /// tangent is given.
    #[must_use]
    pub fn with_direction(mut self, from: usize, to: usize, direction: &SVector<f64, D>) -> Self {
        for normal in normals(direction) {
            self.conditions.push(LinearCondition { terms: vec![(to, normal), (from, -normal)], value: 0.0 });
        }
        self
    }

    /// A coefficient stays in the plane `⟨normal, d⟩ = offset` (a line in the plane).
    #[must_use]
    pub fn with_plane(mut self, coefficient: usize, normal: SVector<f64, D>, offset: f64) -> Self {
        self.conditions.push(LinearCondition { terms: vec![(coefficient, normal)], value: offset });
        self
    }

    /// Coefficients lie in one plane with the given normal, whose height is free (\[P05, sec. 4.5\], layers).
    #[must_use]
    pub fn with_parallel(mut self, coefficients: &[usize], normal: SVector<f64, D>) -> Self {
        for pair in coefficients.windows(2) {
            let terms = vec![(pair[1], normal), (pair[0], -normal)];
            self.conditions.push(LinearCondition { terms, value: 0.0 });
        }
        self
    }

    /// Two coefficients are mirror images in the plane `⟨normal, d⟩ = offset` (`normal` of length 1); one that is its own
    /// image lies in it.
    #[must_use]
    pub fn with_mirror(mut self, first: usize, second: usize, normal: SVector<f64, D>, offset: f64) -> Self {
        if first == second {
            return self.with_plane(first, normal, offset);
        }
        // Equal along the plane, opposite across it.
        for tangent in normals(&normal) {
            self.conditions
                .push(LinearCondition { terms: vec![(first, tangent), (second, -tangent)], value: 0.0 });
        }
        self.conditions
            .push(LinearCondition { terms: vec![(first, normal), (second, normal)], value: 2.0 * offset });
        self
    }
}

/// Orthonormal vectors normal to a direction.
pub(crate) fn normals<const D: usize>(direction: &SVector<f64, D>) -> Vec<SVector<f64, D>> {
    let mut known: Vec<SVector<f64, D>> = direction.try_normalize(0.0).into_iter().collect();
    let given = known.len();
    let mut axes: Vec<usize> = (0..D).collect();
    // The axes furthest from the direction first.
    axes.sort_by(|&a, &b| direction[a].abs().total_cmp(&direction[b].abs()));
    for axis in axes.into_iter().take(D - given) {
        let mut v = SVector::from_fn(|i, _| if i == axis { 1.0 } else { 0.0 });
        for _ in 0..2 {
            for other in &known {
                v -= other * other.dot(&v);
            }
        }
        known.extend(v.try_normalize(1e-9));
    }
    known.split_off(given)
}

/// Side conditions made ready for the loop.
#[derive(Clone, Debug)]
pub(crate) struct Prepared<const D: usize> {
    /// What is held or stays in a plane.
    pub(crate) freedom: Freedom<D>,
    /// The other conditions.
    conditions: Vec<LinearCondition<D>>,
}

impl<const D: usize> Prepared<D> {
    /// Checks conditions and moves the coefficients of a shape to where all of them hold, as little as possible.
    pub(crate) fn new(
        constraints: &Constraints<D>,
        coefficients: &mut [SVector<f64, D>],
    ) -> Result<Self, Error> {
        let count = coefficients.len();
        let mut freedom = Freedom::full();
        for (index, (&i, place)) in constraints.held.iter().enumerate() {
            if i >= count || place.iter().any(|c| !c.is_finite()) {
                return Err(Error::Constraint { index, what: "no such coefficient, or no finite place" });
            }
            freedom.fix(i);
            coefficients[i] = *place;
        }
        let mut all = constraints.conditions.clone();
        let mut conditions = Vec::new();
        for (index, condition) in all.iter_mut().enumerate() {
            normalize(condition, count).map_err(|what| Error::Constraint { index, what })?;
            // A plane for one coefficient costs nothing; a second one is a condition like others.
            match condition.terms[..] {
                [(i, normal)] if freedom.keep_in_plane(i, normal) => {
                    coefficients[i] += normal * (condition.value - normal.dot(&coefficients[i]));
                }
                _ => conditions.push(condition.clone()),
            }
        }
        let prepared = Self { freedom, conditions };
        prepared.satisfy(coefficients);
        let size = coefficients.iter().map(|d| d.norm()).fold(0.0, f64::max);
        match all.iter().position(|condition| {
            let left = missing(condition, coefficients);
            left.abs() > CONTRADICTION * size.max(condition.value.abs())
        }) {
            Some(index) => Err(Error::Constraint { index, what: "it contradicts others" }),
            None => Ok(prepared),
        }
    }

    pub(crate) fn has_conditions(&self) -> bool {
        !self.conditions.is_empty()
    }

    fn satisfy(&self, coefficients: &mut [SVector<f64, D>]) {
        if self.conditions.is_empty() {
            return;
        }
        let columns: Vec<_> =
            (0..self.conditions.len()).map(|k| self.column(k, coefficients.len())).collect();
        let schur = DMatrix::from_fn(columns.len(), columns.len(), |i, j| self.apply(i, &columns[j]));
        let factors = solve_dependent(schur, &self.open(coefficients));
        for (column, factor) in columns.iter().zip(&factors) {
            coefficients.iter_mut().zip(column).for_each(|(d, a)| *d += a * *factor);
        }
    }

    /// What is missing to each condition.
    fn open(&self, coefficients: &[SVector<f64, D>]) -> DVector<f64> {
        let values = self.conditions.iter().map(|condition| missing(condition, coefficients));
        DVector::from_iterator(self.conditions.len(), values)
    }

    /// The factors of a condition as a vector of coefficients, held ones left out.
    fn column(&self, condition: usize, count: usize) -> Vec<SVector<f64, D>> {
        let mut out = vec![SVector::zeros(); count];
        for (i, a) in &self.conditions[condition].terms {
            out[*i] += self.freedom.allowed(*i, a);
        }
        out
    }

    fn apply(&self, condition: usize, x: &[SVector<f64, D>]) -> f64 {
        let terms = self.conditions[condition].terms.iter();
        terms.map(|(i, a)| self.freedom.allowed(*i, a).dot(&x[*i])).sum()
    }

    /// The step that solves the factored system under the side conditions; `coefficients` are those before the step.
    ///
    /// With `x₀ = A⁻¹ b` and `Y = A⁻¹ Cᵀ` it is `x₀ − Y μ`, `(C Y) μ = C x₀ − g`.
    pub(crate) fn solve(
        &self,
        factor: &Factor,
        vector: &[SVector<f64, D>],
        coefficients: &[SVector<f64, D>],
    ) -> Option<Vec<SVector<f64, D>>> {
        let rhs: Vec<_> = vector.iter().enumerate().map(|(i, v)| self.freedom.allowed(i, v)).collect();
        let mut step = factor.solve(&rhs)?;
        if self.conditions.is_empty() {
            return Some(step);
        }
        let columns: Option<Vec<_>> =
            (0..self.conditions.len()).map(|k| factor.solve(&self.column(k, rhs.len()))).collect();
        let columns = columns?;
        let schur = DMatrix::from_fn(columns.len(), columns.len(), |i, j| self.apply(i, &columns[j]));
        let open = self.open(coefficients);
        let excess = DVector::from_fn(columns.len(), |i, _| self.apply(i, &step) - open[i]);
        let factors = solve_dependent(schur, &excess);
        for (column, factor) in columns.iter().zip(&factors) {
            step.iter_mut().zip(column).for_each(|(s, y)| *s -= y * *factor);
        }
        Some(step)
    }
}

/// Checks a condition and scales its factors to the length 1.
fn normalize<const D: usize>(condition: &mut LinearCondition<D>, count: usize) -> Result<(), &'static str> {
    let finite = condition.value.is_finite()
        && condition.terms.iter().all(|(i, a)| *i < count && a.iter().all(|c| c.is_finite()));
    if !finite {
        return Err("a coefficient does not exist, or a number is not finite");
    }
    let scale = condition.terms.iter().map(|(_, a)| a.norm_squared()).sum::<f64>().sqrt();
    if scale == 0.0 {
        return Err("all factors are 0");
    }
    condition.value /= scale;
    condition.terms.iter_mut().for_each(|(_, a)| *a /= scale);
    Ok(())
}

fn missing<const D: usize>(condition: &LinearCondition<D>, coefficients: &[SVector<f64, D>]) -> f64 {
    condition.terms.iter().fold(condition.value, |rest, (i, a)| rest - a.dot(&coefficients[*i]))
}

/// Solves a symmetric positive semidefinite system whose equations may depend on each other.
fn solve_dependent(matrix: DMatrix<f64>, rhs: &DVector<f64>) -> Vec<f64> {
    let eigen = matrix.symmetric_eigen();
    let largest = eigen.eigenvalues.amax();
    let mut inner = eigen.eigenvectors.tr_mul(rhs);
    for (x, value) in inner.iter_mut().zip(eigen.eigenvalues.iter()) {
        *x = if *value > DEPENDENT * largest { *x / value } else { 0.0 };
    }
    (&eigen.eigenvectors * inner).iter().copied().collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Vector2, Vector3};

    #[test]
    fn normals_complete_a_direction() {
        let direction = Vector3::new(1.0, 2.0, -0.5);
        let found = normals(&direction);
        assert_eq!(found.len(), 2);
        assert!(found.iter().all(|n| n.dot(&direction).abs() < 1e-14 && (n.norm() - 1.0).abs() < 1e-14));
        assert!(found[0].dot(&found[1]).abs() < 1e-14);
    }

    #[test]
    fn contradictions_are_found() {
        let plane = |offset| Constraints::none().with_plane(0, Vector2::x(), offset);
        let mut twice = plane(1.0);
        twice.conditions.extend(plane(1.0).conditions);
        let mut places = [Vector2::new(0.0, 5.0)];
        assert!(Prepared::new(&twice, &mut places).is_ok());
        assert!((places[0] - Vector2::new(1.0, 5.0)).norm() < 1e-12);
        twice.conditions.extend(plane(2.0).conditions);
        assert!(matches!(Prepared::new(&twice, &mut places), Err(Error::Constraint { .. })));
        assert!(Prepared::new(&plane(f64::NAN), &mut places).is_err());
    }

    #[test]
    fn mirror_images_and_layers_move_as_little_as_possible() {
        let mirror = Constraints::none().with_mirror(0, 1, Vector2::x(), 1.5);
        let mut places = [Vector2::new(0.0, 0.0), Vector2::new(5.0, 2.0)];
        Prepared::new(&mirror, &mut places).unwrap();
        assert!((places[0] - Vector2::new(-1.0, 1.0)).norm() < 1e-12, "{places:?}");
        assert!((places[1] - Vector2::new(4.0, 1.0)).norm() < 1e-12, "{places:?}");
        // Heights 0, 3, 6 meet at their mean.
        let layer = Constraints::none().with_parallel(&[0, 1, 2], Vector2::y());
        let mut places = [0.0, 3.0, 6.0].map(|y| Vector2::new(y, y));
        Prepared::new(&layer, &mut places).unwrap();
        for (place, x) in places.iter().zip([0.0, 3.0, 6.0]) {
            assert!((place - Vector2::new(x, 3.0)).norm() < 1e-12, "{places:?}");
        }
    }

    #[test]
    fn held_coefficients_stay_and_must_exist() {
        let held = |i| Constraints::none().with_held(i, Vector2::new(1.0, 1.0));
        let mut places = [Vector2::zeros(), Vector2::new(4.0, 5.0)];
        let layer = held(0).with_parallel(&[0, 1], Vector2::y());
        Prepared::new(&layer, &mut places).unwrap();
        assert!((places[0] - Vector2::new(1.0, 1.0)).norm() == 0.0);
        assert!((places[1] - Vector2::new(4.0, 1.0)).norm() < 1e-12, "{places:?}");
        assert!(Prepared::new(&held(2), &mut places).is_err());
    }

    #[test]
    fn nearly_dependent_conditions_hold_and_small_contradictions_are_found() {
        let tilted = Vector2::new(0.01f64.cos(), 0.01f64.sin());
        let mut both = Constraints::none().with_parallel(&[0, 1], tilted);
        both.conditions
            .push(LinearCondition { terms: vec![(1, Vector2::x()), (0, -Vector2::x())], value: 1.0 });
        let mut places = [Vector2::zeros(), Vector2::zeros()];
        Prepared::new(&both, &mut places).unwrap();
        let expected = Vector2::new(1.0, -1.0 / 0.01f64.tan());
        assert!((places[1] - places[0] - expected).norm() < 1e-8, "{places:?}");
        let plane = |offset| Constraints::none().with_plane(0, Vector2::x(), offset);
        let mut twice = plane(1.0);
        twice.conditions.extend(plane(1.001).conditions);
        assert!(Prepared::new(&twice, &mut [Vector2::new(0.0, 0.0)]).is_err());
    }

    #[test]
    fn differences_follow_a_direction() {
        let direction = Vector3::new(1.0, 2.0, 2.0);
        let tangent = Constraints::none().with_direction(0, 1, &direction);
        let mut places = [Vector3::zeros(), Vector3::new(9.0, 0.0, 0.0)];
        Prepared::new(&tangent, &mut places).unwrap();
        // The difference is projected onto the direction, each end moves by half.
        assert!((places[1] - places[0] - direction).norm() < 1e-12, "{places:?}");
        assert!((places[0] + places[1] - Vector3::new(9.0, 0.0, 0.0)).norm() < 1e-12, "{places:?}");
    }
}
