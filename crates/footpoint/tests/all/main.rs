//! All integration tests of `footpoint` in one binary: linking once is most of what building them costs.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "tests may panic")]

mod all_feet;
mod batch_independence;
mod certificate_bounds;
mod facing;
mod fast_mode;
mod hard_cases;
mod local_common;
mod local_curve;
mod local_surface;
mod magnitudes;
mod near_rational;
mod projector_analytic;
mod projector_batches;
mod projector_classes;
mod projector_degenerate;
mod projector_ground_truth;
mod projector_laws;
mod projector_oracle;
mod projector_support;
mod updates;
