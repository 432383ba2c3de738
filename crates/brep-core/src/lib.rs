//! Boundary representation: trimmed faces, edges, shells and parts, and their certified closest points.
//!
//! [`description`] holds what CAD files say, as plain data: readers produce it, writers consume it.

pub mod description;
mod edge_curve;
