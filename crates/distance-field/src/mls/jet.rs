//! Functions of a point in space with their first and second derivatives.

use nalgebra::{Matrix3, Vector3};
use std::ops::{Add, Mul, Sub};

/// Value, gradient and Hessian of a function at a point; sums and products follow the rules of differentiation.
#[derive(Clone, Copy, Debug)]
pub(super) struct Jet {
    pub(super) value: f64,
    pub(super) gradient: Vector3<f64>,
    pub(super) hessian: Matrix3<f64>,
}

impl Jet {
    pub(super) const ZERO: Self = Self::constant(0.0);

    pub(super) const fn constant(value: f64) -> Self {
        let (gradient, hessian) =
            (Vector3::new(0.0, 0.0, 0.0), Matrix3::new(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0));
        Self { value, gradient, hessian }
    }

    /// The coordinates of a point.
    pub(super) fn coordinates(x: &Vector3<f64>) -> [Self; 3] {
        [0, 1, 2].map(|k| {
            let mut jet = Self::constant(x[k]);
            jet.gradient[k] = 1.0;
            jet
        })
    }

    pub(super) fn scale(&self, factor: f64) -> Self {
        Self { value: self.value * factor, gradient: self.gradient * factor, hessian: self.hessian * factor }
    }

    pub(super) fn add_scaled(&mut self, other: &Self, factor: f64) {
        self.value += other.value * factor;
        self.gradient += other.gradient * factor;
        self.hessian += other.hessian * factor;
    }

    /// One over the function.
    pub(super) fn reciprocal(&self) -> Self {
        let value = 1.0 / self.value;
        let gradient = self.gradient * (-value * value);
        let outer = self.gradient * self.gradient.transpose();
        Self { value, gradient, hessian: (outer * (2.0 * value) - self.hessian) * (value * value) }
    }
}

impl Add for Jet {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self {
            value: self.value + other.value,
            gradient: self.gradient + other.gradient,
            hessian: self.hessian + other.hessian,
        }
    }
}

impl Sub for Jet {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        self + other.scale(-1.0)
    }
}

impl Mul for Jet {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        let outer = self.gradient * other.gradient.transpose();
        Self {
            value: self.value * other.value,
            gradient: self.gradient * other.value + other.gradient * self.value,
            hessian: self.hessian * other.value + other.hessian * self.value + outer + outer.transpose(),
        }
    }
}

/// The inner product of two vectors of functions.
pub(super) fn dot(a: &[Jet; 3], b: &[Jet; 3]) -> Jet {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}
