//! Polynomials in Bernstein form and in powers, and numbers side by side.

pub(crate) mod bernstein;
pub(crate) mod homogeneous;
pub(crate) mod lanes;
pub(crate) mod power;
pub(crate) mod products;
pub(crate) mod simd;
