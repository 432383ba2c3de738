//! Places all over a surface, with the area that each stands for.

use crate::parallel;
use mesh_core::LoopSurface;
use nalgebra::Point3;
use nurbs_core::{BsplineSurface, KnotVector, ParametricSurface, TrimLoops};

/// Most samples.
const MOST_SAMPLES: f64 = 250_000.0;

/// Places on a surface.
pub(super) struct Samples {
    pub(super) places: Vec<Point3<f64>>,
    pub(super) parameters: Vec<[f64; 2]>,
    /// The area that each stands for.
    pub(super) areas: Vec<f64>,
    pub(super) resolution: f64,
}

/// Samples of a surface, in each cell as many as its length in each direction asks for; of what its loops bound, if there are any.
pub(super) fn samples_of_surface(surface: &BsplineSurface, trim: Option<&TrimLoops>, step: f64) -> Samples {
    let knots = [surface.knots_u(), surface.knots_v()];
    let spans = knots.map(|k| k.spans().collect::<Vec<_>>());
    let lengths = span_lengths(surface, knots, &spans);
    let counts_for =
        |step: f64| lengths.clone().map(|l| l.into_iter().map(|l| count(l, step)).collect::<Vec<usize>>());
    let total =
        |counts: &[Vec<usize>; 2]| counts.iter().map(|c| c.iter().sum::<usize>() as f64).product::<f64>();
    let mut counts = counts_for(step);
    if total(&counts) > MOST_SAMPLES {
        counts = counts_for(step * (total(&counts) / MOST_SAMPLES).sqrt());
    }
    // Short spans have one sample at least: more of them than samples are thinned out evenly.
    let places = [0, 1].map(|d| midpoints(knots[d], &spans[d], &counts[d]));
    let columns = places[1].len();
    let found = parallel::map(places[0].len() * columns, |k| {
        let ((u, du), (v, dv)) = (places[0][k / columns], places[1][k % columns]);
        let jet = surface.jet(u, v);
        let area = jet.du.cross(&jet.dv).norm() * du * dv;
        (Point3::from(jet.point), [u, v], area, jet.du.norm() * du, jet.dv.norm() * dv)
    });
    let inside = trim.map(|trim| {
        let [us, vs] = [0, 1].map(|d| places[d].iter().map(|p| p.0).collect::<Vec<f64>>());
        trim.contains_grid(&us, &vs)
    });
    let mut found = found;
    if let Some(inside) = inside {
        let mut flags = inside.into_iter();
        found.retain(|_| flags.next().unwrap_or(false));
    }
    let resolution = found.iter().map(|f| f.3.max(f.4)).fold(0.0, f64::max);
    Samples {
        places: found.iter().map(|f| f.0).collect(),
        parameters: found.iter().map(|f| f.1).collect(),
        areas: found.iter().map(|f| f.2).collect(),
        resolution,
    }
}

/// Largest length of each span in both directions, by chords.
pub(super) fn span_lengths(
    surface: &BsplineSurface,
    knots: [&KnotVector; 2],
    spans: &[Vec<usize>; 2],
) -> [Vec<f64>; 2] {
    /// Chords of a span, and lines across at most.
    const CHORDS: usize = 3;
    const LINES: usize = 64;
    [0, 1].map(|d| {
        let across = &spans[1 - d];
        let lines: Vec<f64> = (0..=2 * across.len())
            .step_by((2 * across.len() / LINES).max(1))
            .map(|k| {
                let interval = knots[1 - d].span_interval(across[(k / 2).min(across.len() - 1)]);
                interval.lerp(if k == 2 * across.len() { 1.0 } else { 0.5 * (k % 2) as f64 })
            })
            .collect();
        parallel::tasks(spans[d].len(), |place| {
            let interval = knots[d].span_interval(spans[d][place]);
            let along = |at: f64| {
                let place = |k: usize| {
                    let t = interval.lerp(k as f64 / CHORDS as f64);
                    if d == 0 { surface.point(t, at) } else { surface.point(at, t) }
                };
                (0..CHORDS).map(|k| (place(k + 1) - place(k)).norm()).sum::<f64>()
            };
            lines.iter().map(|&at| along(at)).fold(0.0, f64::max)
        })
    })
}

/// Parts of at most a length.
pub(super) fn count(length: f64, step: f64) -> usize {
    let parts = (length / step).ceil();
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped; NaN becomes 0")]
    let parts = parts.clamp(0.0, MOST_SAMPLES) as usize;
    parts.max(1)
}

/// Middles of equal parts of spans, with the lengths of the parts.
fn midpoints(knots: &KnotVector, spans: &[usize], counts: &[usize]) -> Vec<(f64, f64)> {
    spans
        .iter()
        .zip(counts)
        .flat_map(|(&span, &count)| {
            let interval = knots.span_interval(span);
            let length = interval.length() / count as f64;
            (0..count).map(move |k| (interval.lerp((k as f64 + 0.5) / count as f64), length))
        })
        .collect()
}

/// Samples of a subdivision surface, in each control triangle as many as its longest edge asks for.
pub(super) fn samples_of_subdivision(surface: &LoopSurface, step: f64) -> Samples {
    let positions = surface.positions();
    let edge = |triangle: &[u32; 3]| {
        let corner = |k: usize| positions[triangle[k % 3] as usize];
        (0..3).map(|k| (corner(k + 1) - corner(k)).norm()).fold(0.0, f64::max)
    };
    let edges: Vec<f64> = surface.triangles().iter().map(edge).collect();
    let parts_for = |step: f64| edges.iter().map(|&length| count(length, step)).collect::<Vec<usize>>();
    let mut parts = parts_for(step);
    let total = parts.iter().map(|&n| (n * n) as f64).sum::<f64>();
    if total > MOST_SAMPLES {
        parts = parts_for(step * (total / MOST_SAMPLES).sqrt());
    }
    let found = parallel::tasks(parts.len(), |triangle| {
        let n = parts[triangle];
        let mut out = Vec::with_capacity(n * n);
        for i in 0..n {
            for j in 0..n - i {
                // The middles of the parts of a triangle that stand upright, and of those between them.
                for third in [1.0 / 3.0, 2.0 / 3.0] {
                    if third > 0.5 && i + j + 1 == n {
                        continue;
                    }
                    let at = [(i as f64 + third) / n as f64, (j as f64 + third) / n as f64];
                    if let Some(jet) = surface.jet(triangle, at) {
                        let area = 0.5 * jet.first[0].cross(&jet.first[1]).norm() / (n * n) as f64;
                        out.push((jet.position, [2.0 * triangle as f64 + at[0], at[1]], area));
                    }
                }
            }
        }
        out
    });
    let resolution = edges.iter().zip(&parts).map(|(length, n)| length / *n as f64).fold(0.0, f64::max);
    let found = found.concat();
    Samples {
        places: found.iter().map(|f| f.0).collect(),
        parameters: found.iter().map(|f| f.1).collect(),
        areas: found.iter().map(|f| f.2).collect(),
        resolution,
    }
}
