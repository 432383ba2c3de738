//! What kind of surface a cloud is.

use crate::plane_frame::plane_frame;
use crate::section::Section;
use crate::{AxisEstimate, AxisFrame, Error, MultilevelOptions, Neighbourhood, Weighting, multilevel};
use nalgebra::{Vector2, Vector3};
use std::f64::consts::{PI, TAU};

/// The kind of base surface.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(rename_all = "snake_case"))]
pub enum Shape {
    /// Decided by the cloud.
    #[default]
    Auto,
    /// Closed around an axis, open at both ends.
    Cylinder,
    /// A height field.
    Plane,
    /// Closed all around, seen from its middle.
    Sphere,
}

impl Shape {
    /// The name used in files and on the command line.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Auto => "auto",
            Self::Cylinder => "cylinder",
            Self::Plane => "plane",
            Self::Sphere => "sphere",
        }
    }
}

/// A kind of surface and what speaks for it.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct ShapeDecision {
    /// The kind.
    pub shape: Shape,
    /// The reason, with numbers.
    pub why: String,
}

/// Residual of a height field, in spacings, up to which a cloud counts as one.
const FLAT: f64 = 1.0;
/// Share of directions around the axis that a cylinder covers.
const AROUND: f64 = 0.85;
/// Widest gap in these directions, as a share of a whole turn.
const GAP: f64 = 0.12;
/// Density of points on the ends of a cylinder, as a share of that on its side, above which it is closed.
const CAPPED: f64 = 0.35;
/// Share of the points of a thin end that may lie between its sides.
const THIN_END: f64 = 0.1;
/// Share of directions that the layers of a cylinder cover whose ends are closed in part, as by the platform of a blade.
const CLOSED: f64 = 0.95;
/// Residual of a height field, in spacings, up to which a cloud that is nothing else counts as one.
const NEARLY_FLAT: f64 = 3.0;
/// Share of the directions from the middle that a sphere covers.
const ALL_AROUND: f64 = 0.93;

/// Decides what kind of surface a cloud is.
///
/// It is plane-like if a height field over its principal plane meets it within the spacing of its points, or within three
/// spacings and it is nothing else, as half a cylinder; cylinder-like if its
/// layers close around the axis and the ends are open; sphere-like if points lie in all directions from its middle; and again
/// cylinder-like if its layers close and it is nothing else.
///
/// # Errors
/// [`Error::Shape`] if it is none of these.
pub fn decide(cloud: &Neighbourhood, axis: &AxisEstimate) -> Result<ShapeDecision, Error> {
    let flat = flatness(cloud)?;
    let around = axis.coverage.median();
    let ends = end_density(cloud, &axis.direction);
    let sphere = directions_covered(cloud.points());
    let decision = |shape, why: String| Ok(ShapeDecision { shape, why });
    if flat <= FLAT {
        return decision(
            Shape::Plane,
            format!("a height field over its principal plane leaves {flat:.2} spacings of its points"),
        );
    }
    if around >= AROUND && axis.coverage.typical_gap() <= GAP && ends < CAPPED {
        return decision(
            Shape::Cylinder,
            format!(
                "layers close around an axis ({:.0} % of the directions) and the ends are open ({:.0} % as dense as the side)",
                100.0 * around,
                100.0 * ends
            ),
        );
    }
    if sphere >= ALL_AROUND {
        return decision(
            Shape::Sphere,
            format!(
                "points lie in {:.0} % of all directions from the middle, and the ends of the axis are closed",
                100.0 * sphere
            ),
        );
    }
    if flat <= NEARLY_FLAT {
        return decision(
            Shape::Plane,
            format!(
                "it is open: layers close to {:.0} % around the best axis only, with gaps of {:.0} degrees; a height field over its principal plane leaves {flat:.2} spacings",
                100.0 * around,
                360.0 * axis.coverage.typical_gap()
            ),
        );
    }
    if around >= CLOSED && axis.coverage.typical_gap() <= GAP {
        return decision(
            Shape::Cylinder,
            format!(
                "layers close around an axis ({:.0} % of the directions), though points lie across its ends ({:.0} % as dense as on the side), and it is nothing else",
                100.0 * around,
                100.0 * ends
            ),
        );
    }
    let field = if flat.is_finite() {
        format!("a height field leaves {flat:.1} spacings")
    } else {
        "no height field meets it".to_owned()
    };
    Err(Error::Shape {
        wanted: "plane-, cylinder- or sphere-like",
        why: format!(
            "{field}, layers close to {:.0} % around the best axis with gaps of {:.0} degrees, and {:.0} % of the directions from the middle have points; choose the shape or the axis",
            100.0 * around,
            360.0 * axis.coverage.typical_gap(),
            100.0 * sphere
        ),
    })
}

/// What a height field over the principal plane leaves, in spacings.
fn flatness(cloud: &Neighbourhood) -> Result<f64, Error> {
    let frame = plane_frame(cloud.points())?;
    let local: Vec<Vector3<f64>> = cloud.points().iter().map(|p| frame.to_local(p)).collect();
    let options = MultilevelOptions::default().with_weighting(Weighting::Squared).with_data_per_piece(6.0);
    Ok(match multilevel(&local, None, &options) {
        Ok((_, report)) => report.rms / cloud.pitch(),
        Err(_) => f64::INFINITY,
    })
}

/// Density of points near the axis at the ends, as a share of that on the side.
fn end_density(cloud: &Neighbourhood, direction: &Vector3<f64>) -> f64 {
    let points = cloud.points();
    let centre = points.iter().sum::<Vector3<f64>>() / points.len() as f64;
    let Ok(frame) = AxisFrame::new(centre, direction) else { return 0.0 };
    let local: Vec<Vector3<f64>> = points.iter().map(|p| frame.to_local(p)).collect();
    let mut heights: Vec<f64> = local.iter().map(|p| p.z).collect();
    heights.sort_by(f64::total_cmp);
    let quantile = |share: f64| {
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "an index")]
        let index = (share * (heights.len() - 1) as f64) as usize;
        heights[index]
    };
    let (low, high) = (heights[0], heights[heights.len() - 1]);
    let density = [(low, quantile(0.1), -1.0), (quantile(0.9), high, 1.0)].map(|(from, to, _)| {
        let end: Vec<&Vector3<f64>> = local.iter().filter(|p| p.z >= from && p.z <= to).collect();
        let across: Vec<Vector2<f64>> = end.iter().map(|p| p.xy()).collect();
        if let Some(section) = Section::of(&across) {
            // Thin and with nothing between its sides: open.
            let inner = across.iter().filter(|p| section.straightened(p).norm() < 0.5).count() as f64;
            return if inner < THIN_END * across.len() as f64 { 0.0 } else { f64::INFINITY };
        }
        let middle = across.iter().sum::<Vector2<f64>>() / across.len().max(1) as f64;
        let mut radii: Vec<f64> = across.iter().map(|p| (p - middle).norm()).collect();
        radii.sort_by(f64::total_cmp);
        let radius = radii.get(radii.len() * 9 / 10).copied().unwrap_or(0.0);
        let inner = radii.iter().filter(|&&r| r < 0.5 * radius).count() as f64;
        inner / (PI * 0.25 * radius * radius).max(f64::MIN_POSITIVE)
    });
    // Points on the side of the cylinder per area.
    let mut radii: Vec<f64> = local.iter().map(|p| p.xy().norm()).collect();
    radii.sort_by(f64::total_cmp);
    let side = points.len() as f64 / (TAU * radii[radii.len() / 2] * (high - low)).max(f64::MIN_POSITIVE);
    density[0].min(density[1]) / side
}

/// Share of cells of equal solid angle, seen from the mean, that have points.
fn directions_covered(points: &[Vector3<f64>]) -> f64 {
    let (low, high) = points.iter().fold((points[0], points[0]), |(l, h), p| (l.inf(p), h.sup(p)));
    let centre = (low + high) / 2.0;
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped")]
    let rows = ((points.len() as f64 / 16.0).sqrt() as usize).clamp(4, 20);
    let columns = 2 * rows;
    let mut occupied = vec![false; rows * columns];
    for d in points.iter().filter_map(|p| (p - centre).try_normalize(0.0)) {
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped")]
        let row = (((d.z + 1.0) / 2.0 * rows as f64) as usize).min(rows - 1);
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped")]
        let column = ((d.y.atan2(d.x) / TAU + 0.5) * columns as f64) as usize;
        occupied[row * columns + column.min(columns - 1)] = true;
    }
    occupied.iter().filter(|&&o| o).count() as f64 / occupied.len() as f64
}
