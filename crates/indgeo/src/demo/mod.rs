//! The demonstration: a scanned stud bolt against its nominal thread, and the pictures of it.

mod alignment;
mod bolt;
mod colour;
mod data;
mod histogram;
mod map;
mod picture;
mod placement;
mod profile;
mod scale;
mod side_view;
pub(crate) mod svg;

pub(crate) use alignment::{Files, run as align, write_text};
pub(crate) use bolt::{Bolt, Zones};
pub(crate) use data::Data;
pub(crate) use picture::draw;
