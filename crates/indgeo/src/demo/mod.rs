//! The demonstration: a scanned stud bolt against its nominal thread, and the picture of it.

mod bolt;
mod colour;
mod data;
mod histogram;
mod map;
mod picture;
mod profile;
mod scale;
mod side_view;
pub(crate) mod svg;

pub(crate) use bolt::{Bolt, Zones};
pub(crate) use data::Data;
pub(crate) use picture::draw;
