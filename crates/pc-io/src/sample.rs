//! Some of the points of a file that holds too many.

use std::path::Path;

use mesh_core::{Attributes, PointCloud};
use nalgebra::{Point3, Vector3};

use crate::content::{Content, Loaded};
use crate::{Error, ReadOptions, read_pieces};

/// Points of a piece.
const PIECE: usize = 1 << 17;
/// A point takes more bytes than this in every format that is read piece by piece.
const LEAST_BYTES: u64 = 2;

/// A point of the sample.
struct Chosen {
    hash: u64,
    index: u64,
    position: Point3<f64>,
    normal: Vector3<f64>,
}

/// Reads at most `most` of the points of a file that holds more and can be read piece by piece, in memory for these; `None` for
/// other files, which [`read`](crate::read) takes.
///
/// The sample is even and always the same: the points whose numbers in the file give the smallest values of a hash function, in
/// their order, with normals but without other attributes. The report is that of all points of the file.
///
/// # Errors
/// As [`read`](crate::read).
pub fn read_sample(
    path: impl AsRef<Path>,
    options: &ReadOptions,
    most: usize,
) -> Result<Option<Loaded<Content>>, Error> {
    let (path, most) = (path.as_ref(), most.max(1));
    let is_small = std::fs::metadata(path)
        .is_ok_and(|file| file.is_file() && file.len() < LEAST_BYTES.saturating_mul(most as u64));
    if is_small {
        return Ok(None);
    }
    let mut chosen: Vec<Chosen> = Vec::new();
    let (mut next, mut last, mut has_normals) = (0u64, u64::MAX, false);
    let report = read_pieces(path, options, PIECE, |piece| -> Result<(), Error> {
        has_normals = piece.normals.is_some();
        for (place, position) in piece.positions.iter().enumerate() {
            let (hash, index) = (scrambled(next), next);
            next += 1;
            if hash > last {
                continue;
            }
            let normal = piece.normals.as_ref().and_then(|normals| normals.get(place));
            let normal = normal.copied().unwrap_or_else(Vector3::zeros);
            chosen.push(Chosen { hash, index, position: *position, normal });
            if chosen.len() >= most.saturating_add(PIECE) {
                last = cut(&mut chosen, most);
            }
        }
        Ok(())
    })?;
    let Some(report) = report.filter(|_| next > most as u64) else { return Ok(None) };
    cut(&mut chosen, most);
    chosen.sort_unstable_by_key(|chosen| chosen.index);
    let mut attributes = Attributes::default();
    if has_normals {
        attributes.set_normals(Some(chosen.iter().map(|chosen| chosen.normal).collect()));
    }
    let cloud = PointCloud::new(chosen.into_iter().map(|chosen| chosen.position).collect());
    let cloud = cloud.with_attributes(attributes).map_err(Error::shape)?;
    Ok(Some(Loaded { content: Content::Cloud(cloud), report }))
}

/// Leaves the first `most` points by their hash, which no two share; the last hash among them.
fn cut(chosen: &mut Vec<Chosen>, most: usize) -> u64 {
    if chosen.len() <= most {
        return u64::MAX;
    }
    let (_, last, _) = chosen.select_nth_unstable_by_key(most - 1, |chosen| chosen.hash);
    let last = last.hash;
    chosen.truncate(most);
    last
}

/// A number that has nothing to do with `index`, is always the same, and another one for each: the finaliser of `splitmix64`.
fn scrambled(index: u64) -> u64 {
    let mut x = index.wrapping_add(0x9e37_79b9_7f4a_7c15);
    x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    x ^ (x >> 31)
}
