//! All turns of the thread laid over each other.

use super::bolt::{Bolt, is_on_thread};
use super::colour::{self, STEPS};
use super::scale::Scale;
use super::svg::Svg;
use crate::commands::project::job::Projected;

/// Draws the points of the thread by their position within the pitch and their radius, and the nominal profile.
pub(crate) fn draw(svg: &mut Svg, bolt: &Bolt, projected: &Projected, x: Scale, y: Scale, limit: f64) {
    let mut groups = vec![Vec::new(); STEPS];
    let thread =
        projected.points.positions.iter().zip(&projected.feet).filter(|(_, foot)| is_on_thread(foot));
    for (point, foot) in thread {
        let at = bolt.cylindrical(point);
        groups[colour::step(foot.distance, limit)].push([x.at(bolt.position(&at)), y.at(at.radius)]);
    }
    for (step, dots) in groups.iter().enumerate() {
        svg.dots(dots, 2.6, colour::colour(step, 0.92));
    }
    let line = bolt.profile.map(|[position, radius]| [x.at(position), y.at(radius)]);
    svg.polyline(&line, "#111", 2.0);
}
