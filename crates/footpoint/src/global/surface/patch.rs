//! Bézier patches of one or several surfaces, prepared for the search.

use crate::global::arithmetic::homogeneous::Homogeneous;
use crate::global::arithmetic::lanes::{Lanes, Row, WIDTH};
use crate::global::arithmetic::products::{Products, elevate_row, product, splitting_rows};
use crate::global::proof::hulls::tiles::Tiles;
use crate::global::surface::cells::Cells;
use crate::global::surface::geometry::{Geometry, Patch};
use crate::global::surface::pole_edge::Pole;
use crate::global::surface::sampling::Sampling;
use crate::global::surface::scratch::Scratch;
use crate::global::tree::{Bounds, BoxTree, bounds, extent};
use crate::projector::pool::Pool;
use nalgebra::Vector3;
use nurbs_core::{BezierPatch, BsplineSurface};
use std::ops::Deref;
use std::sync::OnceLock;

/// All patches of a model, rows of squared distance forms with `8 K` coefficients, and a tree to find the nearest.
///
/// For the local query `y = x − centre` the squared distance, times the squared weight function, is the
/// polynomial `A − 2 ⟨y, B⟩ + |y|² W` with `A = |wS|²`, `B = w·wS`, `W = w²`: all three are stored in Bernstein
/// form of degree `2p < 8K` in `u` and `8K − 1 ≥ 2q` in `v`.
#[derive(Clone, Debug)]
pub(crate) struct PatchSet<const K: usize> {
    geometry: Geometry,
    pub(crate) tree: BoxTree<3>,
    /// `halves[0]`, `halves[1]`: row `j` is what coefficient `j` contributes to the lower and upper half.
    pub(crate) halves: [Vec<Row<K>>; 2],
    pub(crate) products: Products<K>,
    pub(in crate::global) sampling: Sampling<K>,
    forms: Vec<Row<K>>,
    /// Made when it is first needed, see [`PatchSet::tiles`].
    tiles: OnceLock<Tiles>,
    pub(crate) scratch: Pool<Scratch<K>>,
}

/// A patch set is its geometry, and more.
impl<const K: usize> Deref for PatchSet<K> {
    type Target = Geometry;

    #[inline(always)]
    fn deref(&self) -> &Geometry {
        &self.geometry
    }
}

impl<const K: usize> PatchSet<K> {
    /// Degree of the forms in `v`.
    pub(crate) const DEGREE: usize = WIDTH * K - 1;

    pub(crate) fn new<'a>(surfaces: impl Iterator<Item = &'a BsplineSurface>) -> Self {
        let mut set = Self {
            geometry: Geometry::default(),
            tree: BoxTree::new(&[]),
            halves: [Vec::new(), Vec::new()],
            products: Products::default(),
            sampling: Sampling::default(),
            forms: Vec::new(),
            tiles: OnceLock::new(),
            scratch: Pool::default(),
        };
        splitting_rows(0.5, &mut set.halves);
        let mut boxes: Vec<Bounds<3>> = Vec::new();
        for (shape, surface) in surfaces.enumerate() {
            let first = set.patches.len();
            let columns = surface.knots_v().spans().count();
            for (index, patch) in surface.bezier_patches().iter().enumerate() {
                boxes.push(bounds(&patch.control_points));
                set.push(shape, [index / columns, index % columns], patch);
            }
            let cells = Cells::new(surface, first, columns, &set.geometry);
            set.geometry.cells.push(cells);
        }
        set.geometry.size = extent(&boxes);
        set.tree = BoxTree::new(&boxes);
        set
    }

    /// What the proofs on patches of high degree or with unequal weights use. It takes much of the time of the preparation, and many
    /// patches of a large model are never asked for.
    pub(crate) fn tiles(&self) -> &Tiles {
        self.tiles.get_or_init(|| Tiles::new(&self.geometry))
    }

    fn push(&mut self, shape: usize, cell: [usize; 2], patch: &BezierPatch) {
        let [low, high] = bounds(&patch.control_points);
        let pole = Pole::find(patch);
        let middle = 0.5 * (Vector3::from(low) + Vector3::from(high));
        let centre = pole.map_or(middle, |pole| pole.point(patch));
        let weight = |i: usize| patch.weights.as_ref().map_or(1.0, |w| w[i]);
        let mut net: Vec<Homogeneous> = (patch.control_points.iter().enumerate())
            .map(|(i, p)| {
                let (q, w) = ((p - centre) * weight(i), weight(i));
                [q.x, q.y, q.z, w]
            })
            .collect();
        if let Some(pole) = pole {
            // Equal up to rounding errors, and now exactly.
            pole.edge(patch.degrees).for_each(|i| net[i][..3].fill(0.0));
        }
        for degree in patch.degrees {
            self.products.add(degree);
        }
        let form = self.forms.len();
        self.sampling.prepare(2 * patch.degrees[0]);
        self.push_form(&net, patch.degrees, patch.weights.is_some());
        self.geometry.push(shape, cell, patch, centre, pole, net, form);
    }

    /// Appends the rows of `A`, `B` (three coordinates) and, if rational, `W`.
    fn push_form(&mut self, net: &[Homogeneous], degrees: [usize; 2], rational: bool) {
        let product = product(net, degrees, |a, b| {
            [a[0] * b[0] + a[1] * b[1] + a[2] * b[2], a[3] * b[0], a[3] * b[1], a[3] * b[2], a[3] * b[3]]
        });
        for part in 0..if rational { 5 } else { 4 } {
            for row in product.chunks(2 * degrees[1] + 1) {
                self.forms.push(elevate_row(row.iter().map(|c| c[part])));
            }
        }
    }

    /// Bernstein coefficients of `w² (|S − x|² − limit_sq)` on the patch; `y` is `x − centre`.
    #[inline(always)]
    pub(crate) fn form(&self, patch: &Patch, y: &Vector3<f64>, limit_sq: f64, out: &mut [Row<K>]) {
        let rows = patch.rows();
        let forms = &self.forms[patch.form..patch.form + rows * if patch.rational { 5 } else { 4 }];
        let constant = y.norm_squared() - limit_sq;
        let (a, rest) = forms.split_at(rows);
        let (bx, rest) = rest.split_at(rows);
        let (by, rest) = rest.split_at(rows);
        let (bz, w) = rest.split_at(rows);
        let factors = [-2.0 * y.x, -2.0 * y.y, -2.0 * y.z];
        for i in 0..rows {
            for k in 0..K {
                let mut value =
                    a[i][k] + (bx[i][k] * factors[0] + by[i][k] * factors[1] + bz[i][k] * factors[2]);
                if patch.rational {
                    value = value + w[i][k] * constant;
                } else {
                    value = value + Lanes::splat(constant);
                }
                out[i][k] = value;
            }
        }
    }

    /// Bernstein coefficients of the squared weight function, unless it is constant 1.
    pub(crate) fn weight_form(&self, patch: &Patch) -> Option<&[Row<K>]> {
        let rows = patch.rows();
        patch.rational.then(|| &self.forms[patch.form + 4 * rows..patch.form + 5 * rows])
    }

    /// Bytes of the prepared data.
    pub(crate) fn memory(&self) -> usize {
        self.geometry.memory()
            + size_of_val(&self.forms[..])
            + self.tree.memory()
            + self.tiles.get().map_or(0, Tiles::memory)
    }
}
