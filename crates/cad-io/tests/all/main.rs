//! Behaviour of readers and writers on files.

#[cfg(feature = "step")]
mod step;
#[cfg(feature = "step")]
mod step_damage;
