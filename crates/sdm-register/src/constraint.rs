//! Locked degrees of freedom: the unknowns that are left, and the steps they allow.

use crate::linearise::{Matrix, NormalSystem, Unknowns};
use crate::motion::rotation::{exponential, logarithm};
use crate::motion::{MAX_UNKNOWNS, Pose, Velocity, rigid_unknowns, rotations};
use nalgebra::{DMatrix, DVector, SMatrix, SVector, Vector3};

/// Degrees of freedom that are held fast, in any frame of the model's space.
///
/// The displacement from the starting pose is written `x ↦ o + t + exp(w) (x − o)`, with `t` and the rotation vector `w`
/// in the given axes; what is locked of `t` and `w` stays 0. The result is the minimum under these constraints, not the
/// free one with parts left out. In the plane there are two translations and one rotation.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Locks<const D: usize> {
    /// `o`, in the model's coordinates; default 0.
    #[cfg_attr(feature = "serde", serde(serialize_with = "crate::report::as_slice"))]
    pub origin: SVector<f64, D>,
    /// Orthonormal axes, one per column; default those of the coordinates.
    #[cfg_attr(feature = "serde", serde(serialize_with = "crate::report::as_slice"))]
    pub axes: SMatrix<f64, D, D>,
    /// Which translations along the axes are locked.
    pub translations: [bool; 3],
    /// Which rotations about the axes are locked.
    pub rotations: [bool; 3],
}

impl<const D: usize> Default for Locks<D> {
    fn default() -> Self {
        Self {
            origin: SVector::zeros(),
            axes: SMatrix::identity(),
            translations: [false; 3],
            rotations: [false; 3],
        }
    }
}

impl<const D: usize> Locks<D> {
    /// The same locks in another frame; the axes are taken as they are and must be orthonormal.
    #[must_use]
    pub fn with_frame(self, origin: SVector<f64, D>, axes: SMatrix<f64, D, D>) -> Self {
        Self { origin, axes, ..self }
    }

    /// The same frame with other locked translations.
    #[must_use]
    pub fn with_translations(self, translations: [bool; 3]) -> Self {
        Self { translations, ..self }
    }

    /// The same frame with other locked rotations.
    #[must_use]
    pub fn with_rotations(self, rotations: [bool; 3]) -> Self {
        Self { rotations, ..self }
    }

    /// Whether something is locked.
    #[must_use]
    pub fn any(&self) -> bool {
        self.translations[..D].iter().chain(&self.rotations[..rotations(D)]).any(|&locked| locked)
    }
}

/// The unknowns that are left and how a step in them moves a pose.
#[derive(Clone, Debug)]
pub(crate) struct Chart<const D: usize> {
    locks: Locks<D>,
    scale: bool,
    start: Pose<D>,
}

/// The unknowns at one pose.
#[derive(Clone, Debug)]
pub(crate) struct Freedom<const D: usize> {
    /// One column per unknown that is left: the velocity, in the frame of the moment.
    pub(crate) basis: DMatrix<f64>,
    /// The same as seen from the pivot; the two differ only where something is locked.
    about_pivot: DMatrix<f64>,
    /// The point of the moving system that was the origin of the locks, in the frame of the moment.
    pivot: Option<SVector<f64, D>>,
    /// Which columns are translations, and so are lengths.
    pub(crate) is_translation: Vec<bool>,
}

impl<const D: usize> Chart<D> {
    pub(crate) fn new(locks: Locks<D>, scale: bool, start: Pose<D>) -> Self {
        Self { locks, scale, start }
    }

    /// The displacement from the start: the movement `t` of the origin of the locks, and the rotation vector, both in
    /// the axes of the locks.
    fn displacement(&self, pose: &Pose<D>) -> (SVector<f64, D>, Vector3<f64>) {
        let moved = self.start.inverse().followed_by(pose);
        let t = self.locks.axes.tr_mul(&(moved.apply(&self.locks.origin) - self.locks.origin));
        let w = logarithm(&moved.rotation);
        (t, self.to_axes(&w))
    }

    /// Coordinates of a rotation vector in the axes of the locks.
    fn to_axes(&self, w: &Vector3<f64>) -> Vector3<f64> {
        if D == 2 {
            *w
        } else {
            Vector3::from_fn(|i, _| (0..D).map(|k| self.locks.axes[(k, i)] * w[k]).sum())
        }
    }

    /// The rotation vector of coordinates in the axes of the locks.
    fn out_of_axes(&self, w: &Vector3<f64>) -> Vector3<f64> {
        if D == 2 {
            *w
        } else {
            Vector3::from_fn(|k, _| (0..D).map(|i| self.locks.axes[(k, i)] * w[i]).sum())
        }
    }

    /// The unknowns at a pose.
    pub(crate) fn freedom(&self, pose: &Pose<D>) -> Freedom<D> {
        let growth = rigid_unknowns(D);
        let mut columns: Vec<(Unknowns, bool)> = Vec::new();
        let unit = |k: usize| Unknowns::from_fn(|i, _| f64::from(u8::from(i == k)));
        if !self.locks.any() {
            columns.extend((0..growth).map(|k| (unit(k), k < D)));
            if self.scale {
                columns.push((unit(growth), false));
            }
            let basis = to_matrix(&columns);
            let is_translation = columns.iter().map(|c| c.1).collect();
            return Freedom { about_pivot: basis.clone(), basis, pivot: None, is_translation };
        }
        let (t, w) = self.displacement(pose);
        let pivot = self.locks.origin + self.locks.axes * t - pose.target_origin;
        for i in (0..D).filter(|&i| !self.locks.translations[i]) {
            let translation = self.locks.axes.column(i).into_owned();
            columns.push((Velocity { translation, ..Velocity::zero() }.to_unknowns(), true));
        }
        // A change of the rotation vector turns the system by its left Jacobian times the change.
        let world = self.out_of_axes(&w);
        for i in (0..rotations(D)).filter(|&i| !self.locks.rotations[i]) {
            let mut axis = Vector3::zeros();
            axis[i] = 1.0;
            let axis = self.out_of_axes(&axis);
            let rotation = if D == 2 { axis } else { exponential::<3>(&world).1 * axis };
            columns.push((Velocity::<D> { rotation, ..Velocity::zero() }.to_unknowns(), false));
        }
        if self.scale {
            columns.push((unit(growth), false));
        }
        let about_pivot = to_matrix(&columns);
        let is_translation = columns.iter().map(|c| c.1).collect();
        for (column, _) in &mut columns {
            let v = Velocity::<D>::from_unknowns(column);
            let translation = v.translation - (v.at(&pivot) - v.translation);
            *column = Velocity { translation, ..v }.to_unknowns();
        }
        Freedom { basis: to_matrix(&columns), about_pivot, pivot: Some(pivot), is_translation }
    }

    /// The pose after a step.
    pub(crate) fn advance(&self, pose: &Pose<D>, freedom: &Freedom<D>, step: &DVector<f64>) -> Pose<D> {
        let velocity = freedom.velocity(step);
        let Some(pivot) = &freedom.pivot else {
            return pose.then(&velocity.helical());
        };
        let moved = pose.then(&velocity.about(pivot));
        self.held(&moved)
    }

    /// The pose with the locked parts of its displacement set back to 0 (what rounding, and the curvature of the
    /// rotations with one axis locked, leave of them).
    pub(crate) fn held(&self, pose: &Pose<D>) -> Pose<D> {
        if !self.locks.any() {
            return *pose;
        }
        let (mut t, mut w) = self.displacement(pose);
        for i in 0..D {
            if self.locks.translations[i] {
                t[i] = 0.0;
            }
        }
        for i in 0..rotations(D) {
            if self.locks.rotations[i] {
                w[i] = 0.0;
            }
        }
        let turn = exponential::<D>(&self.out_of_axes(&w)).0;
        let origin = self.locks.origin;
        let growth = pose.scale / self.start.scale;
        let moved = turn * (self.start.target_origin - origin) * growth;
        Pose {
            scale: pose.scale,
            rotation: turn * self.start.rotation,
            source_origin: self.start.source_origin,
            target_origin: origin + self.locks.axes * t + moved,
        }
    }
}

fn to_matrix(columns: &[(Unknowns, bool)]) -> DMatrix<f64> {
    DMatrix::from_fn(MAX_UNKNOWNS, columns.len(), |i, j| columns[j].0[i])
}

impl<const D: usize> Freedom<D> {
    /// Number of unknowns.
    pub(crate) fn count(&self) -> usize {
        self.basis.ncols()
    }

    /// The velocity of a step.
    pub(crate) fn velocity(&self, step: &DVector<f64>) -> Velocity<D> {
        let unknowns = &self.basis * step;
        Velocity::from_unknowns(&Unknowns::from_fn(|i, _| unknowns[i]))
    }

    /// A matrix in the unknowns that are left.
    pub(crate) fn reduce(&self, matrix: &Matrix) -> DMatrix<f64> {
        restrict(matrix, &self.basis)
    }

    /// A vector in the unknowns that are left.
    pub(crate) fn reduce_vector(&self, vector: &Unknowns) -> DVector<f64> {
        DVector::from_fn(self.count(), |j, _| (0..MAX_UNKNOWNS).map(|i| self.basis[(i, j)] * vector[i]).sum())
    }

    /// The second derivatives of the motion in the unknowns that are left.
    pub(crate) fn curvature(&self, system: &NormalSystem<D>) -> DMatrix<f64> {
        match &self.pivot {
            None => restrict(&system.helical_curvature(), &self.basis),
            Some(pivot) => restrict(&system.pivot_curvature(pivot), &self.about_pivot),
        }
    }
}

/// `BᵀMB`.
fn restrict(matrix: &Matrix, basis: &DMatrix<f64>) -> DMatrix<f64> {
    let full = DMatrix::from_fn(MAX_UNKNOWNS, MAX_UNKNOWNS, |i, j| matrix[(i, j)]);
    basis.tr_mul(&(full * basis))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn start() -> Pose<3> {
        Pose::new(exponential::<3>(&Vector3::new(0.3, 0.2, -0.5)).0, Vector3::new(1.0, -2.0, 0.5))
            .with_source_origin(Vector3::new(0.2, 0.1, 0.4))
    }

    #[test]
    fn without_locks_the_unknowns_are_all() {
        let chart = Chart::new(Locks::default(), false, start());
        let freedom = chart.freedom(&start());
        assert_eq!(freedom.count(), 6);
        assert_eq!(Chart::new(Locks::default(), true, start()).freedom(&start()).count(), 7);
        assert_eq!(freedom.is_translation, [true, true, true, false, false, false]);
    }

    #[test]
    fn every_subset_of_locks_holds_on_a_walk() {
        let axes = exponential::<3>(&Vector3::new(-1.0, 0.4, 0.8)).0;
        for mask in 0u32..64 {
            let bit = |k: u32| mask >> k & 1 == 1;
            let locks = Locks::default()
                .with_frame(Vector3::new(5.0, -1.0, 2.0), axes)
                .with_translations([bit(0), bit(1), bit(2)])
                .with_rotations([bit(3), bit(4), bit(5)]);
            let chart = Chart::new(locks, false, start());
            let mut pose = start();
            for k in 0..5 {
                let freedom = chart.freedom(&pose);
                assert_eq!(freedom.count(), 6 - mask.count_ones() as usize);
                let step = DVector::from_fn(freedom.count(), |i, _| 0.1 * (1.7 * (i + 3 * k) as f64).sin());
                pose = chart.advance(&pose, &freedom, &step);
            }
            let (t, w) = chart.displacement(&pose);
            for i in 0..3 {
                let (kt, kw) = (u32::try_from(i).unwrap(), u32::try_from(i + 3).unwrap());
                if mask != 0 {
                    assert!(t[i].abs() < 1e-14 || !bit(kt), "{mask:b} {t}");
                    assert!(w[i].abs() < 1e-14 || !bit(kw), "{mask:b} {w}");
                }
            }
            let moved = (pose.apply(&Vector3::x()) - start().apply(&Vector3::x())).norm();
            assert_eq!(moved > 1e-3, mask != 63, "{mask:b}: {moved}");
        }
    }

    #[test]
    fn velocities_are_derivatives_of_the_step() {
        let locks = Locks::default()
            .with_frame(Vector3::new(5.0, -1.0, 2.0), SMatrix::identity())
            .with_translations([true, false, false])
            .with_rotations([false, true, false]);
        let chart = Chart::new(locks, false, start());
        let mut pose = start();
        let freedom = chart.freedom(&pose);
        pose = chart.advance(&pose, &freedom, &DVector::from_vec(vec![0.1, 0.2, 0.3, -0.2]));
        let freedom = chart.freedom(&pose);
        let x = Vector3::new(0.7, -0.4, 1.0);
        for k in 0..4 {
            let h = 1e-6;
            let at = |s: f64| {
                let step = DVector::from_fn(4, |i, _| if i == k { s } else { 0.0 });
                chart.advance(&pose, &freedom, &step).apply(&x)
            };
            let difference = (at(h) - at(-h)) / (2.0 * h);
            let step = DVector::from_fn(4, |i, _| f64::from(u8::from(i == k)));
            let velocity = freedom.velocity(&step).at(&(pose.apply(&x) - pose.target_origin));
            assert!((difference - velocity).norm() < 1e-8, "{k}: {difference} {velocity}");
        }
    }
}
