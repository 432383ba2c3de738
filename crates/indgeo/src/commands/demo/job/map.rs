//! The scan unrolled: position along the axis over angle.

use super::bolt::{Bolt, is_inside};
use super::colour::{self, BEYOND, STEPS};
use super::scale::Scale;
use super::svg::Svg;
use crate::commands::project::job::Projected;

/// Draws a dot per point of the scan.
pub(crate) fn draw(
    svg: &mut Svg,
    bolt: &Bolt,
    projected: &Projected,
    height: Scale,
    angle: Scale,
    limit: f64,
) {
    let mut groups = vec![Vec::new(); STEPS + 1];
    for (point, foot) in projected.points.positions.iter().zip(&projected.feet) {
        let at = bolt.cylindrical(point);
        let step = if is_inside(foot) { colour::step(foot.distance, limit) } else { STEPS };
        groups[step].push([height.at(at.height), angle.at(at.angle * 360.0)]);
    }
    svg.dots(&groups[STEPS], 2.4, BEYOND);
    for (step, dots) in groups[..STEPS].iter().enumerate() {
        svg.dots(dots, 4.2, colour::colour(step, 1.0));
    }
}
