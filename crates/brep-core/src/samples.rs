//! Points spread over the faces of a model, and triangles that show it.

use crate::boundary::Inside;
use crate::model::Model;
use crate::part::Part;
use nalgebra::{Vector2, Vector3};

/// Cells of the parameter box of a face at most.
const MAX_CELLS: f64 = 40_000.0;

/// A point of a model with its unit normal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// The point.
    pub point: Vector3<f64>,
    /// The unit normal of its face; zero where there is none.
    pub normal: Vector3<f64>,
}

/// Triangles that show a model.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Picture {
    /// Vertices.
    pub vertices: Vec<Sample>,
    /// Corners of the triangles.
    pub triangles: Vec<[u32; 3]>,
    /// Lines along the edges.
    pub lines: Vec<Vec<Vector3<f64>>>,
}

/// A grid over the parameter box of a face.
struct Grid {
    low: Vector2<f64>,
    step: Vector2<f64>,
    counts: [usize; 2],
}

impl Part {
    /// A grid of about `count` cells that are as wide as they are high.
    fn grid(&self, face: usize, count: f64) -> Grid {
        let f = &self.faces[face];
        let [low, high] = f.parameter_box();
        let jet = f.surface.jet(&((low + high) * 0.5));
        let size = Vector2::new(jet.du.norm(), jet.dv.norm()).component_mul(&(high - low));
        let ratio = (size.x / size.y).clamp(1e-3, 1e3);
        let ratio = if ratio.is_finite() { ratio } else { 1.0 };
        let count = count.clamp(1.0, MAX_CELLS);
        #[expect(clippy::cast_possible_truncation, reason = "clamped")]
        let counts =
            [(count * ratio).sqrt(), (count / ratio).sqrt()].map(|n| n.ceil().clamp(1.0, MAX_CELLS) as usize);
        let step = Vector2::new((high.x - low.x) / counts[0] as f64, (high.y - low.y) / counts[1] as f64);
        Grid { low, step, counts }
    }

    fn is_inside(&self, face: usize, uv: &Vector2<f64>) -> bool {
        self.faces[face].inside(&self.edges, uv) == Inside::In
    }
}

impl Grid {
    fn place(&self, i: f64, j: f64) -> Vector2<f64> {
        self.low + Vector2::new(i * self.step.x, j * self.step.y)
    }
}

impl Model {
    /// About `count` points, spread over the faces by area.
    #[must_use]
    pub fn samples(&self, count: usize) -> Vec<Sample> {
        let areas: Vec<Vec<f64>> =
            self.parts().iter().map(|p| (0..p.faces.len()).map(|f| p.area(f).max(0.0)).collect()).collect();
        let scaled = |i: &crate::Instance| i.placement.scale * i.placement.scale;
        let total: f64 = self.instances().iter().map(|i| areas[i.part].iter().sum::<f64>() * scaled(i)).sum();
        let mut out = Vec::new();
        for instance in self.instances() {
            let part = &self.parts()[instance.part];
            for face in 0..part.faces.len() {
                let wanted = count as f64 * areas[instance.part][face] * scaled(instance) / total;
                // A model without area, or with one that is not finite, has no samples.
                if wanted.is_nan() || wanted <= 0.0 {
                    continue;
                }
                // The face covers a part of its parameter box only: found out with a coarse grid.
                let coarse = part.grid(face, 256.0);
                let hits = coarse.centres().filter(|uv| part.is_inside(face, uv)).count();
                let share = (hits as f64 / coarse.centres().count() as f64).max(1e-3);
                for uv in part.grid(face, wanted / share).centres() {
                    if part.is_inside(face, &uv) {
                        let f = &part.faces[face];
                        out.push(Sample {
                            point: instance.placement.point(&f.surface.point(&uv)),
                            normal: instance.placement.direction(&f.normal([uv.x, uv.y])),
                        });
                    }
                }
            }
        }
        out
    }
}

impl Grid {
    fn centres(&self) -> impl Iterator<Item = Vector2<f64>> + '_ {
        (0..self.counts[0])
            .flat_map(move |i| (0..self.counts[1]).map(move |j| self.place(i as f64 + 0.5, j as f64 + 0.5)))
    }
}
