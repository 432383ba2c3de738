//! All integration tests of `cad-io` in one binary.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "tests may panic")]

mod iges_builder;
mod iges_entities;
mod iges_faults;
mod iges_files;
mod iges_models;
mod iges_mutation;
mod iges_write;
mod lines;
#[cfg(feature = "step")]
mod step;
#[cfg(feature = "step")]
mod step_damage;
#[cfg(feature = "step")]
mod step_numbers;
#[cfg(feature = "step")]
mod step_pmi;
#[cfg(feature = "step")]
mod step_write;
mod tessellation;
