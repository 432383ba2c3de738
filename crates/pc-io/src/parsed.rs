//! What the readers of single formats hand over.

use crate::wording::counted;
use mesh_core::{PointCloud, TriangleMesh};

use crate::{Content, Error, Format, Model, Scan};

/// The warning about an empty file.
pub(crate) const NO_POINTS: &str = "the file holds no points";

/// Points, triangles, or curves and surfaces, and doubts, as read.
#[derive(Debug)]
pub(crate) struct Parsed {
    pub(crate) format: Format,
    pub(crate) found: Found,
    pub(crate) warnings: Vec<String>,
    /// The scans, of a format that can hold several.
    pub(crate) scans: Vec<Scan>,
}

/// What a reader found.
#[derive(Debug)]
pub(crate) enum Found {
    /// Points, of a format without triangles.
    Cloud(PointCloud),
    /// Vertices and triangles; without triangles a cloud, except in a format that knows nothing but triangles.
    Mesh(PointCloud, Vec<[u32; 3]>),
    /// Curves and surfaces.
    Model(Model),
}

impl Parsed {
    pub(crate) const fn cloud(format: Format, cloud: PointCloud, warnings: Vec<String>) -> Self {
        Self { format, found: Found::Cloud(cloud), warnings, scans: Vec::new() }
    }

    pub(crate) const fn mesh(
        format: Format,
        vertices: PointCloud,
        triangles: Vec<[u32; 3]>,
        warnings: Vec<String>,
    ) -> Self {
        Self { format, found: Found::Mesh(vertices, triangles), warnings, scans: Vec::new() }
    }

    pub(crate) const fn model(format: Format, model: Model, warnings: Vec<String>) -> Self {
        Self { format, found: Found::Model(model), warnings, scans: Vec::new() }
    }

    pub(crate) fn into_content(self) -> Result<(Content, Format, Vec<String>, Vec<Scan>), Error> {
        let mut warnings = self.warnings;
        let content = match self.found {
            Found::Cloud(cloud) => Content::Cloud(cloud),
            Found::Mesh(cloud, triangles) if triangles.is_empty() && self.format != Format::Stl => {
                Content::Cloud(cloud)
            }
            Found::Mesh(cloud, triangles) => {
                Content::Mesh(TriangleMesh::from_cloud(cloud, triangles).map_err(Error::shape)?)
            }
            Found::Model(model) => Content::Nurbs(model),
        };
        match &content {
            Content::Cloud(cloud) if cloud.is_empty() => warnings.push(NO_POINTS.to_owned()),
            Content::Mesh(mesh) if mesh.triangles().is_empty() => {
                warnings.push("the file holds no triangles".to_owned());
            }
            _ => {}
        }
        Ok((content, self.format, warnings, self.scans))
    }
}

/// Triangles fanned out of polygons, and what was odd about the polygons.
#[derive(Debug, Default)]
pub(crate) struct Fans {
    pub(crate) triangles: Vec<[u32; 3]>,
    polygons: usize,
    pub(crate) too_few: usize,
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
                "split into triangles: {} of more than three corners",
                counted(self.polygons, "polygon")
            ));
        }
        if self.too_few > 0 {
            warnings.push(format!("left out: {} of fewer than three corners", counted(self.too_few, "face")));
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
