//! Choosing the side to which the normals of a cloud point.

use nalgebra::{Point3, Vector3};

use super::spanning_tree::Graph;
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
    let lists = index
        .map_nearest_n(points, neighbours.saturating_add(1), |i, near| Graph::links(i, near, neighbours));
    Ok(propagate(points, &Graph::new(points.len(), |i| &lists[i]), normals))
}

fn check_length(points: &[Point3<f64>], normals: &[Vector3<f64>]) -> Result<(), Error> {
    if points.len() == normals.len() {
        return Ok(());
    }
    Err(Error::AttributeLength { name: "normals".to_owned(), found: normals.len(), expected: points.len() })
}

/// Two neighbouring points.
struct Link {
    /// Cosine of the angle between the second normal and the first, reflected; negative if they are on different sides.
    agreement: f64,
    /// Square of the sine of the angle by which the link leaves the tangent planes.
    steepness_sq: f64,
}

impl Link {
    /// On a sphere or a circle, and over a thin rim, the normal at one point is the mirror image of that at the other in
    /// the plane between them (\[KG09\]); compared as they are, normals on both sides of a thin wall would seem to agree.
    fn new(points: &[Point3<f64>], [one, other]: [usize; 2], [first, second]: [&Vector3<f64>; 2]) -> Self {
        let along = points[other] - points[one];
        let squared = along.norm_squared();
        let (along, squared) = if squared.is_normal() {
            (along, squared)
        } else {
            (unit(&along).unwrap_or_else(Vector3::zeros), 1.0)
        };
        let slopes = [along.dot(first), along.dot(second)];
        Self {
            agreement: first.dot(second) - 2.0 * slopes[0] * slopes[1] / squared,
            steepness_sq: (slopes[0] * slopes[0]).max(slopes[1] * slopes[1]) / squared,
        }
    }

    /// 0 for equal normals across the link, at most 1.
    fn cost(&self) -> f64 {
        (0.5 * (1.0 - self.agreement.abs()).max(0.0) + 0.5 * self.steepness_sq).sqrt()
    }
}

/// Propagates orientations in every component of the graph and returns their number.
pub(crate) fn propagate(points: &[Point3<f64>], graph: &Graph, normals: &mut [Vector3<f64>]) -> usize {
    let components = graph.components(normals);
    let mut reached = vec![false; points.len()];
    // Costs do not see the sides, which are settled while the trees grow.
    let lines = normals.to_vec();
    for component in &components {
        let Some((root, outwards)) = extreme(points, normals, component) else { continue };
        if normals[root as usize].dot(&outwards) < 0.0 {
            normals[root as usize] = -normals[root as usize];
        }
        let cost = |one: usize, other: usize| {
            let exists = lines[other] != Vector3::zeros();
            exists.then(|| Link::new(points, [one, other], [&lines[one], &lines[other]]).cost())
        };
        graph.grow(root, &mut reached, cost, |parent, child| {
            if Link::new(points, [parent, child], [&normals[parent], &normals[child]]).agreement < 0.0 {
                normals[child] = -normals[child];
            }
        });
    }
    components.len()
}

/// The point that is farthest along one of the six axis directions, where its normal fits that direction best.
fn extreme(
    points: &[Point3<f64>],
    normals: &[Vector3<f64>],
    component: &[u32],
) -> Option<(u32, Vector3<f64>)> {
    let mut best: Option<(f64, u32, Vector3<f64>)> = None;
    for axis in 0..3 {
        for sign in [1.0, -1.0] {
            let height = |index: u32| sign * points[index as usize][axis];
            let top = component
                .iter()
                .copied()
                .reduce(|top, index| if height(index) > height(top) { index } else { top })?;
            let fit = normals[top as usize][axis].abs();
            if best.is_none_or(|(best, ..)| fit > best) {
                best = Some((fit, top, Vector3::ith(axis, sign)));
            }
        }
    }
    best.map(|(_, top, outwards)| (top, outwards))
}
