//! From where two scans were seen, and what that says about a pose of one on the other.

use crate::commands::register::model::RegistrationModel;
use crate::commands::register::results::FreeSpaceResult;
use industrial_geometry::io::ReadReport;
use industrial_geometry::mesh::nalgebra::{Point3, Vector3};
use industrial_geometry::mesh::{BoundingBox, PointCloud};
use industrial_geometry::register::{Doubt, Pose, Rays, Viewpoint};

/// How far points float in front of a scan that contradict it, as a share of the size of the model.
const FLOATING: f64 = 0.02;
/// Points of a scan that are looked at.
const LOOKED_AT: usize = 4000;

/// The rays of the scans whose viewpoints are known, and points of each to be met by those of the other.
#[derive(Debug, Default)]
pub(crate) struct Sights {
    list: Vec<(&'static str, Rays)>,
    /// Some of the points of the model and of the other scan.
    points: [Vec<Vector3<f64>>; 2],
    /// In the unit of the model.
    margin: f64,
}

impl Sights {
    /// Of a model and points as read; nothing is known of a model that is no scan.
    pub(crate) fn new(model: &RegistrationModel, read: [&ReadReport; 2], points: &PointCloud) -> Self {
        let RegistrationModel::Cloud(cloud) = model else { return Self::default() };
        let Some(bounds) = BoundingBox::of(cloud.positions()) else { return Self::default() };
        let margin = FLOATING * bounds.diagonal();
        let scans = [("model", cloud, read[0]), ("points", points, read[1])];
        let list = scans
            .iter()
            .flat_map(|(name, cloud, read)| rays(cloud, read, margin).into_iter().map(|rays| (*name, rays)))
            .collect();
        Self { list, points: [some(cloud), some(points)], margin }
    }

    /// What the rays of each scan say about the other one in a pose of the points.
    pub(crate) fn look(&self, pose: &Pose<3>) -> Vec<FreeSpaceResult> {
        if self.list.is_empty() || !pose.is_finite() {
            return Vec::new();
        }
        let back = pose.inverse();
        let [model, points] = &self.points;
        let moved: Vec<_> = points.iter().map(|x| pose.apply(x)).collect();
        let there: Vec<_> = model.iter().map(|x| back.apply(x)).collect();
        let met = |(scan, rays): &(&'static str, Rays)| {
            let found = if *scan == "model" {
                rays.meet(&moved, self.margin)
            } else {
                rays.meet(&there, self.margin * back.scale)
            };
            FreeSpaceResult { scan, found }
        };
        self.list.iter().map(met).collect()
    }

    /// Why a pose cannot be that of the scans, as far as their rays tell.
    pub(crate) fn contradiction(&self, pose: &Pose<3>) -> Option<Doubt> {
        self.look(pose).iter().find_map(|one| one.found.doubt())
    }
}

/// Some of the points, evenly picked.
fn some(cloud: &PointCloud) -> Vec<Vector3<f64>> {
    let step = cloud.len().div_ceil(LOOKED_AT).max(1);
    cloud.positions().iter().step_by(step).map(|point| point.coords).collect()
}

/// The rays of the scans of a file by the places of their scanners; where the file states none, or such as the points contradict, by the
/// direction that all normals face.
fn rays(cloud: &PointCloud, read: &ReadReport, margin: f64) -> Vec<Rays> {
    let scans: Vec<_> = read.scans.iter().filter(|scan| scan.points > 0).collect();
    let numbers = cloud.attributes().scalar("scan");
    let of_scan = |number: usize| -> Option<Vec<Vector3<f64>>> {
        if scans.len() == 1 {
            return Some(coordinates(cloud.positions()));
        }
        let belongs = |value: &f64| *value == number as f64;
        let points = cloud.positions().iter().zip(numbers?).filter(|(_, value)| belongs(value));
        Some(points.map(|(point, _)| point.coords).collect())
    };
    let seen: Vec<Rays> = scans
        .iter()
        .filter_map(|scan| {
            let pose = scan.pose?;
            let origin = Viewpoint::Origin(Vector3::new(pose[0][3], pose[1][3], pose[2][3]));
            Rays::consistent(&of_scan(scan.number)?, &origin, margin)
        })
        .collect();
    if !seen.is_empty() {
        return seen;
    }
    let direction = cloud.attributes().normals().and_then(Viewpoint::of_normals);
    direction
        .and_then(|direction| Rays::new(&coordinates(cloud.positions()), &direction))
        .into_iter()
        .collect()
}

fn coordinates(points: &[Point3<f64>]) -> Vec<Vector3<f64>> {
    points.iter().map(|point| point.coords).collect()
}
