//! Reads the registration cases, and makes clouds without random numbers.

#![allow(clippy::unwrap_used, reason = "helpers of tests may panic")]
#![allow(dead_code, reason = "each test uses a part")]

use distance_field::SurfaceField;
use nalgebra::Vector3;
use sdm_register::Pose;
use serde_json::Value;
use std::path::PathBuf;

pub(crate) struct Case {
    pub(crate) field: SurfaceField,
    pub(crate) points: Vec<Vector3<f64>>,
    pub(crate) normals: Vec<Vector3<f64>>,
    pub(crate) inliers: usize,
    pub(crate) diameter: f64,
    pub(crate) reference: Pose<3>,
    /// Angle from the true pose in degrees, and the start.
    pub(crate) starts: Vec<(f64, Pose<3>)>,
}

fn folder() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../fixtures/register-cases")
}

fn json(name: &str) -> Value {
    serde_json::from_slice(&std::fs::read(folder().join(name)).unwrap()).unwrap()
}

pub(crate) fn model() -> nurbs_core::BsplineSurface {
    serde_json::from_value(json("cad.json")).unwrap()
}

fn pose(rows: &Value) -> Pose<3> {
    Pose::<3>::from_row_major(&serde_json::from_value(rows.clone()).unwrap()).unwrap()
}

pub(crate) fn case(name: &str) -> Case {
    let case = json(&format!("{name}/case.json"));
    let bytes = std::fs::read(folder().join(name).join("source.ply")).unwrap();
    let end = b"end_header\n";
    let start = bytes.windows(end.len()).position(|w| w == end).unwrap() + end.len();
    let rows: Vec<f64> =
        bytes[start..].chunks_exact(8).map(|b| f64::from_le_bytes(b.try_into().unwrap())).collect();
    let points: Vec<_> = rows.chunks_exact(6).map(|r| Vector3::new(r[0], r[1], r[2])).collect();
    let normals = rows.chunks_exact(6).map(|r| Vector3::new(r[3], r[4], r[5])).collect();
    let starts = json(&format!("{name}/inits.json"));
    Case {
        field: SurfaceField::new(&model()).unwrap(),
        inliers: case["core_mask"].as_u64().map_or(points.len(), |n| usize::try_from(n).unwrap()),
        points,
        normals,
        diameter: case["diam"].as_f64().unwrap(),
        reference: pose(case.get("T_ref").unwrap_or(&case["T_gt"])),
        starts: starts
            .as_array()
            .unwrap()
            .iter()
            .map(|s| (s["angle_deg"].as_f64().unwrap(), pose(&s["T"])))
            .collect(),
    }
}

impl Case {
    /// Root mean square of `|T x − T_ref x|` over the inliers as a share of the diameter.
    pub(crate) fn error(&self, found: &Pose<3>) -> f64 {
        distance(&self.points[..self.inliers], found, &self.reference) / self.diameter
    }
}

/// Root mean square distance of two poses of some points.
pub(crate) fn distance<const D: usize>(
    points: &[nalgebra::SVector<f64, D>],
    a: &Pose<D>,
    b: &Pose<D>,
) -> f64 {
    let sum: f64 = points.iter().map(|x| (a.apply(x) - b.apply(x)).norm_squared()).sum();
    (sum / points.len() as f64).sqrt()
}

/// Numbers in [0, 1) that look random, always the same for a seed (xorshift).
pub(crate) struct Random(u64);

impl Random {
    pub(crate) fn new(seed: u64) -> Self {
        Self(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1)
    }

    pub(crate) fn uniform(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }

    pub(crate) fn normal(&mut self) -> f64 {
        let (u, v) = (1.0 - self.uniform(), self.uniform());
        (-2.0 * u.ln()).sqrt() * (2.0 * std::f64::consts::PI * v).cos()
    }

    pub(crate) fn vector(&mut self) -> Vector3<f64> {
        Vector3::new(self.normal(), self.normal(), self.normal())
    }
}
