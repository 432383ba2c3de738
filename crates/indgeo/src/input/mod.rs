//! Reading: models, points and motions, in one form for all commands.

pub(crate) mod between_vertices;
pub(crate) mod cad;
pub(crate) mod cad_shapes;
pub(crate) mod field_model;
pub(crate) mod image_or_grid;
pub(crate) mod model;
pub(crate) mod moving;
pub(crate) mod points;
pub(crate) mod poses;
pub(crate) mod sampling;
pub(crate) mod scan_files;
pub(crate) mod target;
pub(crate) mod transform;
