//! Behaviour of the crate through its public API.

mod mesh_distances;
mod mesh_paths;
mod morphology;
mod parameters;
mod shapes;
mod surface_geodesics;
