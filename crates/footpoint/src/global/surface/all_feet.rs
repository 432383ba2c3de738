//! All local minima of the distance from a set of patches.
//!
//! Branch and bound on the squared distance `F = A / W` (see [`all_feet_line`](crate::global::curve::all_feet_line) for what
//! coefficients of `G = A − c W` tell about it). A box of the parameter domain
//! - is dropped when `F` is above the limit on all of it;
//! - holds no minimum, but on a border of the patch, where `F` is monotone in a parameter, or `G` is concave in a
//!   parameter, or the Hessian of `G` is indefinite, everywhere;
//! - holds at most one minimum where `G` is strictly convex: a stationary point `p` of `F` is the only minimum of
//!   `G` at its own level, so that `F > F(p)` elsewhere;
//! - holds none but a pole where the parameter lines that leave it are convex and none of them falls;
//! - is as good as a point when it is small;
//! - is left as flat when the distance does not change;
//! - and is halved otherwise.

use crate::global::arithmetic::lanes::{Row, WIDTH, add_scaled, zero_row};
use crate::global::arithmetic::simd::vectorized;
use crate::global::curve::all_feet_line::{Harvest, Level, Line, Range, Spot};
use crate::global::gap::Gap;
use crate::global::proof::box_tests::{Bends, argmin, bends, edge, largest, sag_direction};
use crate::global::proof::region::Region;
use crate::global::surface::foot::Foot;
use crate::global::surface::patch::PatchSet;
use crate::global::tree::{Bounds, Content, Visit, bounds, extent};
use nalgebra::Vector3;

/// Halvings, in both directions together, after which a box is left as it is.
const MAX_DEPTH: u32 = 90;

/// Halvings before which a box is not small.
const MIN_DEPTH: u32 = 8;

/// How far from a box, in parameters of the patch, a minimum may be found to be the one of the box.
const BESIDE: f64 = 1e-9;

/// A box with the coefficients of `A` and, unless constant, `W`.
struct Block<const K: usize> {
    region: Region,
    squared: Vec<Row<K>>,
    weight: Option<Vec<Row<K>>>,
}

/// One query on one patch.
struct Query<'a> {
    x: &'a Vector3<f64>,
    index: usize,
    level: Level,
}

/// Where the minima of a box may be.
enum Verdict {
    /// Not inside; at the sides marked by `[direction][end]` if these are borders of the patch.
    Sides([[bool; 2]; 2]),
    /// At most one inside.
    One,
    /// None but perhaps the pole, which is here in box parameters.
    Pole([f64; 2]),
    Unknown,
}

impl<const K: usize> PatchSet<K> {
    /// Candidates for all local minima whose squared distance is at most `limit_sq`.
    pub(crate) fn minima(&self, x: &Vector3<f64>, limit_sq: f64, gap: &Gap) -> Harvest<Foot, 3> {
        let mut harvest = Harvest::new(gap.max_boxes);
        let mut visits = vec![Visit::root()];
        let corner = [x.x, x.y, x.z];
        while let Some(visit) = visits.pop() {
            match visit.content() {
                Content::Node(node) => self.tree.expand(node, &corner, limit_sq, &mut visits),
                Content::Item(index) => {
                    harvest.enter_piece();
                    vectorized(
                        #[inline(always)]
                        || self.patch_minima(x, index, limit_sq, gap, &mut harvest),
                    );
                }
            }
        }
        harvest
    }

    #[inline(always)]
    fn patch_minima(
        &self,
        x: &Vector3<f64>,
        index: usize,
        limit_sq: f64,
        gap: &Gap,
        harvest: &mut Harvest<Foot, 3>,
    ) {
        let patch = &self.patches[index];
        let y = x - patch.centre;
        let mut squared = vec![zero_row(); patch.rows()];
        // Squared distances less that of the centre: next to a pole they are small, and so are their rounding errors.
        let base = y.norm_squared();
        self.form(patch, &y, base, &mut squared);
        let scale = largest(&squared);
        let weights = [patch.min_weight_sq, patch.max_weight_sq];
        let level = Level::new(limit_sq, base, scale, weights, gap.tie, self.size);
        let weight = self.weight_form(patch).map(<[_]>::to_vec);
        let region = Region { noise: self.difference_noise(patch, &y, &Region::UNIT), ..Region::UNIT };
        let mut stack = vec![Block { region, squared, weight }];
        while let Some(block) = stack.pop() {
            let level = Level { noise: block.region.noise, ..level };
            let query = Query { x, index, level };
            if !harvest.enter_box() {
                return;
            }
            let weights = block.weight.as_deref().map(coefficients);
            let Some(range) = level.range(coefficients(&block.squared), weights) else { continue };
            let region = &block.region;
            match judge(&block, &range, &level, self.poles(index, region)) {
                Verdict::Sides(sides) => {
                    for (d, ends) in sides.into_iter().enumerate() {
                        for (end, wanted) in ends.into_iter().enumerate() {
                            if wanted && region.at_border(d, end) {
                                self.edge_minima(&query, &block, d, end, harvest);
                            }
                        }
                    }
                    continue;
                }
                Verdict::One => {
                    // An iteration that leads elsewhere does not tell whether there is one in the box.
                    let foot = self.descend(x, index, region.place(argmin(&block.squared)), 50);
                    if foot.patch == index && foot.settled && holds(region, foot.local) {
                        harvest.feet.push(foot);
                        continue;
                    }
                }
                Verdict::Pole(at) => {
                    harvest.feet.push(self.descend(x, index, region.place(at), 50));
                    continue;
                }
                Verdict::Unknown => {}
            }
            let centre = region.place([0.5; 2]);
            let bounds = self.region_bounds(index, region);
            let extent = extent(&[bounds]);
            if region.depth >= MIN_DEPTH && extent <= level.apart {
                harvest.feet.push(self.descend(x, index, centre, 50));
            } else if level.is_continuum(&range, extent) {
                harvest.flats.push((self.descend(x, index, centre, 50), bounds));
            } else if region.depth >= MAX_DEPTH {
                harvest.unresolved = true;
            } else {
                let halves = self.halves(&block, &range);
                stack.extend(halves.map(|mut half| {
                    let noise = self.difference_noise(patch, &y, &half.region);
                    half.region.noise = half.region.noise.min(noise);
                    half
                }));
            }
        }
    }

    /// Which sides of a box, by direction and end, are collapsed into a point.
    fn poles(&self, index: usize, region: &Region) -> [[bool; 2]; 2] {
        let patch = &self.patches[index];
        let cells = &self.cells[patch.shape()];
        [0, 1].map(|d| {
            [0, 1].map(|end| {
                cells.collapsed[d][end] && cells.at_end(patch.cell(), d, end) && region.at_border(d, end)
            })
        })
    }

    /// Both halves of a box.
    #[inline(always)]
    fn halves(&self, block: &Block<K>, range: &Range) -> [Block<K>; 2] {
        let direction = match &block.weight {
            None => sag_direction(&block.squared),
            Some(weight) => sag_direction(&at_level(&block.squared, weight, range.levels[0])),
        };
        let halve = |rows: &Vec<Row<K>>| {
            let mut low = vec![zero_row(); 2 * rows.len()];
            self.halve(rows, direction, &mut low);
            let high = low.split_off(rows.len());
            (low, high)
        };
        let [low, high] = block.region.split(direction, 0.5);
        let (squared_low, squared_high) = halve(&block.squared);
        let (weight_low, weight_high) = block.weight.as_ref().map(halve).unzip();
        [
            Block { region: high, squared: squared_high, weight: weight_high },
            Block { region: low, squared: squared_low, weight: weight_low },
        ]
    }

    /// The minima along the part of a border of the patch that bounds a box.
    fn edge_minima(
        &self,
        query: &Query<'_>,
        block: &Block<K>,
        d: usize,
        end: usize,
        harvest: &mut Harvest<Foot, 3>,
    ) {
        let (region, &Query { x, index, ref level }) = (&block.region, query);
        let (squared, degree) = edge(&block.squared, d, end);
        let weight = block.weight.as_ref().map(|rows| edge(rows, d, end).0);
        let ends = [0, 1].map(|other| region.at_border(1 - d, other));
        let line = Line { squared: &squared, weight: weight.as_ref(), degree, ends };
        let part = |[a, b]: [f64; 2]| {
            let (mut low, mut high) = ([a; 2], [b; 2]);
            (low[d], high[d]) = (end as f64, end as f64);
            Region { low: region.place(low), high: region.place(high), ..*region }
        };
        let extent = |range| extent(&[self.region_bounds(index, &part(range))]);
        for spot in line.minima(level, &extent, &mut || harvest.enter_box()) {
            match spot {
                Spot::Minimum(s) => {
                    harvest.feet.push(self.descend(x, index, part([s; 2]).low, 50));
                }
                Spot::Flat(range) => {
                    let part = part(range);
                    let centre = part.place([0.5; 2]);
                    let foot = self.descend(x, index, centre, 50);
                    // Where the surface goes on smoothly the distance may fall on the other side.
                    let falls = foot.distance_sq < self.distance_sq(x, index, centre) * (1.0 - level.flat);
                    let patch = &self.patches[index];
                    if falls && self.cells[patch.shape()].across(patch.cell(), d, end).is_some() {
                        continue;
                    }
                    harvest.flats.push((foot, self.region_bounds(index, &part)));
                }
                Spot::Unresolved => harvest.unresolved = true,
            }
        }
    }

    /// Box around points sampled on a part of a patch.
    fn region_bounds(&self, index: usize, region: &Region) -> Bounds<3> {
        let patch = &self.patches[index];
        let mut points = [Vector3::zeros(); 25];
        for (k, point) in points.iter_mut().enumerate() {
            let [s, t] = region.place([(k / 5) as f64 / 4.0, (k % 5) as f64 / 4.0]);
            *point = self.point(patch, s, t) + patch.centre;
        }
        bounds(&points)
    }
}

/// Whether a place of the patch lies in a box.
fn holds(region: &Region, place: [f64; 2]) -> bool {
    (0..2).all(|d| place[d] >= region.low[d] - BESIDE && place[d] <= region.high[d] + BESIDE)
}

fn coefficients<const K: usize>(rows: &[Row<K>]) -> impl Iterator<Item = f64> {
    rows.iter().flatten().flat_map(|lanes| lanes.0)
}

/// `A − c W`.
#[inline(always)]
fn at_level<const K: usize>(squared: &[Row<K>], weight: &[Row<K>], c: f64) -> Vec<Row<K>> {
    let mut rows = squared.to_vec();
    for (row, weight) in rows.iter_mut().zip(weight) {
        add_scaled(row, weight, -c);
    }
    rows
}

#[inline(always)]
fn judge<const K: usize>(block: &Block<K>, range: &Range, level: &Level, poles: [[bool; 2]; 2]) -> Verdict {
    let b = match &block.weight {
        None => bends(&block.squared),
        Some(weight) => {
            let [low, high] = range.levels.map(|c| bends(&at_level(&block.squared, weight, c)));
            let hull = |a: [f64; 2], b: [f64; 2]| [a[0].min(b[0]), a[1].max(b[1])];
            Bends {
                du: hull(low.du, high.du),
                dv: hull(low.dv, high.dv),
                duu: hull(low.duu, high.duu),
                dvv: hull(low.dvv, high.dvv),
                duv: hull(low.duv, high.duv),
            }
        }
    };
    let slack = level.slack();
    for (d, slope) in [b.du, b.dv].into_iter().enumerate() {
        let (rising, falling) = (slope[0] > slack, slope[1] < -slack);
        if rising || falling {
            let mut sides = [[false; 2]; 2];
            sides[d] = [rising, falling];
            return Verdict::Sides(sides);
        }
    }
    for (d, bend) in [b.duu, b.dvv].into_iter().enumerate() {
        if bend[1] < -slack {
            let mut sides = [[false; 2]; 2];
            sides[d] = [true; 2];
            return Verdict::Sides(sides);
        }
    }
    let (m, n) = (block.squared.len() as f64 - 1.0, PatchSet::<K>::DEGREE as f64);
    let [uu, vv, uv] = [(b.duu, m * (m - 1.0)), (b.dvv, n * (n - 1.0)), (b.duv, m * n)]
        .map(|(r, factor)| [(r[0] - slack) * factor, (r[1] + slack) * factor]);
    let (least, most) = if uv[0] > 0.0 {
        (uv[0], uv[1])
    } else if uv[1] < 0.0 {
        (-uv[1], -uv[0])
    } else {
        (0.0, uv[1].max(-uv[0]))
    };
    if uu[1].max(0.0) * vv[1].max(0.0) < least * least {
        return Verdict::Sides([[true; 2]; 2]);
    }
    if uu[0] > 0.0 && vv[0] > 0.0 && uu[0] * vv[0] > most * most {
        return Verdict::One;
    }
    // Where the lines that leave a pole are convex and none falls, all of the box is further away than the pole.
    for (d, bend) in [b.duu, b.dvv].into_iter().enumerate() {
        for end in 0..2 {
            if poles[d][end] && bend[0] > slack && least_slope(block, d, end) >= -slack {
                let mut at = [0.5; 2];
                at[d] = end as f64;
                return Verdict::Pole(at);
            }
        }
    }
    Verdict::Unknown
}

/// Lower bound for the derivative into the box along a side that is collapsed into a point.
fn least_slope<const K: usize>(block: &Block<K>, d: usize, end: usize) -> f64 {
    let last = |n: usize, k: usize| if end == 0 { k } else { n - 1 - k };
    let coefficient = |rows: &[Row<K>], k: usize, along: usize| {
        let (i, j) = if d == 0 { (last(rows.len(), k), along) } else { (along, last(WIDTH * K, k)) };
        rows[i][j / WIDTH].0[j % WIDTH]
    };
    let squared = &block.squared;
    let pole = |along| match &block.weight {
        None => (coefficient(squared, 0, along), coefficient(squared, 1, along)),
        Some(weight) => {
            let c = coefficient(squared, 0, 0) / coefficient(weight, 0, 0);
            let value = |k| coefficient(squared, k, along) - c * coefficient(weight, k, along);
            (value(0), value(1))
        }
    };
    let count = if d == 0 { WIDTH * K } else { squared.len() };
    (0..count).map(pole).map(|(at, next)| next - at).fold(f64::INFINITY, f64::min)
}
