//! What the tests of the projectors share: one form of answer, random shapes, brute force.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "helpers of tests may panic")]
#![allow(dead_code, reason = "each test file uses a part of it")]

pub(crate) mod answer;
pub(crate) mod oracle;
pub(crate) mod shapes;

/// Random knots, curves, surfaces and frames, as the tests of the kernel use them.
#[path = "../../../../nurbs-core/tests/all/random/mod.rs"]
pub(crate) mod random;

/// So many cases; failures are printed, not stored in files beside the tests.
pub(crate) fn config(cases: u32) -> proptest::test_runner::Config {
    // A fixed seed: the same cases on every run.
    let rng_seed = proptest::test_runner::RngSeed::Fixed(2005);
    proptest::test_runner::Config { cases, failure_persistence: None, rng_seed, ..Default::default() }
}
