//! Choosing the side to which the normals of a cloud point.

use nalgebra::{Point3, Vector3};

use super::spanning_forest::{Forest, Link, links};
use super::unit;
use crate::{CloudIndex, Error};

/// Turns the normals to the side on which the view point lies. Zero normals stay.
///
/// # Errors
/// [`Error::AttributeLength`] if there is not one normal per point, [`Error::NonFinitePoint`] if the view point is not
/// finite.
pub fn orient_towards(
    points: &[Point3<f64>],
    normals: &mut [Vector3<f64>],
    view_point: &Point3<f64>,
) -> Result<(), Error> {
    check_length(points, normals)?;
    if !view_point.iter().all(|value| value.is_finite()) {
        return Err(Error::NonFinitePoint { x: view_point.x, y: view_point.y, z: view_point.z });
    }
    for (point, normal) in points.iter().zip(normals) {
        if normal.dot(&(view_point - point)) < 0.0 {
            *normal = -*normal;
        }
    }
    Ok(())
}

/// Turns the normals to one side of the surface, the outside of closed shapes; returns the number of pieces.
///
/// The orientation of one normal propagates along the links of a minimum spanning tree of the graph of nearest
/// neighbours ([HDDMS92, sec. 3.3]), where a link costs the angle between the normals, one of them reflected (\[KG09\]), and
/// the angle by which it leaves the tangent planes. Where the graph falls into pieces, every piece is oriented on its own:
/// at its extreme point along the coordinate axis that fits best, the normal points outwards. Points without a normal
/// (zero) take no part.
///
/// # Errors
/// [`Error::AttributeLength`] if there is not one normal per point, [`Error::TooFew`] if `neighbours` is 0,
/// [`Error::TooMany`] beyond 32-bit indices.
pub fn orient_consistently(
    points: &[Point3<f64>],
    normals: &mut [Vector3<f64>],
    neighbours: usize,
) -> Result<usize, Error> {
    check_length(points, normals)?;
    if neighbours == 0 {
        return Err(Error::TooFew { what: "neighbours", count: 0, least: 1 });
    }
    let index = CloudIndex::new(points)?;
    let lists =
        index.map_nearest_n(points, neighbours.saturating_add(1), |i, near| links(i, near, neighbours));
    Ok(propagate(points, |i| &lists[i], normals))
}

fn check_length(points: &[Point3<f64>], normals: &[Vector3<f64>]) -> Result<(), Error> {
    if points.len() == normals.len() {
        return Ok(());
    }
    Err(Error::AttributeLength { name: "normals".to_owned(), found: normals.len(), expected: points.len() })
}

/// The link between two neighbouring points.
///
/// On a sphere or a circle, and over a thin rim, the normal at one point is the mirror image of that at the other in the plane
/// between them (\[KG09\]); compared as they are, normals on both sides of a thin wall would seem to agree.
fn link(points: [&Point3<f64>; 2], [first, second]: [&Vector3<f64>; 2]) -> Link {
    let along = points[1] - points[0];
    let squared = along.norm_squared();
    let (along, squared) = if squared.is_normal() {
        (along, squared)
    } else {
        (unit(&along).unwrap_or_else(Vector3::zeros), 1.0)
    };
    let slopes = [along.dot(first), along.dot(second)];
    // The cosine of the angle between the second normal and the first, reflected.
    let agreement = first.dot(second) - 2.0 * slopes[0] * slopes[1] / squared;
    // The square of the sine of the angle by which the link leaves the tangent planes.
    let steepness_sq = (slopes[0] * slopes[0]).max(slopes[1] * slopes[1]) / squared;
    // 0 for equal normals across the link, at most 1.
    let cost = (0.5 * (1.0 - agreement.abs()).max(0.0) + 0.5 * steepness_sq).sqrt();
    Link { cost, opposite: agreement < 0.0 }
}

/// Propagates orientations between points that are linked, and returns the number of pieces.
pub(crate) fn propagate<'a>(
    points: &[Point3<f64>],
    neighbours: impl Fn(usize) -> &'a [u32],
    normals: &mut [Vector3<f64>],
) -> usize {
    let exists = |i: usize| normals[i] != Vector3::zeros();
    let mut forest = Forest::new(points.len(), neighbours, |i, j| {
        (exists(i) && exists(j)).then(|| link([&points[i], &points[j]], [&normals[i], &normals[j]]))
    });
    let mut pieces: Vec<Option<Extremes>> = vec![None; points.len()];
    let mut roots = Vec::new();
    let taking_part: Vec<u32> =
        (0u32..).zip(0..points.len()).filter(|&(_, i)| exists(i)).map(|(i, _)| i).collect();
    for &i in &taking_part {
        let (root, _) = forest.root_of(i);
        let piece = &mut pieces[root as usize];
        match piece {
            Some(extremes) => extremes.widen(points, i),
            None => {
                *piece = Some(Extremes([i; 6]));
                roots.push(root);
            }
        }
    }
    let mut turned = vec![false; points.len()];
    for &root in &roots {
        if let Some(extremes) = pieces[root as usize] {
            let (top, is_inward) = extremes.inward(normals);
            turned[root as usize] = is_inward ^ forest.root_of(top).1;
        }
    }
    for &i in &taking_part {
        let (root, opposite) = forest.root_of(i);
        if turned[root as usize] ^ opposite {
            normals[i as usize] = -normals[i as usize];
        }
    }
    roots.len()
}

/// The outermost points along `x, −x, y, −y, z, −z`.
#[derive(Clone, Copy)]
struct Extremes([u32; 6]);

impl Extremes {
    fn widen(&mut self, points: &[Point3<f64>], i: u32) {
        for (k, top) in self.0.iter_mut().enumerate() {
            let height = |index: u32| points[index as usize][k / 2] * SIGNS[k % 2];
            if height(i) > height(*top) {
                *top = i;
            }
        }
    }

    /// The one whose normal lies most along its axis, and whether that normal points inwards.
    fn inward(&self, normals: &[Vector3<f64>]) -> (u32, bool) {
        let along = |k: usize| normals[self.0[k] as usize][k / 2] * SIGNS[k % 2];
        let best = (1..6).fold(0, |best, k| if along(k).abs() > along(best).abs() { k } else { best });
        (self.0[best], along(best) < 0.0)
    }
}

/// Directions along an axis.
const SIGNS: [f64; 2] = [1.0, -1.0];
