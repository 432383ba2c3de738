//! Triangles turned so that neighbours agree on the side of their normals.

use crate::TriangleMesh;
use crate::bounds::is_finite;
use crate::topology::{EdgeMap, NONE};

impl TriangleMesh {
    /// The mesh with triangles turned until neighbours agree, and the number of those that were turned.
    ///
    /// Neighbours share an edge of exactly two triangles, vertices at the same position counting as one. Each connected part keeps the side of
    /// the larger share of its area, the side as given where both shares are equal; a part that is not orientable keeps edges at which it
    /// disagrees. Vertices, attributes and the order of the triangles stay.
    #[must_use]
    pub fn with_agreeing_sides(&self) -> (Self, usize) {
        let welded = self.welded_triangles();
        let is_usable = |corners: &[u32; 3]| corners.iter().all(|&k| is_finite(&self.vertices()[k as usize]));
        let usable: Vec<usize> = (0..welded.len()).filter(|&k| is_usable(&welded[k])).collect();
        let corners: Vec<[u32; 3]> = usable.iter().map(|&k| welded[k]).collect();
        let edges = EdgeMap::of(&corners);
        if edges.topology.is_oriented() {
            return (self.clone(), 0);
        }
        let turned = turned(&corners, &edges, |k| {
            self.corners(usable[k]).map_or(0.0, |[a, b, c]| (b - a).cross(&(c - a)).norm())
        });
        let mut triangles = self.triangles().to_vec();
        for (&place, _) in usable.iter().zip(&turned).filter(|(_, is_turned)| **is_turned) {
            triangles[place].swap(1, 2);
        }
        (self.with_triangles(triangles), turned.iter().filter(|is_turned| **is_turned).count())
    }
}

/// Which triangles to turn; `size` is that of a triangle.
fn turned(corners: &[[u32; 3]], edges: &EdgeMap, size: impl Fn(usize) -> f64) -> Vec<bool> {
    // Against the first triangle of the part.
    let mut is_against: Vec<Option<bool>> = vec![None; corners.len()];
    let mut part = Vec::new();
    for first in 0..corners.len() {
        if is_against[first].is_some() {
            continue;
        }
        part.clear();
        part.push(first);
        is_against[first] = Some(false);
        let mut sizes = [0.0; 2];
        let mut next = 0;
        while let Some(&triangle) = part.get(next) {
            next += 1;
            let side = is_against[triangle] == Some(true);
            sizes[usize::from(side)] += size(triangle);
            for (edge, &neighbour) in edges.neighbours[triangle].iter().enumerate() {
                if neighbour == NONE || is_against[neighbour as usize].is_some() {
                    continue;
                }
                let (from, to) = (corners[triangle][edge], corners[triangle][(edge + 1) % 3]);
                is_against[neighbour as usize] = Some(side ^ runs(&corners[neighbour as usize], from, to));
                part.push(neighbour as usize);
            }
        }
        if sizes[1] > sizes[0] {
            for &triangle in &part {
                is_against[triangle] = is_against[triangle].map(|side| !side);
            }
        }
    }
    is_against.into_iter().map(|side| side == Some(true)).collect()
}

/// Whether a triangle has an edge in this direction.
fn runs(corners: &[u32; 3], from: u32, to: u32) -> bool {
    (0..3).any(|k| corners[k] == from && corners[(k + 1) % 3] == to)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::MeshTopology;
    use nalgebra::Point3;

    const OCTAHEDRON: [[u32; 3]; 8] =
        [[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]];

    fn octahedron(triangles: &[[u32; 3]]) -> TriangleMesh {
        let vertices = [
            [1.0, 0.0, 0.0],
            [-1.0, 0.0, 0.0],
            [0.0, 1.0, 0.0],
            [0.0, -1.0, 0.0],
            [0.0, 0.0, 1.0],
            [0.0, 0.0, -1.0],
        ];
        TriangleMesh::new(vertices.map(Point3::from).to_vec(), triangles.to_vec()).unwrap()
    }

    #[test]
    fn the_larger_side_wins_and_the_rest_is_turned() {
        assert!(MeshTopology::of(&OCTAHEDRON).is_solid());
        let mut flipped = OCTAHEDRON;
        for k in [0, 3, 6] {
            flipped[k].swap(0, 1);
        }
        let (mended, count) = octahedron(&flipped).with_agreeing_sides();
        assert_eq!(count, 3);
        assert!(MeshTopology::of(mended.triangles()).is_solid());
        let outward = |triangle: &[u32; 3]| {
            let [a, b, c] = triangle.map(|k| mended.vertices()[k as usize].coords);
            (b - a).cross(&(c - a)).dot(&a) > 0.0
        };
        assert!(mended.triangles().iter().all(outward));
        let (same, count) = octahedron(&OCTAHEDRON).with_agreeing_sides();
        assert_eq!((same.triangles(), count), (&OCTAHEDRON[..], 0));
    }

    #[test]
    fn a_band_with_one_side_is_left_with_an_edge() {
        // A Moebius band of five triangles.
        let band: Vec<[u32; 3]> = (0..5).map(|k| [k, (k + 1) % 5, (k + 2) % 5]).collect();
        let vertices = (0..5).map(|k| {
            let t = f64::from(k) * 1.256;
            Point3::new(t.cos(), t.sin(), 0.3 * f64::from(k))
        });
        let mesh = TriangleMesh::new(vertices.collect(), band).unwrap();
        let (mended, _) = mesh.with_agreeing_sides();
        assert!(!MeshTopology::of(mended.triangles()).is_oriented());
    }
}
