//! Which points a mesh surrounds, and signed distances from it.

use super::winding::Winding;
use crate::Error;
use mesh_core::{MeshFootpoint, MeshProjector, TriangleMesh};
use nalgebra::{Point3, Vector3};

/// Share of the view from the triangles that must be closed; half a sphere comes to 0.6, a flat sheet to 0.
const CLOSED: f64 = 0.5;
/// Deviation of the winding number on a triangle from one half up to which its two sides are taken to be outside and inside.
const CLEAR: f64 = 0.2;

/// How it is told which points lie inside.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum InsideRule {
    /// By the pseudo-normal at the nearest point, turned outwards: the mesh bounds solids that do not overlap.
    Normals,
    /// Where the generalised winding number, of either sign, exceeds one half.
    Winding,
}

/// The points that a mesh surrounds, also one with holes, flipped triangles or self-intersections.
///
/// Flipped triangles are turned as their neighbours are. Of a closed mesh, a cavity bounded by triangles that face it is outside, and where
/// solids overlap is inside. Holes are closed as the generalised winding number does.
#[derive(Debug)]
pub struct Inside {
    projector: MeshProjector,
    winding: Winding,
    rule: InsideRule,
    /// The sign with which pseudo-normals point outwards.
    outwards: f64,
    closure: f64,
    turned: usize,
}

impl Inside {
    /// Prepares a mesh.
    ///
    /// # Errors
    /// [`Error::Mesh`] for a mesh without triangles of finite coordinates, [`Error::NoInside`] for one that surrounds nothing: a sheet, or a
    /// shell of which the larger share is open.
    pub fn new(mesh: &TriangleMesh) -> Result<Self, Error> {
        let (mesh, turned) = mesh.with_agreeing_sides();
        let projector = MeshProjector::new(&mesh)?;
        let corners = |triangle: &[u32; 3]| triangle.map(|k| mesh.vertices()[k as usize].coords);
        let winding = Winding::new(mesh.triangles().iter().map(corners).collect());
        let looks = winding.on_triangles();
        let sum: f64 = looks.iter().map(|(_, area)| area).sum();
        let closed = looks.iter().map(|(mean, area)| area * (2.0 * mean.abs()).min(1.0)).sum::<f64>();
        let closure = if sum > 0.0 { closed / sum } else { 0.0 };
        if closure < CLOSED {
            return Err(Error::NoInside { closure });
        }
        let is_clear = |sign: f64| looks.iter().all(|(mean, _)| (sign * mean - 0.5).abs() < CLEAR);
        let outwards = [1.0, -1.0].into_iter().find(|sign| projector.is_solid() && is_clear(*sign));
        let rule = if outwards.is_some() { InsideRule::Normals } else { InsideRule::Winding };
        Ok(Self { projector, winding, rule, outwards: outwards.unwrap_or(1.0), closure, turned })
    }

    /// Closest points of the mesh, its triangles turned to agree.
    #[must_use]
    pub const fn projector(&self) -> &MeshProjector {
        &self.projector
    }

    /// How inside is told.
    #[must_use]
    pub const fn rule(&self) -> InsideRule {
        self.rule
    }

    /// Number of triangles that were turned.
    #[must_use]
    pub const fn turned(&self) -> usize {
        self.turned
    }

    /// How much of the view from the triangles into what they surround is closed: 1 for a closed mesh, 0 for a flat sheet. The mean by area
    /// of twice the winding number on the triangles.
    #[must_use]
    pub const fn closure(&self) -> f64 {
        self.closure
    }

    /// The distance of a point from its closest point, negative inside.
    #[must_use]
    pub fn signed(&self, x: &Vector3<f64>, foot: &MeshFootpoint) -> f64 {
        match (self.rule, foot.signed_distance) {
            (InsideRule::Normals, Some(distance)) => self.outwards * distance,
            _ if self.winding.number(x).abs() > 0.5 => -foot.distance,
            _ => foot.distance,
        }
    }

    /// Whether a point is inside; false for one that is not finite.
    #[must_use]
    pub fn holds(&self, x: &Vector3<f64>) -> bool {
        match self.rule {
            InsideRule::Winding => self.winding.number(x).abs() > 0.5,
            InsideRule::Normals => {
                self.projector.project(&Point3::from(*x)).is_ok_and(|foot| self.signed(x, &foot) < 0.0)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A cube around a centre, its normals outwards.
    fn cube(centre: [f64; 3], half: f64) -> (Vec<Point3<f64>>, Vec<[u32; 3]>) {
        let corner = |k: u32| {
            let side = |bit: u32| if k >> bit & 1 == 0 { -half } else { half };
            Point3::new(centre[0] + side(0), centre[1] + side(1), centre[2] + side(2))
        };
        let faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let triangles = faces.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
        ((0..8).map(corner).collect(), triangles)
    }

    fn joined(parts: &[(Vec<Point3<f64>>, Vec<[u32; 3]>)]) -> TriangleMesh {
        let (mut points, mut triangles) = (Vec::new(), Vec::new());
        for (vertices, faces) in parts {
            let first = u32::try_from(points.len()).unwrap();
            points.extend(vertices);
            triangles.extend(faces.iter().map(|face| face.map(|k| k + first)));
        }
        TriangleMesh::new(points, triangles).unwrap()
    }

    fn signed(inside: &Inside, x: [f64; 3]) -> f64 {
        let foot = inside.projector().project(&Point3::from(x)).unwrap();
        let found = inside.signed(&Vector3::from(x), &foot);
        assert_eq!(inside.holds(&Vector3::from(x)), found < 0.0);
        found
    }

    #[test]
    fn a_solid_by_its_normals_whatever_their_side() {
        let (points, mut faces) = cube([0.0; 3], 1.0);
        for turn in 0..3 {
            // As it is; inside out; with one triangle turned.
            match turn {
                1 => faces.iter_mut().for_each(|face| face.swap(1, 2)),
                2 => faces[4].swap(1, 2),
                _ => {}
            }
            let inside = Inside::new(&joined(&[(points.clone(), faces.clone())])).unwrap();
            assert_eq!((inside.rule(), inside.turned()), (InsideRule::Normals, turn / 2));
            assert!((inside.closure() - 1.0).abs() < 1e-9);
            assert_eq!(signed(&inside, [0.0, 0.0, 0.25]), -0.75);
            assert_eq!(signed(&inside, [0.0, 0.0, 1.25]), 0.25);
        }
    }

    #[test]
    fn cavities_are_outside_and_overlaps_inside() {
        let outer = cube([0.0; 3], 2.0);
        let mut cavity = cube([0.0; 3], 1.0);
        cavity.1.iter_mut().for_each(|face| face.swap(1, 2));
        let inside = Inside::new(&joined(&[outer.clone(), cavity])).unwrap();
        assert_eq!(inside.rule(), InsideRule::Normals);
        assert_eq!((signed(&inside, [0.0; 3]), signed(&inside, [1.5, 0.0, 0.0])), (1.0, -0.5));
        let inside = Inside::new(&joined(&[outer, cube([2.0, 0.0, 0.0], 1.0)])).unwrap();
        assert_eq!(inside.rule(), InsideRule::Winding);
        // Next to the second cube's face within the first.
        assert!(signed(&inside, [0.9, 0.0, 0.0]) < 0.0 && signed(&inside, [1.1, 0.0, 0.0]) < 0.0);
        assert!(signed(&inside, [2.5, 0.0, 0.0]) < 0.0 && signed(&inside, [3.1, 0.0, 0.0]) > 0.0);
    }

    #[test]
    fn what_is_mostly_open_surrounds_nothing() {
        let (points, faces) = cube([0.0; 3], 1.0);
        let open = |count: usize| Inside::new(&joined(&[(points.clone(), faces[..count].to_vec())]));
        let box_without_lid = open(10).unwrap();
        assert_eq!(box_without_lid.rule(), InsideRule::Winding);
        assert!((0.6..0.95).contains(&box_without_lid.closure()), "{}", box_without_lid.closure());
        assert!(signed(&box_without_lid, [0.0, 0.0, -0.5]) < 0.0);
        for count in [2, 1] {
            assert!(matches!(open(count), Err(Error::NoInside { closure }) if closure < 1e-6), "{count}");
        }
        // Two faces that meet at a right angle.
        let corner = joined(&[(points.clone(), [&faces[..2], &faces[4..6]].concat())]);
        assert!(matches!(Inside::new(&corner), Err(Error::NoInside { .. })));
    }
}
