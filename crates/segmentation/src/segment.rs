//! The stages of a segmentation, in order.

use nalgebra::{Point3, Vector3};

use crate::assign::{assign, refit, settle, split};
use crate::border::cut;
use crate::common::share_helix;
use crate::describe::describe;
use crate::error::Error;
use crate::extrude::extrude;
use crate::graph::Graph;
use crate::grow::{Cloud, NONE, Region, primitives};
use crate::jets::{Jets, principal};
use crate::leftover::propose;
use crate::merge::merge;
use crate::options::SegmentationOptions;
use crate::regular::find_cones;
use crate::report::Segmentation;
use crate::smooth::{decide_again, find_sweeps, gather, gather_bent, join};

/// Fewest points of a cloud.
const FEWEST: usize = 4;
/// Noise below this share of the spacing is not told from none.
const FLOOR: f64 = 3e-4;
/// Fewest links of regions that may be one.
const LINKS: usize = 4;

/// Segments a cloud into regions that one surface carries each, by type: plane, cylinder, cone, sphere, torus, extrusion, revolution, helix,
/// free-form ([P05, sec. 6]).
///
/// Regions grow from the most certain neighbourhoods as long as the orthogonal distances agree with the noise, which is found from the
/// cloud itself; narrow and small faces are proposed by few points each; then every point goes to the carrier that explains it best
/// together with its neighbours. `normals`, where given (one per point, any length), only say on which side of a thin wall a point lies.
/// The points should cover the surfaces with at least 3 points across every face. Takes time linear in their number.
///
/// # Errors
/// [`Error::TooFewPoints`] for fewer than 4 points, [`Error::Degenerate`] for points in one place or on a line, [`Error::NotFinite`],
/// [`Error::Magnitude`], [`Error::Normals`] and [`Error::Option`] for input out of range.
///
/// ```
/// use nalgebra::Point3;
/// use segmentation::{SegmentationOptions, Shape, segment};
///
/// // Two faces of a box.
/// let grid = (0..400).map(|i| ((i % 20) as f64, (i / 20) as f64 + 0.5));
/// let points: Vec<_> = grid.flat_map(|(a, b)| [Point3::new(a, b, 0.0), Point3::new(a, 0.0, b)]).collect();
/// let found = segment(&points, None, &SegmentationOptions::default())?;
/// assert_eq!(found.regions.len(), 2);
/// assert!(found.regions.iter().all(|region| matches!(region.shape, Shape::Plane { .. })));
/// # Ok::<(), segmentation::Error>(())
/// ```
pub fn segment(
    points: &[Point3<f64>],
    normals: Option<&[Vector3<f64>]>,
    options: &SegmentationOptions,
) -> Result<Segmentation, Error> {
    options.check()?;
    let frame = Frame::of(points)?;
    let normals = normals.map(|n| unit_normals(n, points.len())).transpose()?;
    let scaled: Vec<Point3<f64>> = points.iter().map(|p| frame.inwards(p)).collect();
    if principal(&scaled).is_none() {
        return Err(Error::Degenerate { what: "on a line" });
    }
    let graph = Graph::new(&scaled, normals.as_deref())?;
    let mut jets = Jets::new(&scaled, &graph);
    let mut spacings = graph.spacing.clone();
    let place = spacings.len() / 2;
    let spacing = *spacings.select_nth_unstable_by(place, f64::total_cmp).1;
    let floor = (FLOOR * spacing).max(1e-12);
    let given = options.sigma.map(|s| (s / frame.scale).max(floor));
    let mut sigma = given.unwrap_or_else(|| jets.noise().max(floor));
    let mut labels = vec![NONE; scaled.len()];
    let mut regions = Vec::new();
    // The first regions tell the noise better than quadrics that reach over edges.
    for _ in 0..2 {
        jets.find_normals(&scaled, &graph, sigma);
        let cloud = Cloud { points: &scaled, graph: &graph, jets: &jets, sigma };
        labels.fill(NONE);
        regions = primitives(&cloud, &mut labels);
        let Some(better) = noise_of(&cloud, &regions).filter(|_| given.is_none()) else { break };
        let better = better.max(floor);
        let ratio = better / sigma;
        sigma = better;
        if (ratio - 1.0).abs() < 0.1 {
            break;
        }
    }
    let cloud = Cloud { points: &scaled, graph: &graph, jets: &jets, sigma };
    finish(&cloud, &mut regions, &mut labels, options.min_points);
    Ok(describe(&cloud, &regions, &labels, &frame, spacing))
}

/// Everything after growth.
fn finish(cloud: &Cloud<'_>, regions: &mut Vec<Region>, labels: &mut [u32], fewest: usize) {
    merge(cloud, regions, labels, LINKS);
    for round in 0..4 {
        assign(cloud, regions, labels);
        refit(cloud, regions, labels, fewest);
        split(cloud, regions, labels, fewest);
        refit(cloud, regions, labels, fewest);
        if round < 2 {
            propose(cloud, regions, labels);
        }
        if round >= 1 {
            gather(cloud, regions, labels);
        }
        merge(cloud, regions, labels, LINKS);
        extrude(cloud, regions, labels);
        if round >= 1 {
            join(cloud, regions, labels);
        }
        if round >= 2 {
            find_sweeps(cloud, regions);
        }
    }
    assign(cloud, regions, labels);
    refit(cloud, regions, labels, fewest);
    decide_again(cloud, regions);
    cut(cloud, regions, labels);
    refit(cloud, regions, labels, fewest);
    gather_bent(cloud, regions, labels);
    find_sweeps(cloud, regions);
    share_helix(cloud, regions);
    find_cones(cloud, regions, labels);
    settle(cloud, regions);
}

/// Standard deviation of the noise from the regions of many points, by the median.
fn noise_of(cloud: &Cloud<'_>, regions: &[Region]) -> Option<f64> {
    let mut distances: Vec<f64> = Vec::new();
    for region in regions.iter().filter(|r| r.points.len() >= 60) {
        let Some(carrier) = region.carrier else { continue };
        distances.extend(region.points.iter().map(|&i| carrier.at(&cloud.points[i as usize]).0.abs()));
    }
    if distances.len() < 200 {
        return None;
    }
    let place = distances.len() / 2;
    Some(*distances.select_nth_unstable_by(place, f64::total_cmp).1 / 0.6745)
}

/// The coordinates in which a cloud is segmented: about the middle of its box, in units of about its size (a power of 2).
#[derive(Clone, Copy, Debug)]
pub(crate) struct Frame {
    centre: Point3<f64>,
    pub(crate) scale: f64,
}

impl Frame {
    fn of(points: &[Point3<f64>]) -> Result<Self, Error> {
        if points.len() < FEWEST {
            return Err(Error::TooFewPoints { count: points.len(), needed: FEWEST });
        }
        if let Some(index) = points.iter().position(|p| !p.iter().all(|c| c.is_finite())) {
            return Err(Error::NotFinite { what: "point", index });
        }
        let (low, high) = points.iter().fold((points[0], points[0]), |(a, b), p| (a.inf(p), b.sup(p)));
        // Halves first: the difference of the largest doubles is not one.
        let half = high.coords / 2.0 - low.coords / 2.0;
        let size = half.amax();
        if size == 0.0 {
            return Err(Error::Degenerate { what: "in one place" });
        }
        if !(1e-100..=1e100).contains(&size) {
            return Err(Error::Magnitude { size: 2.0 * size });
        }
        Ok(Self { centre: low + half, scale: size.log2().ceil().exp2() })
    }

    fn inwards(&self, x: &Point3<f64>) -> Point3<f64> {
        Point3::from((x - self.centre) / self.scale)
    }

    pub(crate) fn outwards(&self, x: &Point3<f64>) -> Point3<f64> {
        self.centre + x.coords * self.scale
    }
}

fn unit_normals(normals: &[Vector3<f64>], count: usize) -> Result<Vec<Vector3<f64>>, Error> {
    if normals.len() != count {
        return Err(Error::Normals { normals: normals.len(), points: count });
    }
    if let Some(index) = normals.iter().position(|n| !n.iter().all(|c| c.is_finite())) {
        return Err(Error::NotFinite { what: "normal", index });
    }
    // A normal of length zero says nothing: it has the product 0 with all others.
    Ok(normals.iter().map(|n| n.try_normalize(0.0).unwrap_or_else(Vector3::zeros)).collect())
}
