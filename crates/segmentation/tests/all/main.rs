//! All integration tests of `segmentation` in one binary: linking once is most of what building them costs.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "tests may panic")]

mod neighbours;
mod refusals;
mod shapes;
