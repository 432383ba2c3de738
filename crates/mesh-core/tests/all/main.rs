//! All integration tests of `mesh-core` in one binary: linking once is most of what building them costs.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "tests may panic")]

mod closest;
mod cloud_index;
mod curvature;
mod facing;
mod limit_surface;
mod line_hit;
mod loop_subdivision;
mod normals;
mod polyline;
mod sampling;
mod seams;
mod shapes;
