//! Points and triangles in the form the page reads: 16-bit shares of a cube, in base64.

use super::Page;
use crate::base64::encode as base64;
use crate::colour::{ColourScale, STOPS};
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
    /// Points shown are every n-th of the file (all), unless `indices` says that there is a list.
    stride: usize,
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
    /// Number of points shown; of points chosen that lie outside of the picture; and of points that were not chosen.
    pub(super) shown: u64,
    pub(super) outside: u64,
    pub(super) unchosen: u64,
}

pub(super) fn pack(page: &Page<'_>) -> Packed {
    let is_finite = |point: &Point3<f64>| point.iter().all(|value| value.is_finite());
    let measured = page.picture.bounds().into_iter().flat_map(|bounds| [&bounds.min, &bounds.max]);
    let seen = measured.chain(&page.backdrop.vertices).filter(|point| is_finite(point));
    let none = (Vector3::repeat(f64::INFINITY), Vector3::repeat(f64::NEG_INFINITY));
    let (low, high) = seen.fold(none, |(low, high), point| (low.inf(&point.coords), high.sup(&point.coords)));
    let (low, high) = if low.x <= high.x { (low, high) } else { (Vector3::zeros(), Vector3::zeros()) };
    let side = ((high - low).amax() * 1.02).max(low.amax().max(high.amax()) * 1e-12).max(f64::MIN_POSITIVE);
    let origin = (low + high) * 0.5 - Vector3::repeat(0.5 * side);
    let share = |point: &Point3<f64>| (point.coords - origin) / side;

    let inside = |point: &Point3<f64>| share(point).iter().all(|s| (0.0..=1.0).contains(s));
    let mut kept = page.picture.sample();
    let unchosen = page.picture.finite().saturating_sub(kept.len() as u64);
    kept.retain(|shown| inside(&shown.point));
    let outside = page.picture.points().saturating_sub(kept.len() as u64 + unchosen);
    let indices = || kept.iter().map(|shown| u32::try_from(shown.index).unwrap_or(u32::MAX));
    let listed = indices().zip(0u32..).any(|(index, expected)| index != expected);

    let points = kept.iter().map(|shown| share(&shown.point));
    let deviations = kept.iter().flat_map(|shown| shown.deviation.to_le_bytes());
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
        blobs.push(("indices", base64(&indices().flat_map(u32::to_le_bytes).collect::<Vec<u8>>())));
    }
    let tolerance = page.inspection.options.tolerance;
    // Limits of infinity are beyond every number that a shader knows.
    let limit = |value: f64| value.clamp(-1e30, 1e30);
    let scene = Scene {
        origin: origin.into(),
        side,
        low: ((low - origin) / side).into(),
        high: ((high - origin) / side).into(),
        stride: 1,
        indices: listed,
        lines: !backdrop.lines.is_empty(),
        lower: limit(tolerance.lower),
        target: limit(tolerance.target()),
        upper: limit(tolerance.upper),
        stops: STOPS,
        edge: ColourScale::LIMIT,
    };
    Packed { scene, blobs, shown: kept.len() as u64, outside, unchosen }
}

fn quantise(value: f64, low: f64, high: f64) -> f64 {
    value.round().clamp(low, high)
}

#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "limited to the range of u16")]
fn shares(points: impl Iterator<Item = Vector3<f64>>) -> Vec<u8> {
    let bytes = |share: f64| (quantise(share * 65535.0, 0.0, 65535.0) as u16).to_le_bytes();
    points.flat_map(|point| [point.x, point.y, point.z]).flat_map(bytes).collect()
}
