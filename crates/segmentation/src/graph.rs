//! Nearest neighbours of every point, stored as one table.

use mesh_core::CloudIndex;
use nalgebra::{Point3, Vector3};

use crate::Error;

/// Neighbours kept of every point.
pub(crate) const NEIGHBOURS: usize = 24;
/// Nearest neighbours that are linked in any case.
const BRIDGES: usize = 6;
/// Neighbours by which points are compared.
pub(crate) const LINKS: usize = 8;

/// The nearest neighbours of every point, the point itself left out, nearest first.
#[derive(Debug)]
pub(crate) struct Graph {
    /// Rows of `width` indices.
    table: Vec<u32>,
    width: usize,
    /// Links in both directions: where those of each point begin in `ends`.
    starts: Vec<u32>,
    ends: Vec<u32>,
    /// Local spacing of every point: side of the square of one point at the density of its 8 nearest neighbours.
    pub(crate) spacing: Vec<f64>,
}

impl Graph {
    /// Finds the neighbours. Where normals are given, points that face the other way (the far side of a thin wall) are no
    /// neighbours.
    pub(crate) fn new(points: &[Point3<f64>], normals: Option<&[Vector3<f64>]>) -> Result<Self, Error> {
        let index = CloudIndex::new(points)?;
        let width = NEIGHBOURS.min(points.len().saturating_sub(1));
        let asked = if normals.is_some() { 2 * width + 1 } else { width + 1 };
        let rows = index.map_nearest_n(points, asked, |i, found| {
            let faces = |j: usize| normals.is_none_or(|n| n[i].dot(&n[j]) > OPPOSITE);
            let mut row: Vec<u32> = (found.iter())
                .filter(|near| near.index != i && faces(near.index))
                .take(width)
                .map(|near| as_index(near.index))
                .collect();
            // A point without enough neighbours of its side takes the others as well.
            for near in found {
                if row.len() == width {
                    break;
                }
                let j = as_index(near.index);
                if near.index != i && !row.contains(&j) {
                    row.push(j);
                }
            }
            row
        });
        let table: Vec<u32> = rows.into_iter().flatten().collect();
        let spacing = (0..points.len())
            .map(|i| {
                let row = &table[i * width..(i + 1) * width];
                let k = row.len().min(8);
                let far =
                    row.get(k.wrapping_sub(1)).map_or(0.0, |&j| (points[j as usize] - points[i]).norm());
                far * (std::f64::consts::PI / k.max(1) as f64).sqrt()
            })
            .collect();
        let (starts, ends) = both_ways(&table, width, points);
        Ok(Self { table, width, starts, ends, spacing })
    }

    /// All kept neighbours of a point, nearest first.
    pub(crate) fn near(&self, i: usize) -> &[u32] {
        &self.table[i * self.width..(i + 1) * self.width]
    }

    /// The points linked with a point in either direction: random samples have gaps which links of one direction do not cross.
    pub(crate) fn around(&self, i: usize) -> &[u32] {
        &self.ends[self.starts[i] as usize..self.starts[i + 1] as usize]
    }

    /// The neighbours that tell the border of a region.
    pub(crate) fn links(&self, i: usize) -> &[u32] {
        let row = self.near(i);
        &row[..row.len().min(LINKS)]
    }
}

/// Links to and from every point, ascending: the nearest neighbours, and those farther ones whose common sphere of smallest radius
/// holds no third point (the Gabriel graph), which cross the gaps of random samples but no groove.
fn both_ways(table: &[u32], width: usize, points: &[Point3<f64>]) -> (Vec<u32>, Vec<u32>) {
    let n = points.len();
    let mut pairs = Vec::with_capacity(16 * n);
    for i in 0..n {
        let row = &table[i * width..(i + 1) * width];
        for (place, &j) in row.iter().enumerate() {
            let (x, y) = (points[i], points[j as usize]);
            let free = |k: &u32| (points[*k as usize] - x).dot(&(points[*k as usize] - y)) >= 0.0;
            if place < BRIDGES || row[..place].iter().all(free) {
                pairs.push((as_index(i), j));
                pairs.push((j, as_index(i)));
            }
        }
    }
    pairs.sort_unstable();
    pairs.dedup();
    let mut starts = vec![0u32; n + 1];
    for &(i, _) in &pairs {
        starts[i as usize + 1] += 1;
    }
    for i in 0..n {
        starts[i + 1] += starts[i];
    }
    (starts, pairs.into_iter().map(|(_, j)| j).collect())
}

/// Cosine of two given normals below which the points lie on different sides.
const OPPOSITE: f64 = -0.3;

/// Indices fit into 32 bits: the index of the cloud has refused more points.
#[expect(clippy::cast_possible_truncation, reason = "the number of points is below 2^32")]
pub(crate) fn as_index(i: usize) -> u32 {
    i as u32
}
