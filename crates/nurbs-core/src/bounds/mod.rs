//! Axis-aligned boxes, of points and of shapes.

mod aabb;
mod tight;

pub use aabb::Aabb;
