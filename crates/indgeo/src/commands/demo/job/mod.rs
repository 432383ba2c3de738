//! The demonstration: a scanned stud bolt against its nominal thread, the pictures of it, and a CAD part.

mod alignment;
mod bolt;
#[cfg(feature = "step")]
mod cad_part;
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
#[cfg(feature = "step")]
pub(crate) use cad_part::run as inspect_part;
pub(crate) use data::Data;
pub(crate) use picture::draw;
