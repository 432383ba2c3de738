//! The shape of the patches of a model: what local iterations need, whatever the degree.

use crate::global::arithmetic::homogeneous::Homogeneous;
use crate::global::arithmetic::power;
use crate::global::surface::cells::Cells;
use crate::global::surface::pole_edge::Pole;
use nalgebra::Vector3;
use nurbs_core::{BezierPatch, Interval};

/// Largest ratio of the weights of a patch that is evaluated in powers.
const BALANCED: f64 = 256.0;

/// One patch: where it lies, and where its coefficients begin in the arenas.
#[derive(Clone, Debug)]
pub(crate) struct Patch {
    // Patches are many: small numbers are kept small.
    shape: u32,
    cell: [u32; 2],
    degrees: [u8; 2],
    order: u8,
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
    /// Halves, of which there are few.
    origin: [f32; 2],
    net: usize,
    /// Where the rows of its squared distance form begin.
    pub(in crate::global) form: usize,
    powers: usize,
}

impl Patch {
    /// Index of its surface.
    #[inline(always)]
    pub(crate) fn shape(&self) -> usize {
        self.shape as usize
    }

    /// Row and column in the grid of patches of that surface.
    #[inline(always)]
    pub(crate) fn cell(&self) -> [usize; 2] {
        [self.cell[0] as usize, self.cell[1] as usize]
    }

    #[inline(always)]
    pub(crate) fn degrees(&self) -> [usize; 2] {
        [usize::from(self.degrees[0]), usize::from(self.degrees[1])]
    }

    /// Largest degree + 1 of a patch that is also kept in powers, or 0.
    #[inline(always)]
    pub(crate) fn order(&self) -> usize {
        usize::from(self.order)
    }

    /// Local parameters that are zero in the powers.
    #[inline(always)]
    pub(in crate::global) fn origin(&self) -> [f64; 2] {
        [f64::from(self.origin[0]), f64::from(self.origin[1])]
    }

    /// Number of rows of the squared distance form, `2 degree_u + 1`.
    #[inline(always)]
    pub(crate) fn rows(&self) -> usize {
        2 * self.degrees()[0] + 1
    }

    /// Parameters of the whole surface at the local `(s, t)` in `[0, 1]²`.
    pub(crate) fn parameter(&self, s: f64, t: f64) -> [f64; 2] {
        [self.intervals[0].lerp(s), self.intervals[1].lerp(t)]
    }
}

/// All patches of a model, and who borders on whom.
#[derive(Clone, Debug, Default)]
pub(crate) struct Geometry {
    pub(crate) patches: Vec<Patch>,
    pub(crate) cells: Vec<Cells>,
    /// Largest side of the bounding box of everything.
    pub(crate) size: f64,
    nets: Vec<Homogeneous>,
    /// Coefficients in powers of patches of low degree, and one number more.
    powers: Vec<f64>,
}

impl Geometry {
    /// Appends a patch, whose net is given relative to `centre`.
    #[expect(clippy::too_many_arguments, reason = "a patch, and where its coefficients begin")]
    pub(in crate::global) fn push(
        &mut self,
        shape: usize,
        cell: [usize; 2],
        patch: &BezierPatch,
        centre: Vector3<f64>,
        pole: Option<Pole>,
        net: Vec<Homogeneous>,
        form: usize,
    ) {
        let rational = patch.weights.is_some();
        // The number that follows the last coefficient is read, but not used.
        self.powers.pop();
        let powers = self.powers.len();
        let mut origin = [0.5f32; 2];
        if let Some(pole) = pole {
            origin[pole.direction()] = if pole.at_end { 1.0 } else { 0.0 };
        }
        let (min, max) = net.iter().fold((f64::INFINITY, 0.0f64), |(a, b), p| (a.min(p[3]), b.max(p[3])));
        // In powers the largest weights cancel where small ones count; Bernstein sums of positive weights do not.
        let order = if max <= BALANCED * min {
            power::push_powers(&net, patch.degrees, origin.map(f64::from), rational, &mut self.powers)
        } else {
            0
        };
        self.powers.push(0.0);
        let radius = patch.control_points.iter().map(|p| (p - centre).norm()).fold(0.0, f64::max);
        self.patches.push(Patch {
            // So many patches that these do not fit would not fit into the memory.
            shape: u32::try_from(shape).unwrap_or(u32::MAX),
            cell: cell.map(|index| u32::try_from(index).unwrap_or(u32::MAX)),
            degrees: patch.degrees.map(|degree| u8::try_from(degree).unwrap_or(u8::MAX)),
            order: u8::try_from(order).unwrap_or(u8::MAX),
            rational,
            centre,
            intervals: patch.intervals,
            min_weight_sq: min * min,
            max_weight_sq: max * max,
            radius,
            pole,
            origin,
            net: self.nets.len(),
            form,
            powers,
        });
        self.nets.extend(net);
    }

    /// The homogeneous control net.
    #[inline(always)]
    pub(in crate::global) fn net(&self, patch: &Patch) -> &[Homogeneous] {
        let [p, q] = patch.degrees();
        &self.nets[patch.net..patch.net + (p + 1) * (q + 1)]
    }

    /// The coefficients in powers of a patch of order `N`, with `C` numbers each, and one number more.
    #[inline(always)]
    pub(in crate::global) fn powers<const N: usize, const C: usize>(&self, patch: &Patch) -> &[f64] {
        &self.powers[patch.powers..][..N * N * C + 1]
    }

    /// Bytes of the prepared data.
    pub(in crate::global) fn memory(&self) -> usize {
        size_of_val(&self.nets[..]) + size_of_val(&self.powers[..]) + size_of_val(&self.patches[..])
    }
}
