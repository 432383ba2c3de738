//! Points and triangles in the form the page reads: 16-bit shares of a cube, in base64.

use super::Page;
use super::text::base64;
use crate::colour::{ColourScale, STOPS};
use crate::{DeviationRecord, Outcome};
use nalgebra::{Point3, Vector3};
use serde::Serialize;

/// What the script needs to know about the data.
#[derive(Debug, Serialize)]
pub(super) struct Scene {
    /// Corner of the cube with the smallest coordinates.
    origin: [f64; 3],
    /// Length of its sides.
    side: f64,
    /// Box of all that is shown, as shares of the cube.
    low: [f64; 3],
    high: [f64; 3],
    /// Points shown are every n-th of the file, unless `indices` says that there is a list.
    pub(super) stride: usize,
    indices: bool,
    /// Whether there are lines along edges.
    lines: bool,
    lower: f64,
    target: f64,
    upper: f64,
    stops: [[f64; 3]; 7],
    edge: f64,
}

/// The scene and the large arrays.
pub(super) struct Packed {
    pub(super) scene: Scene,
    /// Name and base64 of each array.
    pub(super) blobs: Vec<(&'static str, String)>,
    /// Number of points shown, and left out because they are far from the rest.
    pub(super) shown: usize,
    pub(super) outside: usize,
}

pub(super) fn pack(page: &Page<'_>) -> Packed {
    let is_finite = |point: &Point3<f64>| point.iter().all(|value| value.is_finite());
    let measured = (page.points.iter().zip(page.records))
        .filter(|(_, record)| record.outcome == Outcome::Measured)
        .map(|(point, _)| point);
    let seen = measured.chain(&page.backdrop.vertices).filter(|point| is_finite(point));
    let none = (Vector3::repeat(f64::INFINITY), Vector3::repeat(f64::NEG_INFINITY));
    let (low, high) = seen.fold(none, |(low, high), point| (low.inf(&point.coords), high.sup(&point.coords)));
    let (low, high) = if low.x <= high.x { (low, high) } else { (Vector3::zeros(), Vector3::zeros()) };
    let side = ((high - low).amax() * 1.02).max(low.amax().max(high.amax()) * 1e-12).max(f64::MIN_POSITIVE);
    let origin = (low + high) * 0.5 - Vector3::repeat(0.5 * side);
    let share = |point: &Point3<f64>| (point.coords - origin) / side;

    let inside =
        |point: &Point3<f64>| is_finite(point) && share(point).iter().all(|s| (0.0..=1.0).contains(s));
    let visible = (page.points.iter().zip(0u32..)).filter(|(p, _)| inside(p)).map(|(_, i)| i);
    let count = visible.clone().count();
    let outside = page.points.len() - count;
    let stride = count.div_ceil(page.most_points.max(1)).max(1);
    let kept: Vec<u32> = visible.step_by(stride).collect();
    let listed = kept.iter().zip((0u32..).step_by(stride)).any(|(&index, expected)| index != expected);

    let points = kept.iter().map(|&index| share(&page.points[index as usize]));
    let deviations = kept.iter().flat_map(|&index| shown(&page.records[index as usize]).to_le_bytes());
    let backdrop = page.backdrop;
    let normal = |normal: &Vector3<f64>| [0, 1, 2].map(|axis| quantise(normal[axis] * 127.0, -127.0, 127.0));
    #[expect(clippy::cast_possible_truncation, reason = "limited to the range of i8")]
    let normals: Vec<u8> =
        backdrop.normals.iter().flat_map(|n| normal(n).map(|value| (value as i8).cast_unsigned())).collect();
    let triangles = backdrop.triangles.iter().flatten().flat_map(|corner| corner.to_le_bytes());
    let mut blobs = vec![
        ("points", base64(&shares(points))),
        ("deviations", base64(&deviations.collect::<Vec<u8>>())),
        ("vertices", base64(&shares(backdrop.vertices.iter().map(share)))),
        ("normals", base64(&normals)),
        ("triangles", base64(&triangles.collect::<Vec<u8>>())),
    ];
    if !backdrop.lines.is_empty() {
        // Pairs of ends: a line is drawn from one to the other.
        let ends = backdrop.lines.iter().flat_map(|line| line.windows(2)).flatten();
        blobs.push(("lines", base64(&shares(ends.map(share)))));
    }
    if listed {
        blobs.push((
            "indices",
            base64(&kept.iter().flat_map(|index| index.to_le_bytes()).collect::<Vec<u8>>()),
        ));
    }
    let tolerance = page.inspection.options.tolerance;
    // Limits of infinity are beyond every number that a shader knows.
    let limit = |value: f64| value.clamp(-1e30, 1e30);
    let scene = Scene {
        origin: origin.into(),
        side,
        low: ((low - origin) / side).into(),
        high: ((high - origin) / side).into(),
        stride,
        indices: listed,
        lines: !backdrop.lines.is_empty(),
        lower: limit(tolerance.lower),
        target: limit(tolerance.target()),
        upper: limit(tolerance.upper),
        stops: STOPS,
        edge: ColourScale::LIMIT,
    };
    Packed { scene, blobs, shown: kept.len(), outside }
}

/// The deviation in single precision; NaN where none counts.
#[expect(clippy::cast_possible_truncation, reason = "single precision is what the page shows")]
fn shown(record: &DeviationRecord) -> f32 {
    if record.outcome == Outcome::Measured { record.distance as f32 } else { f32::NAN }
}

fn quantise(value: f64, low: f64, high: f64) -> f64 {
    value.round().clamp(low, high)
}

#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "limited to the range of u16")]
fn shares(points: impl Iterator<Item = Vector3<f64>>) -> Vec<u8> {
    let bytes = |share: f64| (quantise(share * 65535.0, 0.0, 65535.0) as u16).to_le_bytes();
    points.flat_map(|point| [point.x, point.y, point.z]).flat_map(bytes).collect()
}
