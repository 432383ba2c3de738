//! What tells files and their contents apart.

use crate::error::Error;
use crate::output::partials::hex;
use industrial_geometry::io;
use industrial_geometry::mesh::nalgebra::{Point3, Vector3};
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};
use std::fs::{self, File};
use std::io::{Read, Seek, SeekFrom};
use std::path::Path;

/// Bytes at both ends of a file of points by which it is known.
const ENDS: u64 = 1 << 16;

/// A file by its path, size and content.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct FileIdentity {
    /// The path as given.
    pub(super) path: String,
    /// Size in bytes.
    pub(super) bytes: u64,
    /// SHA-256 of the bytes.
    pub(super) sha256: String,
}

impl FileIdentity {
    /// A file with the hash of all its bytes.
    pub(super) fn of(path: &Path) -> Result<Self, Error> {
        Self::hashed(path, |file, _, hash| copy(file, hash, u64::MAX))
    }

    /// A file, however large, with the hash of its first and last 64 KiB; the points that are read of it have one of their own.
    pub(super) fn of_ends(path: &Path) -> Result<Self, Error> {
        Self::hashed(path, |file, bytes, hash| {
            copy(file, hash, ENDS)?;
            file.seek(SeekFrom::Start(bytes.saturating_sub(ENDS)))?;
            copy(file, hash, ENDS)
        })
    }

    fn hashed(
        path: &Path,
        read: impl FnOnce(&mut File, u64, &mut Sha256) -> std::io::Result<()>,
    ) -> Result<Self, Error> {
        let failed = |source| Error::from(io::Error::Io { path: path.to_path_buf(), action: "read", source });
        let Some(name) = path.to_str() else {
            return Err(Error::content(path, "the name is not UTF-8", "give the file another name"));
        };
        // Opening a pipe waits for its writer.
        let metadata = fs::metadata(path).map_err(failed)?;
        if !metadata.is_file() {
            let what = "a partial result is made of files, this is none";
            return Err(Error::content(path, what, "write the points or the model to a file first"));
        }
        let mut file = File::open(path).map_err(failed)?;
        let (mut hash, bytes) = (Sha256::new(), metadata.len());
        read(&mut file, bytes, &mut hash).map_err(failed)?;
        Ok(Self { path: name.to_owned(), bytes, sha256: hex(hash) })
    }

    /// Whether the content is the same, whatever the path.
    pub(super) fn has_content_of(&self, other: &Self) -> bool {
        (self.bytes, &self.sha256) == (other.bytes, &other.sha256)
    }
}

fn copy(file: &mut File, hash: &mut Sha256, most: u64) -> std::io::Result<()> {
    let mut buffer = vec![0; 1 << 16];
    let mut file = file.take(most);
    loop {
        let count = file.read(&mut buffer)?;
        if count == 0 {
            return Ok(());
        }
        hash.update(&buffer[..count]);
    }
}

/// SHA-256 of points with their normals, as they are read; the pieces do not matter.
#[derive(Default)]
pub(super) struct PointsHash {
    hash: Sha256,
    bytes: Vec<u8>,
}

impl PointsHash {
    pub(super) fn add(&mut self, positions: &[Point3<f64>], normals: Option<&[Vector3<f64>]>) {
        let mut normals = normals.map(|normals| normals.iter());
        for chunk in positions.chunks(4096) {
            self.bytes.clear();
            for point in chunk {
                point.iter().for_each(|value| self.bytes.extend(value.to_le_bytes()));
                for value in normals.as_mut().and_then(Iterator::next).into_iter().flat_map(Vector3::iter) {
                    self.bytes.extend(value.to_le_bytes());
                }
            }
            self.hash.update(&self.bytes);
        }
    }

    pub(super) fn finish(self) -> String {
        hex(self.hash)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hashes_are_those_of_the_standard_and_of_any_pieces() {
        let abc = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad";
        assert_eq!(crate::output::partials::sha256(b"abc"), abc);
        let points: Vec<Point3<f64>> = (0..9000).map(|i| Point3::new(f64::from(i), 0.5, -1.0)).collect();
        let normals = vec![Vector3::z(); points.len()];
        let (mut whole, mut parts) = (PointsHash::default(), PointsHash::default());
        whole.add(&points, Some(&normals));
        for (points, normals) in points.chunks(777).zip(normals.chunks(777)) {
            parts.add(points, Some(normals));
        }
        assert_eq!(whole.finish(), parts.finish());
    }
}
