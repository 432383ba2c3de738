//! Bézier patches of one or several surfaces, prepared for the search.

use super::bernstein::basis_jet;
use super::cells::Cells;
use super::lanes::{Lanes, Row, WIDTH};
use super::pole::Pole;
use super::products::{Products, elevate_row, product, splitting_rows};
use super::scratch::Scratch;
use super::tree::{Bounds, BoxTree};
use crate::projector::pool::Pool;
use nalgebra::Vector3;
use nurbs_core::{BezierPatch, BsplineSurface, Interval, MAX_DEGREE, SurfaceJet};

/// A point of the homogeneous control net: `w (p − centre)` and `w`.
pub(crate) type Homogeneous = [f64; 4];

/// One patch: where it lies, and where its coefficients begin in the arenas.
#[derive(Clone, Debug)]
pub(crate) struct Patch {
    /// Index of its surface.
    pub(crate) shape: usize,
    /// Row and column in the grid of patches of that surface.
    pub(crate) cell: [usize; 2],
    pub(crate) degrees: [usize; 2],
    pub(crate) rational: bool,
    /// Origin of the coordinates in which the net is stored: the pole, if there is one, so that next to it all
    /// coefficients are small and so are their rounding errors.
    pub(crate) centre: Vector3<f64>,
    pub(crate) intervals: [Interval; 2],
    /// Bounds of the squared weight function.
    pub(crate) min_weight_sq: f64,
    pub(crate) max_weight_sq: f64,
    /// Largest distance of a control point from the centre.
    pub(crate) radius: f64,
    /// The edge that is collapsed into the centre.
    pub(crate) pole: Option<Pole>,
    net: usize,
    form: usize,
}

impl Patch {
    /// Number of rows of the squared distance form, `2 degree_u + 1`.
    #[inline(always)]
    pub(crate) fn rows(&self) -> usize {
        2 * self.degrees[0] + 1
    }

    /// Parameters of the whole surface at the local `(s, t)` in `[0, 1]²`.
    pub(crate) fn parameter(&self, s: f64, t: f64) -> [f64; 2] {
        [self.intervals[0].lerp(s), self.intervals[1].lerp(t)]
    }
}

/// All patches of a model; rows of squared distance forms have `8 K` coefficients.
///
/// For the local query `y = x − centre` the squared distance, times the squared weight function, is the
/// polynomial `A − 2 ⟨y, B⟩ + |y|² W` with `A = |wS|²`, `B = w·wS`, `W = w²`: all three are stored in Bernstein
/// form of degree `2p < 8K` in `u` and `8K − 1 ≥ 2q` in `v`.
#[derive(Clone, Debug)]
pub(crate) struct PatchSet<const K: usize> {
    pub(crate) patches: Vec<Patch>,
    pub(crate) cells: Vec<Cells>,
    pub(crate) tree: BoxTree<3>,
    /// Largest side of the bounding box of everything.
    pub(crate) size: f64,
    /// `halves[0]`, `halves[1]`: row `j` is what coefficient `j` contributes to the lower and upper half.
    pub(crate) halves: [Vec<Row<K>>; 2],
    pub(crate) products: Products<K>,
    nets: Vec<Homogeneous>,
    forms: Vec<Row<K>>,
    pub(crate) scratch: Pool<Scratch<K>>,
}

impl<const K: usize> PatchSet<K> {
    /// Degree of the forms in `v`.
    pub(crate) const DEGREE: usize = WIDTH * K - 1;

    pub(crate) fn new<'a>(surfaces: impl Iterator<Item = &'a BsplineSurface>) -> Self {
        let mut set = Self {
            patches: Vec::new(),
            cells: Vec::new(),
            tree: BoxTree::new(&[]),
            size: 0.0,
            halves: [Vec::new(), Vec::new()],
            products: Products::default(),
            nets: Vec::new(),
            forms: Vec::new(),
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
            let cells = Cells::new(surface, first, columns, &set);
            set.cells.push(cells);
        }
        set.size = extent(&boxes);
        set.tree = BoxTree::new(&boxes);
        set
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
        let radius = patch.control_points.iter().map(|p| (p - centre).norm()).fold(0.0, f64::max);
        for degree in patch.degrees {
            self.products.add(degree);
        }
        let (min, max) = net.iter().fold((f64::INFINITY, 0.0f64), |(a, b), p| (a.min(p[3]), b.max(p[3])));
        self.patches.push(Patch {
            min_weight_sq: min * min,
            max_weight_sq: max * max,
            radius,
            pole,
            shape,
            cell,
            degrees: patch.degrees,
            rational: patch.weights.is_some(),
            centre,
            intervals: patch.intervals,
            net: self.nets.len(),
            form: self.forms.len(),
        });
        self.push_form(&net, patch.degrees, patch.weights.is_some());
        self.nets.extend(net);
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

    /// The jet at the local `(s, t)` with derivatives by local parameters; points relative to the centre.
    #[inline(always)]
    pub(crate) fn jet(&self, patch: &Patch, s: f64, t: f64) -> SurfaceJet {
        let [p, q] = patch.degrees;
        let net = self.net(patch);
        let a = match (p, q) {
            (3, 3) => fixed_jet::<4, 4>(net, s, t),
            (2, 2) => fixed_jet::<3, 3>(net, s, t),
            (1, 1) => fixed_jet::<2, 2>(net, s, t),
            _ => general_jet(net, p, q, s, t),
        };
        let v = |k: usize| Vector3::new(a[k][0], a[k][1], a[k][2]);
        if !patch.rational {
            return SurfaceJet { point: v(0), du: v(1), dv: v(2), duu: v(3), duv: v(4), dvv: v(5) };
        }
        let w = |k: usize| a[k][3];
        let inverse = 1.0 / w(0);
        let point = v(0) * inverse;
        let du = (v(1) - point * w(1)) * inverse;
        let dv = (v(2) - point * w(2)) * inverse;
        SurfaceJet {
            point,
            du,
            dv,
            duu: (v(3) - du * (2.0 * w(1)) - point * w(3)) * inverse,
            duv: (v(4) - du * w(2) - dv * w(1) - point * w(4)) * inverse,
            dvv: (v(5) - dv * (2.0 * w(2)) - point * w(5)) * inverse,
        }
    }

    /// The homogeneous control net.
    #[inline(always)]
    pub(crate) fn net(&self, patch: &Patch) -> &[Homogeneous] {
        &self.nets[patch.net..patch.net + (patch.degrees[0] + 1) * (patch.degrees[1] + 1)]
    }

    /// The point alone, relative to the centre.
    #[inline(always)]
    pub(crate) fn point(&self, patch: &Patch, s: f64, t: f64) -> Vector3<f64> {
        let [p, q] = patch.degrees;
        let net = self.net(patch);
        let mut bu = [[0.0; 3]; MAX_DEGREE + 1];
        let mut bv = [[0.0; 3]; MAX_DEGREE + 1];
        basis_jet(p, s, &mut bu[..=p]);
        basis_jet(q, t, &mut bv[..=q]);
        let mut a = [0.0; 4];
        for i in 0..=p {
            let mut r = [0.0; 4];
            for j in 0..=q {
                axpy(&mut r, &net[i * (q + 1) + j], bv[j][0]);
            }
            axpy(&mut a, &r, bu[i][0]);
        }
        let point = Vector3::new(a[0], a[1], a[2]);
        if patch.rational { point / a[3] } else { point }
    }

    /// Bytes of the prepared data.
    pub(crate) fn memory(&self) -> usize {
        size_of_val(&self.nets[..])
            + size_of_val(&self.forms[..])
            + size_of_val(&self.patches[..])
            + self.tree.memory()
    }
}

#[inline(always)]
fn axpy(to: &mut [f64; 4], from: &[f64; 4], factor: f64) {
    for c in 0..4 {
        to[c] += from[c] * factor;
    }
}

/// Value, u, v, uu, uv, vv of a net of `M x N` points.
#[inline(always)]
fn fixed_jet<const M: usize, const N: usize>(net: &[Homogeneous], s: f64, t: f64) -> [[f64; 4]; 6] {
    let mut bu = [[0.0; 3]; M];
    let mut bv = [[0.0; 3]; N];
    basis_jet(M - 1, s, &mut bu);
    basis_jet(N - 1, t, &mut bv);
    let mut a = [[0.0; 4]; 6];
    for i in 0..M {
        let mut r = [[0.0; 4]; 3];
        for j in 0..N {
            for d in 0..3 {
                axpy(&mut r[d], &net[i * N + j], bv[j][d]);
            }
        }
        accumulate(&mut a, &r, &bu[i]);
    }
    a
}

#[inline(always)]
fn accumulate(a: &mut [[f64; 4]; 6], r: &[[f64; 4]; 3], b: &[f64; 3]) {
    axpy(&mut a[0], &r[0], b[0]);
    axpy(&mut a[1], &r[0], b[1]);
    axpy(&mut a[2], &r[1], b[0]);
    axpy(&mut a[3], &r[0], b[2]);
    axpy(&mut a[4], &r[1], b[1]);
    axpy(&mut a[5], &r[2], b[0]);
}

fn general_jet(net: &[Homogeneous], p: usize, q: usize, s: f64, t: f64) -> [[f64; 4]; 6] {
    let mut bu = [[0.0; 3]; MAX_DEGREE + 1];
    let mut bv = [[0.0; 3]; MAX_DEGREE + 1];
    basis_jet(p, s, &mut bu[..=p]);
    basis_jet(q, t, &mut bv[..=q]);
    let mut a = [[0.0; 4]; 6];
    for i in 0..=p {
        let mut r = [[0.0; 4]; 3];
        for j in 0..=q {
            for d in 0..3 {
                axpy(&mut r[d], &net[i * (q + 1) + j], bv[j][d]);
            }
        }
        accumulate(&mut a, &r, &bu[i]);
    }
    a
}

pub(crate) fn bounds(points: &[Vector3<f64>]) -> Bounds<3> {
    let mut low = Vector3::repeat(f64::INFINITY);
    let mut high = -low;
    for p in points {
        low = low.inf(p);
        high = high.sup(p);
    }
    [low.into(), high.into()]
}

/// Largest side of the box around all boxes.
pub(crate) fn extent(boxes: &[Bounds<3>]) -> f64 {
    (0..3)
        .map(|d| {
            let low = boxes.iter().map(|b| b[0][d]).fold(f64::INFINITY, f64::min);
            let high = boxes.iter().map(|b| b[1][d]).fold(f64::NEG_INFINITY, f64::max);
            high - low
        })
        .fold(0.0, f64::max)
}
