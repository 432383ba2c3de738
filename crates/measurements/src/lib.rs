//! Programs that measure the goals of the project, one in each file or folder of `src/bin`, and what they share.
//!
//! `cargo xtask measure` runs them and writes `docs/measurements.md`; each can be run alone, as the head of its file says:
//! `cargo run --release -p measurements --bin kinds`. This library holds what several of them need: the cases of
//! `fixtures/fit-cases` ([`cases`]) and random numbers that are the same in every run ([`random`]).
//!
//! ```
//! use measurements::random::Random;
//!
//! let (mut one, mut other) = (Random(7), Random(7));
//! assert_eq!(one.unit(), other.unit());
//! ```

pub mod cases;
pub mod random;
