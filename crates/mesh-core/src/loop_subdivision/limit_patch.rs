//! The limit surface over one control triangle, with irregular corners, after Stam (\[St98\]).
//!
//! A triangle is divided until its parts have at most one irregular corner. What lies around such a corner looks the same
//! after each further division, so that one square matrix per kind of corner tells all levels; each level leaves three
//! regular parts, and a place belongs to one of them after as many levels as it is halvings away from the corner. The
//! matrix is applied as often as that, which takes no eigenvectors and holds for corners on the boundary, too.

use super::box_spline::{Orders, REGULAR, basis};
use super::neighbourhood::{Combination, Corner, corners, regular, vertices};
use super::scheme::LoopScheme;
use crate::{Error, HalfEdgeMesh};
use std::collections::HashMap;

/// Least sum of `v` and `w` at an irregular corner: nearer places are evaluated there.
const NEAREST: f64 = 1.0 / (1u64 << 45) as f64;

/// Divisions after which there is at most one irregular corner.
const ISOLATED: usize = 1;

/// Weights of some points (rows) over others (columns).
#[derive(Clone, Debug)]
pub(super) struct Rows {
    width: usize,
    values: Vec<f64>,
}

impl Rows {
    fn identity(width: usize) -> Self {
        let mut values = vec![0.0; width * width];
        values.iter_mut().step_by(width + 1).for_each(|value| *value = 1.0);
        Self { width, values }
    }

    fn row(&self, index: usize) -> &[f64] {
        &self.values[index * self.width..(index + 1) * self.width]
    }

    /// Points that are combinations of the rows.
    fn combined<'a>(&self, combinations: impl IntoIterator<Item = &'a Combination>) -> Self {
        let mut values = Vec::new();
        for combination in combinations {
            let first = values.len();
            values.resize(first + self.width, 0.0);
            for &(row, weight) in combination {
                for (value, share) in values[first..].iter_mut().zip(self.row(row as usize)) {
                    *value += weight * share;
                }
            }
        }
        Self { width: self.width, values }
    }

    /// Without the zeros.
    fn sparse(&self) -> Weights {
        let mut out = Weights { width: self.width, ends: Vec::new(), entries: Vec::new() };
        for row in self.values.chunks_exact(self.width) {
            out.entries.extend((0u32..).zip(row.iter().copied()).filter(|(_, weight)| *weight != 0.0));
            out.ends.push(out.entries.len());
        }
        out
    }
}

/// [`Rows`] as they are applied: row by row the columns that count.
#[derive(Clone, Debug)]
pub(super) struct Weights {
    width: usize,
    ends: Vec<usize>,
    entries: Vec<(u32, f64)>,
}

impl Weights {
    /// The weights of the columns in a sum of the rows.
    fn applied(&self, factors: &[Orders], out: &mut Vec<Orders>) {
        out.clear();
        out.resize(self.width, [0.0; 6]);
        let mut first = 0;
        for (factor, &end) in factors.iter().zip(&self.ends) {
            for &(column, weight) in &self.entries[first..end] {
                let sum = &mut out[column as usize];
                for k in 0..6 {
                    sum[k] += factor[k] * weight;
                }
            }
            first = end;
        }
    }
}

/// A part of a control triangle.
#[derive(Clone, Debug)]
pub(super) enum Part {
    /// A box spline of the vertices themselves.
    Plain,
    /// A box spline of combinations of the vertices.
    Regular(Weights),
    /// An irregular corner: the weights of its neighbourhood, its kind, and its number in the triangle.
    Corner { weights: Weights, kind: usize, turn: usize },
    /// To be divided: the parts at the corners, and the one in the middle.
    Divided(Box<[Self; 4]>),
}

/// What one division does around an irregular corner.
#[derive(Clone, Debug)]
pub(super) struct Kind {
    /// The same neighbourhood one level finer.
    next: Weights,
    /// The regular parts at the other corners and in the middle.
    parts: [Weights; 3],
}

/// The kinds of corners that occur.
#[derive(Clone, Debug, Default)]
pub(super) struct Kinds {
    index: HashMap<[Corner; 3], usize>,
    pub(super) kinds: Vec<Kind>,
}

impl Kinds {
    fn find(&mut self, mesh: &HalfEdgeMesh, triangle: [u32; 3]) -> Result<usize, Error> {
        let key = corners(mesh, triangle);
        if let Some(&kind) = self.index.get(&key) {
            return Ok(kind);
        }
        let here = vertices(mesh, triangle);
        // The vertices of the neighbourhood stand for themselves.
        let mut places: Vec<Combination> = vec![Vec::new(); mesh.vertex_count()];
        for (&vertex, place) in here.iter().zip(0u32..) {
            places[vertex as usize] = vec![(place, 1.0)];
        }
        let fine = Division::new(mesh, triangle)?;
        let around = Rows::identity(here.len()).combined(&places).combined(&fine.masks);
        let finer: Vec<Combination> =
            vertices(&fine.mesh, fine.parts[0]).into_iter().map(|vertex| vec![(vertex, 1.0)]).collect();
        if finer.len() != here.len() || corners(&fine.mesh, fine.parts[0]) != key {
            return Err(Error::Subdivision { what: "a corner changes under division" });
        }
        let part = |k: usize| {
            let points = regular(&fine.mesh, fine.parts[k]);
            points
                .map(|points| around.combined(&points).sparse())
                .ok_or(Error::Subdivision { what: "a part is not regular" })
        };
        let kind = Kind { next: around.combined(&finer).sparse(), parts: [part(1)?, part(2)?, part(3)?] };
        self.kinds.push(kind);
        self.index.insert(key, self.kinds.len() - 1);
        Ok(self.kinds.len() - 1)
    }
}

/// A triangle and its surroundings, divided once.
struct Division {
    mesh: HalfEdgeMesh,
    /// The fine vertices as combinations of the coarse ones.
    masks: Vec<Combination>,
    /// The parts at the three corners, and in the middle.
    parts: [[u32; 3]; 4],
}

impl Division {
    fn new(mesh: &HalfEdgeMesh, triangle: [u32; 3]) -> Result<Self, Error> {
        let here = vertices(mesh, triangle);
        let local: HashMap<u32, u32> = here.iter().copied().zip(0u32..).collect();
        let renamed = |corners: [u32; 3]| corners.map(|vertex| local.get(&vertex).copied().unwrap_or(0));
        let mut triangles = vec![renamed(triangle)];
        let own = {
            let mut sorted = triangle;
            sorted.sort_unstable();
            sorted
        };
        let mut seen = Vec::new();
        for corner in triangle {
            for spoke in mesh.spokes(corner) {
                let index = spoke.triangle();
                let corners = mesh.triangles()[index];
                let mut sorted = corners;
                sorted.sort_unstable();
                if sorted != own && !seen.contains(&index) {
                    seen.push(index);
                    triangles.push(renamed(corners));
                }
            }
        }
        let (masks, fine) = LoopScheme::of_triangles(here.len(), &triangles).refine()?;
        let back = |mask: Combination| mask.into_iter().map(|(v, w)| (here[v as usize], w)).collect();
        let mesh = HalfEdgeMesh::of(masks.len(), &fine);
        let parts = [fine[0], fine[1], fine[2], fine[3]];
        Ok(Self { mesh, masks: masks.into_iter().map(back).collect(), parts })
    }
}

/// A control triangle with the vertices that act on it.
#[derive(Clone, Debug)]
pub(super) struct LimitPatch {
    pub(super) vertices: Vec<u32>,
    part: Part,
}

impl LimitPatch {
    pub(super) fn new(mesh: &HalfEdgeMesh, triangle: [u32; 3], kinds: &mut Kinds) -> Result<Self, Error> {
        if let Some(points) = regular(mesh, triangle)
            && points.iter().all(|point| point.len() == 1)
        {
            return Ok(Self { vertices: points.iter().map(|point| point[0].0).collect(), part: Part::Plain });
        }
        let vertices = vertices(mesh, triangle);
        let mut places: Vec<Combination> = vec![Vec::new(); mesh.vertex_count()];
        for (&vertex, place) in vertices.iter().zip(0u32..) {
            places[vertex as usize] = vec![(place, 1.0)];
        }
        let rows = Rows::identity(vertices.len()).combined(&places);
        let part = build(mesh, triangle, &rows, kinds, 0)?;
        Ok(Self { vertices, part })
    }

    /// The weights of the vertices at `(v, w)`.
    pub(super) fn weights(&self, kinds: &[Kind], at: [f64; 2], out: &mut Vec<Orders>) {
        let mut place = Place { at, chain: [[1.0, 0.0], [0.0, 1.0]] };
        let mut part = &self.part;
        loop {
            match part {
                Part::Plain => {
                    out.clear();
                    out.extend_from_slice(&place.basis());
                    return;
                }
                Part::Regular(weights) => return weights.applied(&place.basis(), out),
                Part::Divided(parts) => part = &parts[place.descend()],
                Part::Corner { weights, kind, turn } => {
                    place.rotate(*turn);
                    place.keep_off();
                    let kind = &kinds[*kind];
                    let mut levels = 0;
                    let child = loop {
                        match place.descend() {
                            0 => levels += 1,
                            child => break child,
                        }
                    };
                    let mut factors = Vec::with_capacity(weights.width);
                    kind.parts[child - 1].applied(&place.basis(), &mut factors);
                    for _ in 0..levels {
                        kind.next.applied(&factors, out);
                        std::mem::swap(&mut factors, out);
                    }
                    return weights.applied(&factors, out);
                }
            }
        }
    }
}

/// The part of a control triangle that a triangle of a finer mesh is; `rows` are the weights of the vertices of that mesh.
fn build(
    mesh: &HalfEdgeMesh,
    triangle: [u32; 3],
    rows: &Rows,
    kinds: &mut Kinds,
    depth: usize,
) -> Result<Part, Error> {
    if let Some(points) = regular(mesh, triangle) {
        return Ok(Part::Regular(rows.combined(&points).sparse()));
    }
    let irregular = corners(mesh, triangle).map(|corner| !corner.is_regular());
    if depth >= ISOLATED
        && let Some(turn) = irregular.iter().position(|&corner| corner)
    {
        let turned = [0, 1, 2].map(|k| triangle[(k + turn) % 3]);
        let around: Vec<Combination> =
            vertices(mesh, turned).into_iter().map(|vertex| vec![(vertex, 1.0)]).collect();
        let weights = rows.combined(&around).sparse();
        return Ok(Part::Corner { weights, kind: kinds.find(mesh, turned)?, turn });
    }
    let fine = Division::new(mesh, triangle)?;
    let rows = rows.combined(&fine.masks);
    let mut part = |k: usize| build(&fine.mesh, fine.parts[k], &rows, kinds, depth + 1);
    Ok(Part::Divided(Box::new([part(0)?, part(1)?, part(2)?, part(3)?])))
}

/// A place in a part, and the derivatives of its coordinates by those of the control triangle.
struct Place {
    at: [f64; 2],
    /// `[[∂v'/∂v, ∂v'/∂w], [∂w'/∂v, ∂w'/∂w]]`.
    chain: [[f64; 2]; 2],
}

impl Place {
    fn follow(&mut self, at: [f64; 2], step: [[f64; 2]; 2]) {
        let c = self.chain;
        self.at = at;
        self.chain = step.map(|[a, b]| [a * c[0][0] + b * c[1][0], a * c[0][1] + b * c[1][1]]);
    }

    /// Goes to the part in which the place lies: 0 to 2 at the corners, 3 in the middle.
    fn descend(&mut self) -> usize {
        const TWICE: [[f64; 2]; 2] = [[2.0, 0.0], [0.0, 2.0]];
        let [v, w] = self.at;
        if v + w <= 0.5 {
            self.follow([2.0 * v, 2.0 * w], TWICE);
            0
        } else if v >= 0.5 {
            self.follow([2.0 * v - 1.0, 2.0 * w], TWICE);
            1
        } else if w >= 0.5 {
            self.follow([2.0 * v, 2.0 * w - 1.0], TWICE);
            2
        } else {
            self.follow([2.0 * (v + w) - 1.0, 1.0 - 2.0 * v], [[2.0, 2.0], [-2.0, 0.0]]);
            3
        }
    }

    /// Makes corner `turn` the first one.
    fn rotate(&mut self, turn: usize) {
        let [v, w] = self.at;
        let u = 1.0 - v - w;
        match turn {
            1 => self.follow([w, u], [[0.0, 1.0], [-1.0, -1.0]]),
            2 => self.follow([u, v], [[-1.0, -1.0], [1.0, 0.0]]),
            _ => {}
        }
    }

    /// Moves the place away from the first corner, where the surface has no derivatives by these coordinates.
    fn keep_off(&mut self) {
        let [v, w] = self.at.map(|x| x.max(0.0));
        let sum = v + w;
        // False for NaN too.
        self.at = if sum >= NEAREST {
            [v, w]
        } else if sum > 0.0 {
            [v * (NEAREST / sum), w * (NEAREST / sum)]
        } else {
            [0.5 * NEAREST; 2]
        };
    }

    /// The box spline with derivatives by the coordinates of the control triangle.
    fn basis(&self) -> [Orders; REGULAR] {
        let [[a, b], [c, d]] = self.chain;
        basis(self.at).map(|[value, v, w, vv, vw, ww]| {
            [
                value,
                v * a + w * c,
                v * b + w * d,
                a * a * vv + 2.0 * a * c * vw + c * c * ww,
                a * b * vv + (a * d + b * c) * vw + c * d * ww,
                b * b * vv + 2.0 * b * d * vw + d * d * ww,
            ]
        })
    }
}
