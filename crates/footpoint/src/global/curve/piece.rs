//! Bézier pieces of one or several curves, prepared for the search.

use crate::global::arithmetic::bernstein::{basis_jet, binomial, elevation_matrix, unit};
use crate::global::arithmetic::lanes::{Lanes, Row, WIDTH, zero_row};
use crate::global::curve::scratch::CurveScratch;
use crate::global::surface::sampling::Sampling;
use crate::global::tree::{Bounds, BoxTree};
use crate::projector::pool::Pool;
use nalgebra::SVector;
use nurbs_core::{BezierCurve, BsplineCurve, CurveJet, Interval, MAX_DEGREE};

/// Relative agreement of points and first derivatives that lets an iteration cross a border.
const SMOOTH: f64 = 1e-6;

/// One piece: where it lies, and where its coefficients begin in the arenas.
#[derive(Clone, Debug)]
pub(crate) struct Piece<const D: usize> {
    /// Index of its curve.
    pub(crate) shape: usize,
    pub(crate) degree: usize,
    pub(crate) rational: bool,
    /// Origin of the coordinates in which the points are stored.
    pub(crate) centre: SVector<f64, D>,
    pub(crate) interval: Interval,
    /// The pieces across the lower and upper end, where the curve goes on smoothly.
    pub(crate) neighbours: [Option<usize>; 2],
    /// Whether the lower and upper end are ends of the curve, and whether the curve is closed there.
    pub(crate) ends: [bool; 2],
    pub(crate) closed: bool,
    pub(crate) min_weight_sq: f64,
    pub(crate) max_weight_sq: f64,
    first: usize,
    form: usize,
}

/// All pieces of a model, as [`PatchSet`](crate::global::surface::patch::PatchSet) for surfaces.
#[derive(Clone, Debug)]
pub(crate) struct PieceSet<const D: usize, const K: usize> {
    pub(crate) pieces: Vec<Piece<D>>,
    pub(crate) tree: BoxTree<D>,
    /// Largest side of the bounding box of everything.
    pub(crate) size: f64,
    /// First piece of each curve, and breakpoints of its spans.
    curves: Vec<(usize, Vec<f64>)>,
    points: Vec<(SVector<f64, D>, f64)>,
    pub(in crate::global) sampling: Sampling<K>,
    forms: Vec<Row<K>>,
    pub(crate) scratch: Pool<CurveScratch<K>>,
}

impl<const D: usize, const K: usize> PieceSet<D, K> {
    /// Degree of the forms.
    pub(crate) const DEGREE: usize = WIDTH * K - 1;

    pub(crate) fn new<'a>(curves: impl Iterator<Item = &'a BsplineCurve<D>>) -> Self {
        let mut set = Self {
            pieces: Vec::new(),
            tree: BoxTree::new(&[]),
            size: 0.0,
            curves: Vec::new(),
            points: Vec::new(),
            sampling: Sampling::default(),
            forms: Vec::new(),
            scratch: Pool::default(),
        };
        let mut boxes = Vec::new();
        for (shape, curve) in curves.enumerate() {
            let first = set.pieces.len();
            let pieces = curve.bezier_curves();
            let mut breaks: Vec<f64> = pieces.iter().map(|p| p.interval.start()).collect();
            breaks.push(curve.knots().domain().end());
            for piece in &pieces {
                boxes.push(bounds(&piece.control_points));
                set.push(shape, piece);
            }
            set.curves.push((first, breaks));
            set.connect(first, extent(&[bounds(curve.control_points())]));
        }
        set.size = extent(&boxes);
        set.tree = BoxTree::new(&boxes);
        set
    }

    fn push(&mut self, shape: usize, piece: &BezierCurve<D>) {
        let p = piece.control_points.len() - 1;
        let [low, high] = bounds(&piece.control_points);
        let centre = 0.5 * (SVector::from(low) + SVector::from(high));
        let weight = |i: usize| piece.weights.as_ref().map_or(1.0, |w| w[i]);
        let rational = piece.weights.is_some();
        let (min, max) =
            (0..=p).fold((f64::INFINITY, 0.0f64), |(a, b), i| (a.min(weight(i)), b.max(weight(i))));
        self.pieces.push(Piece {
            shape,
            degree: p,
            rational,
            centre,
            interval: piece.interval,
            neighbours: [None; 2],
            ends: [false; 2],
            closed: false,
            min_weight_sq: min * min,
            max_weight_sq: max * max,
            first: self.points.len(),
            form: self.forms.len(),
        });
        let points: Vec<_> =
            (0..=p).map(|i| ((piece.control_points[i] - centre) * weight(i), weight(i))).collect();
        // Parts: |P|², then w P by coordinate, then w².
        let parts = D + 1 + usize::from(rational);
        let mut product = vec![vec![0.0; 2 * p + 1]; D + 2];
        for i in 0..=p {
            for j in 0..=p {
                let factor = binomial(p, i) * binomial(p, j) / binomial(2 * p, i + j);
                let ((a, wa), (b, wb)) = (points[i], points[j]);
                product[0][i + j] += factor * a.dot(&b);
                for d in 0..D {
                    product[1 + d][i + j] += factor * wa * b[d];
                }
                product[D + 1][i + j] += factor * wa * wb;
            }
        }
        let raise = elevation_matrix(2 * p, Self::DEGREE);
        for part in &product[..parts] {
            let mut row = zero_row::<K>();
            for (l, shares) in raise.iter().enumerate() {
                row[l / WIDTH].0[l % WIDTH] = shares.iter().zip(part).map(|(a, b)| a * b).sum();
            }
            self.forms.push(row);
        }
        self.points.extend(points);
    }

    /// Finds out between which pieces, from `first` on, an iteration may cross.
    fn connect(&mut self, first: usize, size: f64) {
        let count = self.pieces.len() - first;
        for i in 0..count {
            let (below, above) = (first + (i + count - 1) % count, first + i);
            let (a, b) = (&self.pieces[below], &self.pieces[above]);
            let (ja, jb) = (self.jet(a, 1.0), self.jet(b, 0.0));
            let continuous = (ja.point + a.centre - jb.point - b.centre).norm() <= 1e-9 * size;
            let (da, db) = (ja.d1 / a.interval.length(), jb.d1 / b.interval.length());
            let smooth = continuous && (da - db).norm() <= SMOOTH * (da.norm() + db.norm());
            if smooth {
                self.pieces[below].neighbours[1] = Some(above);
                self.pieces[above].neighbours[0] = Some(below);
            }
            if i == 0 {
                self.pieces[below].ends[1] = true;
                self.pieces[above].ends[0] = true;
                self.pieces[below].closed = continuous;
                self.pieces[above].closed = continuous;
            }
        }
    }

    /// The piece that holds the parameter of a curve, and the local parameter there.
    pub(crate) fn locate(&self, shape: usize, t: f64) -> Option<(usize, f64)> {
        let (first, breaks) = self.curves.get(shape)?;
        let index = breaks.partition_point(|&b| b <= t).clamp(1, breaks.len() - 1) - 1;
        let (low, high) = (breaks[index], breaks[index + 1]);
        Some((first + index, unit(t, low, high)))
    }

    /// Bernstein coefficients of `w² (|c − x|² − limit_sq)`; `y` is `x − centre`.
    #[inline(always)]
    pub(crate) fn form(&self, piece: &Piece<D>, y: &SVector<f64, D>, limit_sq: f64) -> Row<K> {
        let constant = y.norm_squared() - limit_sq;
        let mut out = self.forms[piece.form];
        for k in 0..K {
            for d in 0..D {
                out[k] = out[k] + self.forms[piece.form + 1 + d][k] * (-2.0 * y[d]);
            }
            if piece.rational {
                out[k] = out[k] + self.forms[piece.form + 1 + D][k] * constant;
            } else {
                out[k] = out[k] + Lanes::splat(constant);
            }
        }
        out
    }

    /// Bernstein coefficients of the squared weight function, unless it is constant 1.
    pub(crate) fn weight_form(&self, piece: &Piece<D>) -> Option<&Row<K>> {
        piece.rational.then(|| &self.forms[piece.form + 1 + D])
    }

    /// The jet at the local parameter, relative to the centre.
    #[inline(always)]
    pub(crate) fn jet(&self, piece: &Piece<D>, s: f64) -> CurveJet<D> {
        match piece.degree {
            1 => self.fixed_jet::<2>(piece, s),
            2 => self.fixed_jet::<3>(piece, s),
            3 => self.fixed_jet::<4>(piece, s),
            _ => self.general_jet(piece, s),
        }
    }

    /// The jet of a piece with `N` control points.
    #[inline(always)]
    fn fixed_jet<const N: usize>(&self, piece: &Piece<D>, s: f64) -> CurveJet<D> {
        let mut basis = [[0.0; 3]; N];
        basis_jet(N - 1, s, &mut basis);
        sum(&self.points[piece.first..][..N], &basis, piece.rational)
    }

    fn general_jet(&self, piece: &Piece<D>, s: f64) -> CurveJet<D> {
        let p = piece.degree;
        let mut basis = [[0.0; 3]; MAX_DEGREE + 1];
        basis_jet(p, s, &mut basis[..=p]);
        sum(&self.points[piece.first..=piece.first + p], &basis[..=p], piece.rational)
    }

    /// The control points, relative to the centre, times their weights, and these.
    pub(in crate::global) fn points(&self, piece: &Piece<D>) -> &[(SVector<f64, D>, f64)] {
        &self.points[piece.first..=piece.first + piece.degree]
    }

    /// Squared distance of `x` from the point at the local parameter.
    #[inline(always)]
    pub(crate) fn distance_sq(&self, x: &SVector<f64, D>, piece: usize, s: f64) -> f64 {
        let piece = &self.pieces[piece];
        (self.jet(piece, s).point - (x - piece.centre)).norm_squared()
    }

    /// Bytes of the prepared data.
    pub(crate) fn memory(&self) -> usize {
        size_of_val(&self.points[..])
            + size_of_val(&self.forms[..])
            + size_of_val(&self.pieces[..])
            + self.tree.memory()
    }
}

/// The jet from control points, times their weights, with the weights, and the basis functions.
#[inline(always)]
fn sum<const D: usize>(points: &[(SVector<f64, D>, f64)], basis: &[[f64; 3]], rational: bool) -> CurveJet<D> {
    let mut a = [SVector::<f64, D>::zeros(); 3];
    for ((point, _), b) in points.iter().zip(basis) {
        for k in 0..3 {
            a[k] += point * b[k];
        }
    }
    if !rational {
        return CurveJet { point: a[0], d1: a[1], d2: a[2] };
    }
    let mut w = [0.0; 3];
    for ((_, weight), b) in points.iter().zip(basis) {
        for k in 0..3 {
            w[k] += weight * b[k];
        }
    }
    let inverse = 1.0 / w[0];
    let point = a[0] * inverse;
    let d1 = (a[1] - point * w[1]) * inverse;
    CurveJet { point, d1, d2: (a[2] - d1 * (2.0 * w[1]) - point * w[2]) * inverse }
}

pub(crate) fn bounds<const D: usize>(points: &[SVector<f64, D>]) -> Bounds<D> {
    let mut low = SVector::<f64, D>::repeat(f64::INFINITY);
    let mut high = -low;
    for p in points {
        low = low.inf(p);
        high = high.sup(p);
    }
    [low.into(), high.into()]
}

pub(crate) fn extent<const D: usize>(boxes: &[Bounds<D>]) -> f64 {
    let side = |d: usize| {
        let low = boxes.iter().map(|b| b[0][d]).fold(f64::INFINITY, f64::min);
        boxes.iter().map(|b| b[1][d]).fold(f64::NEG_INFINITY, f64::max) - low
    };
    (0..D).map(side).fold(0.0, f64::max)
}
