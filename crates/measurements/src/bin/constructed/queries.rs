//! Where the queries lie: on the shape, next to it, around it, and where it focuses.

use measurements::random::Random;
use nalgebra::Vector3;
use nurbs_core::{BsplineSurface, ParametricSurface};

/// Shares of the size by which queries are moved away from singular places.
const OFFSETS: [f64; 5] = [0.0, 1e-9, 1e-6, 1e-3, 1e-2];

/// `count` queries about a surface of the given size, of eight kinds in turn.
pub(crate) fn queries(surface: &BsplineSurface, size: f64, count: usize) -> Vec<Vector3<f64>> {
    let domain = surface.domain();
    let mut random = Random(77);
    let points = surface.control_points();
    let low = points.iter().fold(points[0], |a, p| a.inf(p));
    let high = points.iter().fold(points[0], |a, p| a.sup(p));
    // Steep shapes are high: near is what is near as seen from the sides.
    let narrow = (high - low).iter().copied().filter(|&side| side > 1e-9 * size).fold(size, f64::min);
    (0..count)
        .map(|i| {
            let mut at = [0, 1].map(|d| domain[d].lerp(random.unit()));
            if i % 8 == 3 {
                let d = random.pick(&[0, 1]);
                at[d] = random.pick(&[domain[d].start(), domain[d].end()]);
            }
            let jet = surface.jet(at[0], at[1]);
            let side: Vector3<f64> = random.direction();
            let normal = jet.du.cross(&jet.dv).try_normalize(0.0).unwrap_or(side);
            let inside = Vector3::from_fn(|d, _| random.between(low[d], high[d]));
            let sign = random.pick(&[-1.0, 1.0]);
            match i % 8 {
                0 => jet.point,
                1 => jet.point + normal * random.between(-0.01, 0.01) * narrow,
                2 => jet.point + normal * sign * random.between(0.05, 0.5) * narrow,
                3 => jet.point + side * random.between(0.0, 0.3) * narrow,
                4 => inside,
                5 => jet.point + side * random.between(1.0, 3.0) * size,
                6 => {
                    // The centre of the flattest or the sharpest normal section.
                    let form = [jet.du.norm_squared(), jet.du.dot(&jet.dv), jet.dv.norm_squared()];
                    let bend = [&jet.duu, &jet.duv, &jet.dvv].map(|second| second.dot(&normal));
                    let a = form[0] * form[2] - form[1] * form[1];
                    let b = bend[0] * form[2] + bend[2] * form[0] - 2.0 * bend[1] * form[1];
                    let c = bend[0] * bend[2] - bend[1] * bend[1];
                    let curvature = (b + sign * (b * b - 4.0 * a * c).max(0.0).sqrt()) / (2.0 * a);
                    let radius = 1.0 / curvature;
                    let centre = if radius.abs() < size { jet.point + normal * radius } else { inside };
                    centre + side * random.pick(&OFFSETS) * size
                }
                _ => {
                    // The middle of the shape and its axis.
                    let mut middle = 0.5 * (low + high);
                    middle.z = if i % 16 == 7 { middle.z } else { random.between(low.z, high.z) };
                    middle + side * random.pick(&OFFSETS) * size
                }
            }
        })
        .collect()
}
