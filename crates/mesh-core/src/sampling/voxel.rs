//! One point per cell of a grid.

use nalgebra::{Point3, Vector3};

use crate::attributes::{Attributes, Colours};
use crate::bounds::is_finite;
use crate::normals::unit;
use crate::{Error, PointCloud};

/// Cells along an axis up to which their numbers are exact.
const MOST_CELLS: f64 = (1u64 << 53) as f64;

/// What stands for the points of a cell.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum VoxelPoint {
    /// Their centroid, with the means of their attributes.
    #[default]
    Centroid,
    /// The point nearest to their centroid, with its own attributes.
    Nearest,
}

/// A thinned cloud.
#[derive(Debug, Clone, PartialEq)]
pub struct VoxelSample {
    /// One point per occupied cell, in the order of the first points of the cells.
    pub cloud: PointCloud,
    /// Number of points in each cell.
    pub counts: Vec<usize>,
    /// Number of points left out because they are not finite.
    pub skipped: usize,
}

/// Thins a cloud to one point per cell of a grid of cubes, whose corner is that of the bounding box.
///
/// Means of normals are of unit length again, zero if they cancel out; means of colours are rounded.
///
/// # Errors
/// [`Error::OutOfRange`] if the size is not positive and finite, or so small that cells cannot be numbered.
pub fn voxel_downsample(cloud: &PointCloud, size: f64, choice: VoxelPoint) -> Result<VoxelSample, Error> {
    let extent = cloud.bounding_box().map_or(0.0, |bounds| bounds.extent().amax());
    let least = (extent / MOST_CELLS).max(f64::MIN_POSITIVE);
    if !(size >= least && size.is_finite()) {
        return Err(Error::OutOfRange { what: "voxel size", value: size, least });
    }
    let positions = cloud.positions();
    let corner = cloud.bounding_box().map_or_else(Point3::origin, |bounds| bounds.min);
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "below 2⁵³ and not negative")]
    let cell = |point: &Point3<f64>| ((point - corner) / size).map(|value| value as u64);
    let mut cells: Vec<([u64; 3], u32)> = (positions.iter().zip(0u32..))
        .filter(|(point, _)| is_finite(point))
        .map(|(point, index)| (cell(point).into(), index))
        .collect();
    cells.sort_unstable();
    let mut groups: Vec<Vec<u32>> = (cells.chunk_by(|one, other| one.0 == other.0))
        .map(|group| group.iter().map(|&(_, index)| index).collect())
        .collect();
    groups.sort_unstable_by_key(|group| group.first().copied());
    let thinned = match choice {
        VoxelPoint::Centroid => centroids(cloud, &groups)?,
        VoxelPoint::Nearest => {
            let nearest: Vec<u32> =
                groups.iter().filter_map(|group| nearest_to_centroid(positions, group)).collect();
            cloud.select(&nearest)?
        }
    };
    Ok(VoxelSample {
        cloud: thinned,
        counts: groups.iter().map(Vec::len).collect(),
        skipped: positions.len() - cells.len(),
    })
}

/// Mean of the positions, taken relative to the first so that a far origin costs no digits.
fn centroid(positions: &[Point3<f64>], group: &[u32]) -> Point3<f64> {
    let Some(&first) = group.first() else { return Point3::origin() };
    let origin = positions[first as usize];
    origin
        + group.iter().map(|&index| positions[index as usize] - origin).sum::<Vector3<f64>>()
            / group.len() as f64
}

fn nearest_to_centroid(positions: &[Point3<f64>], group: &[u32]) -> Option<u32> {
    let centre = centroid(positions, group);
    let distance = |index: u32| (positions[index as usize] - centre).norm_squared();
    group.iter().copied().reduce(|best, index| if distance(index) < distance(best) { index } else { best })
}

fn centroids(cloud: &PointCloud, groups: &[Vec<u32>]) -> Result<PointCloud, Error> {
    let positions = groups.iter().map(|group| centroid(cloud.positions(), group)).collect();
    let given = cloud.attributes();
    let mut attributes = Attributes::default();
    let mean = |group: &Vec<u32>, value: &dyn Fn(usize) -> f64| {
        group.iter().map(|&index| value(index as usize)).sum::<f64>() / group.len() as f64
    };
    attributes.set_normals(given.normals().map(|normals| {
        let sum = |group: &Vec<u32>| group.iter().map(|&index| normals[index as usize]).sum::<Vector3<f64>>();
        groups.iter().map(|group| unit(&sum(group)).unwrap_or_else(Vector3::zeros)).collect()
    }));
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "the mean of bytes is one")]
    let channel = |group: &Vec<u32>, value: &dyn Fn(usize) -> u8| {
        mean(group, &|index| f64::from(value(index))).round() as u8
    };
    attributes.set_colours(given.colours().map(|colours| match colours {
        Colours::Rgb(values) => Colours::Rgb(
            groups.iter().map(|group| std::array::from_fn(|c| channel(group, &|i| values[i][c]))).collect(),
        ),
        Colours::Rgba(values) => Colours::Rgba(
            groups.iter().map(|group| std::array::from_fn(|c| channel(group, &|i| values[i][c]))).collect(),
        ),
    }));
    for field in given.scalars() {
        attributes.push_scalar(
            field.name.clone(),
            groups.iter().map(|group| mean(group, &|index| field.values[index])).collect(),
        )?;
    }
    let thinned = PointCloud::new(positions).with_attributes(attributes)?;
    if cloud.dimension() == 2 { thinned.into_planar() } else { Ok(thinned) }
}
