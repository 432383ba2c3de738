//! Base curves: a closed curve in each of many layers across the axis.

mod assemble;
mod closed;
mod project;
mod radial;
mod view_fields;

pub use closed::ClosedCurve;
pub use project::{CurveOptions, CurveReport, CurveStep, project_curves};
pub use view_fields::ViewField;

use crate::defects::self_loops;
use crate::section::from_middle;
use crate::{AxisFrame, Error, Neighbourhood, Sharpness, Turntable, parallel};
use nalgebra::{Vector2, Vector3};
use std::f64::consts::TAU;

/// Typical distance of samples of a base curve, in pitches of the cloud.
pub(crate) const SAMPLE_SPACING: f64 = 2.5;
/// Most layers, and most samples on a curve.
const MOST_LAYERS: usize = 100;
pub(crate) const MOST_SAMPLES: usize = 200;
/// Share of the directions in which an end layer must have points.
const CLOSED: f64 = 0.9;
/// Share of the layers that may fail.
const MOST_FAILED: f64 = 0.34;
/// Points that tell the kind of section.
const SECTION: usize = 300;
/// Points of a layer by which a curve is judged.
const JUDGED: usize = 400;

/// How base curves are made.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct BaseCurveOptions {
    /// Number of views of the turntable; default as many as the shape asks for, at least 4.
    pub views: Option<usize>,
    /// Sharpness of hidden point removal.
    pub sharpness: Sharpness,
    /// Number of layers; default so that they are about 2.5 times its pitch apart.
    pub layers: Option<usize>,
    /// Number of samples of the longest curve; default so that they are about 2.5 times its pitch apart.
    pub samples: Option<usize>,
}

/// Where the curve of a layer comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(rename_all = "snake_case"))]
pub enum CurveOrigin {
    /// From the height fields of the views, trimmed where neighbours intersect.
    Views,
    /// From the distances of the layer's points from its middle: the views left gaps or loops.
    Radial,
}

/// The closed curve of a layer.
#[derive(Clone, Debug, PartialEq)]
pub struct LayerCurve {
    /// Height of the layer along the axis.
    pub height: f64,
    /// The curve in the coordinates across the axis, anticlockwise.
    pub curve: ClosedCurve,
    /// Where it comes from.
    pub origin: CurveOrigin,
}

/// The base curves of a cloud on a turntable.
#[derive(Clone, Debug)]
pub struct BaseCurves {
    /// One curve for each layer that has one, from the lowest up.
    pub curves: Vec<LayerCurve>,
    /// Number of views.
    pub views: usize,
    /// Share of the points that at least one view shows.
    pub seen: f64,
    /// Layers that were tried.
    pub layers: usize,
    /// Heights between which the layers close around the axis.
    pub heights: [f64; 2],
}

impl LayerCurve {
    /// A point of the layer in space.
    pub(crate) fn lift(&self, frame: &AxisFrame, p: &Vector2<f64>) -> Vector3<f64> {
        frame.to_world(&Vector3::new(p.x, p.y, self.height))
    }
}

/// Makes the base curves of a cloud ([MPK, secs. 3.2-3.4]).
///
/// The visible points of each view become a height field by multilevel B-splines; in each layer the height fields of
/// neighbouring views are cut where they meet, samples away from the cloud are dropped, and a closed curve is laid through
/// the rest. A layer in which this leaves gaps or loops gets its curve from the mean distances around its middle.
///
/// # Errors
/// [`Error::Shape`] where too few layers close around the axis; as [`Turntable::views`].
pub fn base_curves(
    table: &Turntable,
    cloud: &Neighbourhood,
    options: &BaseCurveOptions,
) -> Result<BaseCurves, Error> {
    let (views, seen) = match options.views {
        Some(count) if count < 3 => {
            return Err(Error::Option { name: "views", value: count as f64, allowed: "at least 3" });
        }
        Some(count) => {
            let views = table.views(cloud.points(), count, options.sharpness)?;
            let seen = (0..cloud.points().len()).filter(|&i| views.iter().any(|v| v.visible[i])).count();
            (views, seen as f64 / cloud.points().len() as f64)
        }
        None => table.views_as_needed(cloud.points(), options.sharpness)?,
    };
    let local: Vec<Vector3<f64>> = cloud.points().iter().map(|p| table.frame.to_local(p)).collect();
    let heights = closed_range(&local, table.heights, cloud.pitch());
    let length = heights[1] - heights[0];
    if length < 4.0 * cloud.pitch() {
        return Err(Error::Shape {
            wanted: "a cylinder",
            why: "there is no stretch along the axis where its layers close around it; choose another axis or shape".into(),
        });
    }
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped")]
    let automatic =
        (length / (SAMPLE_SPACING * cloud.pitch())).round().clamp(7.0, MOST_LAYERS as f64) as usize;
    let layers = options.layers.unwrap_or(automatic);
    if layers < 4 {
        return Err(Error::Option { name: "layers", value: layers as f64, allowed: "at least 4" });
    }
    let fields = parallel::tasks(views.len(), |i| ViewField::new(table, cloud.points(), &views[i]));
    let fields: Vec<ViewField> = fields.into_iter().collect::<Result<_, _>>()?;
    let step = length / (layers - 1) as f64;
    let slices = slices(&local, heights[0], step, layers);
    let most = options.samples.unwrap_or(MOST_SAMPLES);
    let made = parallel::tasks(layers, |j| {
        let height = heights[0] + step * j as f64;
        let place = |p: &Vector2<f64>| cloud.distance(&table.frame.to_world(&Vector3::new(p.x, p.y, height)));
        let around = around(&slices, j);
        layer(height, &fields, [&slices[j], &around], &place, cloud.pitch(), most)
    });
    let curves: Vec<LayerCurve> = made.into_iter().flatten().collect();
    if (curves.len() as f64) < (1.0 - MOST_FAILED) * layers as f64 || curves.len() < 4 {
        return Err(Error::Shape {
            wanted: "a cylinder",
            why: format!(
                "only {} of {layers} layers across the axis close around it; choose another axis or shape",
                curves.len()
            ),
        });
    }
    Ok(BaseCurves { curves, views: views.len(), seen, layers, heights })
}

/// The points of a layer and of as many of its neighbours as it takes to tell the kind of section.
fn around(slices: &[Vec<Vector2<f64>>], j: usize) -> Vec<Vector2<f64>> {
    let mut found = slices[j].clone();
    for away in 1..=slices.len() / 10 {
        if found.len() >= SECTION {
            break;
        }
        for k in [j.checked_sub(away), Some(j + away).filter(|&k| k < slices.len())].into_iter().flatten() {
            found.extend_from_slice(&slices[k]);
        }
    }
    found
}

/// The curve of one layer.
fn layer(
    height: f64,
    fields: &[ViewField],
    [slice, around]: [&[Vector2<f64>]; 2],
    distance: &(dyn Fn(&Vector2<f64>) -> f64 + Sync),
    spacing: f64,
    most: usize,
) -> Option<LayerCurve> {
    let curve = |polygon: Vec<Vector2<f64>>| {
        let curve = ClosedCurve::through_polygon(&polygon, SAMPLE_SPACING * spacing, most)?;
        (self_loops(&curve.polygon(4)) == 0).then_some(curve)
    };
    let views = assemble::polygon(height, fields, distance, spacing).and_then(curve);
    let radial = radial::polygon(slice, around, SAMPLE_SPACING * spacing).and_then(curve);
    let judge = |curve: &ClosedCurve| {
        let polygon = curve.polygon(2);
        let step = slice.len().div_ceil(JUDGED).max(1);
        let distances = slice.iter().step_by(step).map(|p| distance_from(&polygon, p));
        distances.map(|d| d.min(20.0 * spacing)).sum::<f64>() / slice.len().div_ceil(step).max(1) as f64
    };
    let (curve, origin) = match (views, radial) {
        (Some(a), Some(b)) if judge(&a) > 1.2 * judge(&b) + 0.25 * spacing => (b, CurveOrigin::Radial),
        (Some(a), _) => (a, CurveOrigin::Views),
        (None, Some(b)) => (b, CurveOrigin::Radial),
        (None, None) => return None,
    };
    Some(LayerCurve { height, curve, origin })
}

/// Distance from a closed polygon.
fn distance_from(polygon: &[Vector2<f64>], p: &Vector2<f64>) -> f64 {
    let edges = polygon.iter().zip(polygon.iter().cycle().skip(1));
    edges.fold(f64::INFINITY, |best, (a, b)| {
        let e = b - a;
        let t = ((p - a).dot(&e) / e.norm_squared().max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
        best.min((p - a - e * t).norm())
    })
}

/// Points of each layer: those up to half a step away, or 1.5 steps where these are few.
fn slices(local: &[Vector3<f64>], low: f64, step: f64, layers: usize) -> Vec<Vec<Vector2<f64>>> {
    let mut slices = vec![Vec::new(); layers];
    for p in local {
        let place = ((p.z - low) / step).round();
        if place >= 0.0 && place < layers as f64 {
            #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "inside the range")]
            slices[place as usize].push(p.xy());
        }
    }
    slices
}

/// The heights between which the points go all around.
fn closed_range(local: &[Vector3<f64>], [low, high]: [f64; 2], spacing: f64) -> [f64; 2] {
    // Bins that a full layer fills: on average more than three points in each.
    let length = high - low;
    let slab = (4.0 * spacing).max(length / 200.0);
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "at most 201")]
    let count = ((length / slab) as usize).max(1);
    let per_slab = local.len() as f64 / count as f64;
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped")]
    let bins = (per_slab / 5.0).clamp(6.0, 24.0) as usize;
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped")]
    let slot = |value: f64, count: usize| ((value * count as f64).max(0.0) as usize).min(count - 1);
    let mut sections: Vec<Vec<Vector2<f64>>> = vec![Vec::new(); count];
    for p in local {
        sections[slot((p.z - low) / length, count)].push(p.xy());
    }
    let mut occupied = vec![false; count * bins];
    for (row, section) in sections.iter().enumerate() {
        for away in from_middle(section).0 {
            occupied[row * bins + slot(away.y.atan2(away.x) / TAU + 0.5, bins)] = true;
        }
    }
    let full = |row: &usize| {
        occupied[row * bins..(row + 1) * bins].iter().filter(|&&o| o).count() as f64 >= CLOSED * bins as f64
    };
    let (first, last) = ((0..count).find(full), (0..count).rev().find(full));
    match (first, last) {
        (Some(first), Some(last)) => {
            let at = |row: usize| low + length * row as f64 / count as f64;
            [at(first), at(last + 1)]
        }
        _ => [low, low],
    }
}
