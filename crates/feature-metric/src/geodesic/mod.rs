//! Geodesic distances and curves on meshes.

mod fast;
mod funnel;
mod path;
mod queue;
mod sides;
mod straighten;
mod window;
mod windows;

pub use path::GeodesicPath;

use crate::{Error, MetricMesh};

/// How distances on a mesh are found.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Method {
    /// From triangle to triangle, as if each wave front was a circle around a point in the plane of the triangle; the error goes
    /// with the size of the triangles.
    Fast,
    /// Windows of straight paths over the unfolded triangles: exact but for rounding.
    #[default]
    Exact,
}

/// Distances from a source.
#[derive(Clone, Debug, PartialEq)]
pub struct Distances {
    /// One per vertex of the given mesh; infinite where no way leads.
    pub values: Vec<f64>,
    /// For vertices of the metric mesh.
    pub(crate) inner: Vec<f64>,
    /// Vertices of the metric mesh at distance 0.
    pub(crate) sources: Vec<u32>,
}

impl Distances {
    /// Number of vertices to which no way leads, those that belong to no triangle included.
    #[must_use]
    pub fn unreachable(&self) -> usize {
        self.values.iter().filter(|value| value.is_infinite()).count()
    }
}

impl MetricMesh {
    /// The geodesic distance of every vertex from the nearest of some vertices.
    ///
    /// # Errors
    /// [`Error::NoSource`]; [`Error::Vertex`] for a source that belongs to no triangle.
    pub fn distances(&self, sources: &[usize], method: Method) -> Result<Distances, Error> {
        let sources = self.sources(sources)?;
        let inner = match method {
            Method::Fast => fast::distances(self, &sources, fast::Front::Circle),
            Method::Exact => windows::distances(self, &sources),
        };
        Ok(Distances { values: self.per_vertex(&inner), inner, sources })
    }

    /// The distance from a region, all vertices of which are sources; wave fronts are straight where they leave it.
    ///
    /// # Errors
    /// As [`MetricMesh::distances`].
    pub fn distances_from_region(&self, region: &[usize]) -> Result<Distances, Error> {
        let sources = self.sources(region)?;
        let inner = fast::distances(self, &sources, fast::Front::Line);
        Ok(Distances { values: self.per_vertex(&inner), inner, sources })
    }

    fn sources(&self, vertices: &[usize]) -> Result<Vec<u32>, Error> {
        let mut sources = Vec::new();
        for &vertex in vertices {
            sources.extend(self.places(vertex)?);
        }
        sources.sort_unstable();
        sources.dedup();
        if sources.is_empty() { Err(Error::NoSource) } else { Ok(sources) }
    }
}
