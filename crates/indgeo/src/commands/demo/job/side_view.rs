//! The scan seen from the side, coloured by its deviation.

use super::bolt::{Bolt, is_inside};
use super::colour::{self, BEYOND, STEPS};
use super::scale::Scale;
use super::svg::Svg;
use crate::commands::project::job::Projected;
use industrial_geometry::mesh::nalgebra::Vector3;
use std::collections::BTreeMap;

/// Slices of depth, drawn from the back to the front.
const SLICES: f64 = 12.0;
/// Degrees of light.
const LIGHTS: f64 = 5.0;

/// Slice of depth, step of colour, degree of light.
type Group = (i64, usize, i64);

/// Draws the triangles that face the viewer. `height` maps positions along the axis, `across` those across it.
#[expect(clippy::cast_possible_truncation, reason = "numbers of slices and of degrees of light are small")]
pub(crate) fn draw(
    svg: &mut Svg,
    bolt: &Bolt,
    projected: &Projected,
    height: Scale,
    across: Scale,
    limit: f64,
) {
    let [near, far] = across.values;
    let mut groups: BTreeMap<Group, Vec<[[f64; 2]; 3]>> = BTreeMap::new();
    for corners in &projected.points.triangles {
        let corners = corners.map(|corner| corner as usize);
        let local = corners.map(|corner| Vector3::from(bolt.local(&projected.points.positions[corner])));
        let normal = (local[1] - local[0]).cross(&(local[2] - local[0])).normalize();
        // The viewer stands on the third axis. NaN does not face anybody.
        if normal.z.is_nan() || normal.z <= 0.0 {
            continue;
        }
        let depth = (local[0].z + local[1].z + local[2].z) / 3.0;
        let slice = ((depth - near) / (far - near).abs() * SLICES).floor() as i64;
        let light = (normal.z * LIGHTS).floor().min(LIGHTS - 1.0) as i64;
        let feet = corners.map(|corner| &projected.feet[corner]);
        let step = if feet.iter().all(|foot| is_inside(foot)) {
            colour::step(feet.iter().map(|foot| foot.distance).sum::<f64>() / 3.0, limit)
        } else {
            STEPS
        };
        let flat = local.map(|p| [height.at(p.x), across.at(p.y)]);
        groups.entry((slice, step, light)).or_default().push(flat);
    }
    for ((_, step, light), triangles) in &groups {
        let light = 0.72 + 0.28 * (*light as f64 + 1.0) / LIGHTS;
        let colour =
            if *step == STEPS { colour::darken(BEYOND, light) } else { colour::colour(*step, light) };
        svg.triangles(triangles, colour);
    }
}
