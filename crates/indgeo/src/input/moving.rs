//! What was read, moved to another place.

use crate::error::Error;
use industrial_geometry::io::Content;
use industrial_geometry::mesh::nalgebra::Point3;
use industrial_geometry::mesh::{PointCloud, TriangleMesh};
use industrial_geometry::register::Pose;
use std::path::Path;

/// Points and triangles in a new pose, normals turned with them; everything else stays as it is. `path` is for messages.
pub(crate) fn moved(content: Content, pose: &Pose<3>, path: &Path) -> Result<Content, Error> {
    let failed =
        |error: industrial_geometry::mesh::Error| Error::content(path, error.to_string(), "export it again");
    let at = |cloud: PointCloud| -> Result<PointCloud, Error> {
        let is_planar = cloud.dimension() == 2;
        let (positions, mut attributes) = cloud.into_parts();
        let positions = positions.iter().map(|x| Point3::from(pose.apply(&x.coords))).collect();
        let normals = attributes.normals().map(|normals| normals.iter().map(|n| pose.rotate(n)).collect());
        attributes.set_normals(normals);
        let moved = PointCloud::new(positions).with_attributes(attributes).map_err(failed)?;
        if is_planar { moved.into_planar().map_err(failed) } else { Ok(moved) }
    };
    Ok(match content {
        Content::Cloud(cloud) => Content::Cloud(at(cloud)?),
        Content::Mesh(mesh) => {
            let (cloud, triangles) = mesh.into_parts();
            Content::Mesh(TriangleMesh::from_cloud(at(cloud)?, triangles).map_err(failed)?)
        }
        other @ Content::Nurbs(_) => other,
    })
}
