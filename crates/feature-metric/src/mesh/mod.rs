//! Meshes as the metric sees them: connectivity and lengths of edges.

mod fillets;
mod insert;
mod metric_mesh;
mod refine;
mod wedges;

pub use insert::{InsertedPoint, insert_point};
pub use metric_mesh::MetricMesh;
pub(crate) use refine::split;
