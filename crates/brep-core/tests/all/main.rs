//! Behaviour of models against closed forms.

#![allow(clippy::unwrap_used, clippy::panic, reason = "tests may panic")]

mod closest;
mod crossings;
mod damage;
mod facing;
mod shapes;
