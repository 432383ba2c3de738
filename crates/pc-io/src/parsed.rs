//! What the readers of single formats hand over.

use mesh_core::{PointCloud, TriangleMesh};

use crate::{Error, Format};

/// Points, triangles and doubts, as read.
#[derive(Debug)]
pub(crate) struct Parsed {
    pub(crate) format: Format,
    pub(crate) cloud: PointCloud,
    /// Triangles; `None` in a format without any.
    pub(crate) triangles: Option<Vec<[u32; 3]>>,
    pub(crate) warnings: Vec<String>,
}

/// A cloud, or a mesh where there are triangles (always in a format that knows nothing but triangles).
pub(crate) enum CloudOrMesh {
    Cloud(PointCloud),
    Mesh(TriangleMesh),
}

impl Parsed {
    pub(crate) fn into_shape(self) -> Result<(CloudOrMesh, Format, Vec<String>), Error> {
        let is_mesh = |triangles: &Vec<_>| self.format == Format::Stl || !triangles.is_empty();
        let shape = match self.triangles.filter(is_mesh) {
            Some(triangles) => {
                CloudOrMesh::Mesh(TriangleMesh::from_cloud(self.cloud, triangles).map_err(Error::shape)?)
            }
            None => CloudOrMesh::Cloud(self.cloud),
        };
        Ok((shape, self.format, self.warnings))
    }
}

/// Triangles fanned out of polygons, and what was odd about the polygons.
#[derive(Debug, Default)]
pub(crate) struct Fans {
    pub(crate) triangles: Vec<[u32; 3]>,
    polygons: usize,
    too_few: usize,
}

impl Fans {
    /// Adds a polygon as triangles around its first corner.
    pub(crate) fn push(&mut self, corners: &[u32]) {
        match *corners {
            [a, b, c] => self.triangles.push([a, b, c]),
            [first, ref rest @ ..] if rest.len() > 2 => {
                self.polygons += 1;
                self.triangles.extend(rest.windows(2).map(|pair| [first, pair[0], pair[1]]));
            }
            _ => self.too_few += 1,
        }
    }

    /// Adds the triangles of a strip, whose parts are separated by negative numbers.
    pub(crate) fn push_strip(&mut self, strip: &[Option<u32>]) {
        for part in strip.split(Option::is_none) {
            let part: Vec<u32> = part.iter().copied().flatten().collect();
            for (place, corners) in part.windows(3).enumerate() {
                let (one, other) = if place % 2 == 0 { (1, 2) } else { (2, 1) };
                let triangle = [corners[0], corners[one], corners[other]];
                // Strips are turned around by triangles without area.
                if triangle[0] != triangle[1] && triangle[1] != triangle[2] && triangle[2] != triangle[0] {
                    self.triangles.push(triangle);
                }
            }
        }
    }

    pub(crate) fn finish(self, warnings: &mut Vec<String>) -> Vec<[u32; 3]> {
        if self.polygons > 0 {
            warnings.push(format!(
                "{} polygons of more than three corners were split into triangles",
                self.polygons
            ));
        }
        if self.too_few > 0 {
            warnings.push(format!("{} faces of fewer than three corners were left out", self.too_few));
        }
        self.triangles
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fans_polygons_and_strips() {
        let mut fans = Fans::default();
        fans.push(&[0, 1, 2, 3, 4]);
        fans.push(&[5, 6]);
        fans.push_strip(&[Some(0), Some(1), Some(2), Some(3), None, Some(4), Some(5), Some(6)]);
        let mut warnings = Vec::new();
        let triangles = fans.finish(&mut warnings);
        assert_eq!(triangles, [[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 1, 2], [1, 3, 2], [4, 5, 6]]);
        assert_eq!(warnings.len(), 2);
    }
}
