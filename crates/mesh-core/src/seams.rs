//! Open edges of a mesh that are one edge but for rounding.
//!
//! Programs compute a corner anew for every face that meets there, and write it with the digits that the file has. Where
//! such copies differ in their last digits, an exact comparison leaves slits in a closed surface. Here two open edges
//! are joined if their ends agree within the precision of the coordinates. Vertices inside closed surfaces are never
//! touched, no triangle loses its area, and triangles that lie on each other, as those of a thin sheet, stay apart.

use nalgebra::{Point3, Vector3};

use crate::bounds::is_finite;
use crate::{BoundingBox, MeshTopology};

/// Part of the diagonal that is rounding in files of doubles.
const PART: f64 = 1e-9;
/// Two units in the last place of a single, as a part of the number.
const SINGLE: f64 = 2.0 / 8_388_608.0;
/// What sine and cosine of right angles leave in single precision, as a part of the largest coordinate.
const RESIDUE: f64 = 1e-7;
/// Decimals of `%f`, and significant digits of `%g` and `%e`: files that are written with so many were rounded to them.
const DIGITS: std::ops::RangeInclusive<i32> = 6..=9;
/// The last digit counts as rounding only up to this part of the diagonal.
const COARSEST: f64 = 1e-5;
/// Most open edges that are compared with one in a cell of the search grid.
const MOST_IN_CELL: usize = 32;
/// Triangles looked at to see that none is flattened, per triangle of the mesh.
const MOST_LOOKS: usize = 64;

/// An edge of one triangle only, from corner to corner.
#[derive(Debug, Clone, Copy)]
struct OpenEdge {
    ends: [u32; 2],
    apex: u32,
}

/// Vertices that are to be joined: the root of each, the smallest vertex of its group.
#[derive(Debug)]
pub(crate) struct Joined {
    pub(crate) roots: Vec<u32>,
    /// Number of vertices that are not their own root.
    pub(crate) count: usize,
    /// Largest difference of a coordinate from that of the root.
    pub(crate) largest: f64,
}

/// Joins open edges of `triangles`, whose corners are numbers of exactly equal positions.
///
/// `None` where there is nothing to join. O(n log n) in the number of triangles, O(n) for a closed mesh.
pub(crate) fn join(positions: &[Point3<f64>], triangles: &[[u32; 3]]) -> Option<Joined> {
    if is_balanced(triangles) {
        return None;
    }
    let open = open_edges(positions, triangles);
    let precision = Precision::of(positions, &open)?;
    let pairs = matching_edges(positions, &open, &precision);
    let mut groups = Groups::new(positions, triangles, &open);
    let mut taken = vec![false; open.len()];
    for pair in pairs {
        let (one, other) = (pair.edges[0] as usize, pair.edges[1] as usize);
        if taken[one] || taken[other] {
            continue;
        }
        let [a, b] = open[one].ends;
        let [c, d] =
            if pair.same_direction { open[other].ends } else { [open[other].ends[1], open[other].ends[0]] };
        if groups.unite_both([a, c], [b, d], 2.0 * precision.largest) {
            (taken[one], taken[other]) = (true, true);
        }
    }
    groups.finish()
}

/// Whether every edge is run through as often in one direction as in the other, as in a closed oriented mesh.
///
/// Each edge counts with a number of its own, so that only the edges that are not balanced leave something in the sum.
fn is_balanced(triangles: &[[u32; 3]]) -> bool {
    let mut sum = 0u64;
    for &[a, b, c] in triangles.iter().filter(|corners| has_edges(corners)) {
        for (from, to) in [(a, b), (b, c), (c, a)] {
            let mut mixed = (u64::from(from.min(to)) << 32) ^ u64::from(from.max(to));
            mixed = (mixed ^ (mixed >> 33)).wrapping_mul(0xff51_afd7_ed55_8ccd);
            mixed = (mixed ^ (mixed >> 33)).wrapping_mul(0xc4ce_b9fe_1a85_ec53);
            mixed ^= mixed >> 33;
            sum = if from < to { sum.wrapping_add(mixed) } else { sum.wrapping_sub(mixed) };
        }
    }
    sum == 0
}

const fn has_edges([a, b, c]: &[u32; 3]) -> bool {
    *a != *b && *b != *c && *c != *a
}

/// Edges of one triangle only, between finite positions, in the order of their ends.
fn open_edges(positions: &[Point3<f64>], triangles: &[[u32; 3]]) -> Vec<OpenEdge> {
    let mut edges = Vec::with_capacity(3 * triangles.len());
    for &[a, b, c] in triangles.iter().filter(|corners| has_edges(corners)) {
        for (from, to, apex) in [(a, b, c), (b, c, a), (c, a, b)] {
            edges.push((from.min(to), from.max(to), from, apex));
        }
    }
    edges.sort_unstable();
    let finite = |vertex: u32| is_finite(&positions[vertex as usize]);
    let alone =
        edges.chunk_by(|one, other| (one.0, one.1) == (other.0, other.1)).filter(|same| same.len() == 1);
    alone
        .map(|same| {
            let (low, high, from, apex) = same[0];
            OpenEdge { ends: if from == low { [low, high] } else { [high, low] }, apex }
        })
        .filter(|edge| edge.ends.iter().chain([&edge.apex]).all(|&vertex| finite(vertex)))
        .collect()
}

/// How far copies of one number can be apart.
#[derive(Debug, Clone, Copy)]
struct Precision {
    /// Whatever the number is.
    absolute: f64,
    /// As a part of the number.
    relative: f64,
    /// Of the largest coordinate.
    largest: f64,
}

impl Precision {
    /// The precision of the ends of open edges; `None` if nothing can be said.
    fn of(positions: &[Point3<f64>], open: &[OpenEdge]) -> Option<Self> {
        let diagonal = BoundingBox::of(positions)?.diagonal();
        if open.len() < 2 || !(diagonal > 0.0 && diagonal < f64::MAX) {
            return None;
        }
        let numbers = || open.iter().flat_map(|edge| positions[edge.ends[0] as usize].iter().copied());
        let largest = numbers().fold(0.0, |largest: f64, number| largest.max(number.abs()));
        let mut absolute = PART * diagonal;
        let mut relative = 0.0;
        if numbers().all(is_single) {
            absolute = absolute.max(RESIDUE * largest);
            relative = SINGLE;
        } else {
            // A little more than a unit, for what is lost when the decimal number becomes a double.
            let unit = |digits: i32| 1.01 * 10f64.powi(-digits);
            let lengths = |from: fn(f64) -> i32| {
                numbers().filter(|&number| number != 0.0).map(move |number| digits(number, from(number)))
            };
            if let Some(decimals) = rounded_to(lengths(|_| 0))
                && unit(decimals) <= COARSEST * diagonal
            {
                absolute = absolute.max(unit(decimals));
            }
            if let Some(digits) = rounded_to(lengths(exponent))
                && unit(digits - 1) * largest <= COARSEST * diagonal
            {
                relative = unit(digits - 1);
            }
        }
        Some(Self { absolute, relative, largest: absolute.max(relative * largest) })
    }

    fn agree(&self, a: &Point3<f64>, b: &Point3<f64>) -> bool {
        a.iter()
            .zip(b.iter())
            .all(|(a, b)| (a - b).abs() <= self.absolute.max(self.relative * a.abs().max(b.abs())))
    }
}

/// Whether a double is one that came from single precision.
#[expect(clippy::cast_possible_truncation, reason = "this is what is asked")]
fn is_single(number: f64) -> bool {
    f64::from(number as f32) == number
}

/// One more than the exponent of the first digit, negative: the number of decimals before it.
#[expect(clippy::cast_possible_truncation, reason = "within ±324")]
fn exponent(number: f64) -> i32 {
    if number == 0.0 { 0 } else { -1 - number.abs().log10().floor() as i32 }
}

/// The number of digits of `number` after the place `from`; one more than can matter where there is no end to them.
fn digits(number: f64, from: i32) -> i32 {
    let is_whole = |digits: i32| {
        let scaled = number.abs() * 10f64.powi((digits + from).clamp(-300, 300));
        (scaled - scaled.round()).abs() <= 4.0 * f64::EPSILON * scaled
    };
    let last = *DIGITS.end() + 1;
    (0..last).find(|&digits| is_whole(digits)).unwrap_or(last)
}

/// The number of digits to which numbers were rounded: that of the longest, if half of them have so many or one less, as
/// they have unless they were chosen to be round. Zeros are not to be counted.
fn rounded_to(lengths: impl Iterator<Item = i32> + Clone) -> Option<i32> {
    let longest = lengths.clone().max()?;
    let (mut known, mut long) = (0usize, 0usize);
    for length in lengths {
        known += 1;
        long += usize::from(length + 1 >= longest);
    }
    (DIGITS.contains(&longest) && 2 * long >= known).then_some(longest)
}

/// Two open edges that agree.
#[derive(Debug, Clone, Copy)]
struct Pair {
    distance: f64,
    edges: [u32; 2],
    same_direction: bool,
}

/// All pairs of open edges that agree and do not fold their triangles onto each other, the nearest first.
fn matching_edges(positions: &[Point3<f64>], open: &[OpenEdge], precision: &Precision) -> Vec<Pair> {
    let cell = 2.0 * precision.largest;
    let end = |edge: &OpenEdge, end: usize| positions[edge.ends[end] as usize];
    let middle = |edge: &OpenEdge| nalgebra::center(&end(edge, 0), &end(edge, 1)).coords / cell;
    #[expect(
        clippy::cast_possible_truncation,
        reason = "saturates, where cells are larger than numbers can tell"
    )]
    let place = |edge: &OpenEdge| middle(edge).map(|value| value.floor() as i64);
    let mut cells: Vec<([i64; 3], u32)> = (open.iter().zip(0u32..))
        .filter(|(edge, _)| (end(edge, 1) - end(edge, 0)).norm() > 2.0 * precision.largest)
        .map(|(edge, index)| (place(edge).into(), index))
        .collect();
    cells.sort_unstable();
    let mut pairs = Vec::new();
    for &(centre, one) in &cells {
        for step in 0..27i64 {
            let steps = [step % 3 - 1, step / 3 % 3 - 1, step / 9 - 1];
            let wanted: [i64; 3] = std::array::from_fn(|axis| centre[axis].saturating_add(steps[axis]));
            let start = cells.partition_point(|(cell, _)| *cell < wanted);
            let same = cells[start..].iter().take_while(|(cell, _)| *cell == wanted).take(MOST_IN_CELL);
            for &(_, other) in same.filter(|(_, other)| *other > one) {
                let (first, second) = (&open[one as usize], &open[other as usize]);
                for same_direction in [false, true] {
                    let (c, d) = if same_direction { (0, 1) } else { (1, 0) };
                    let gaps = [end(first, 0) - end(second, c), end(first, 1) - end(second, d)];
                    if precision.agree(&end(first, 0), &end(second, c))
                        && precision.agree(&end(first, 1), &end(second, d))
                        && !is_fold(positions, first, second, precision.largest)
                    {
                        let distance = gaps[0].norm_squared() + gaps[1].norm_squared();
                        pairs.push(Pair { distance, edges: [one, other], same_direction });
                    }
                }
            }
        }
    }
    pairs.sort_by(|a, b| {
        a.distance
            .total_cmp(&b.distance)
            .then(a.same_direction.cmp(&b.same_direction))
            .then(a.edges.cmp(&b.edges))
    });
    pairs
}

/// Whether the triangles at two edges lie on each other, as the two sides of a thin sheet do.
fn is_fold(positions: &[Point3<f64>], one: &OpenEdge, other: &OpenEdge, tolerance: f64) -> bool {
    let [a, b, c, d] =
        [one.ends[0], one.ends[1], one.apex, other.apex].map(|vertex| positions[vertex as usize]);
    let along = (b - a).normalize();
    let height = |apex: Point3<f64>| {
        let side = apex - a;
        side - along * side.dot(&along)
    };
    let (h, k) = (height(c), height(d));
    let unit = |vector: Vector3<f64>| vector.try_normalize(0.0).unwrap_or_else(Vector3::zeros);
    let apart = (unit(h) - unit(k)).norm() * h.norm().min(k.norm());
    h.dot(&k) > 0.0 && apart <= 4.0 * tolerance
}

/// Groups of vertices in the making.
struct Groups<'a> {
    positions: &'a [Point3<f64>],
    triangles: &'a [[u32; 3]],
    parents: Vec<u32>,
    /// Number of vertices in a group, kept at its root.
    sizes: Vec<u32>,
    /// Triangles at the vertices of a group, kept at its root; of vertices without open edges nothing.
    around: Vec<Vec<u32>>,
    /// Box around each group, kept at its root.
    boxes: Vec<[Point3<f64>; 2]>,
    /// How many triangles may still be looked at.
    work: usize,
}

impl<'a> Groups<'a> {
    fn new(positions: &'a [Point3<f64>], triangles: &'a [[u32; 3]], open: &[OpenEdge]) -> Self {
        let mut is_end = vec![false; positions.len()];
        open.iter().flat_map(|edge| edge.ends).for_each(|vertex| is_end[vertex as usize] = true);
        let mut around = vec![Vec::new(); positions.len()];
        for (corners, triangle) in triangles.iter().zip(0u32..).filter(|(corners, _)| has_edges(corners)) {
            for &vertex in corners.iter().filter(|&&vertex| is_end[vertex as usize]) {
                around[vertex as usize].push(triangle);
            }
        }
        let parents = (0u32..).take(positions.len()).collect();
        let boxes = positions.iter().map(|&position| [position; 2]).collect();
        let work = triangles.len().saturating_mul(MOST_LOOKS).saturating_add(1000);
        Self { positions, triangles, parents, sizes: vec![1; positions.len()], around, boxes, work }
    }

    /// Groups are hung below larger ones, so that the way to the root is short.
    fn root(&self, mut vertex: u32) -> u32 {
        while self.parents[vertex as usize] != vertex {
            vertex = self.parents[vertex as usize];
        }
        vertex
    }

    /// Unites both pairs, unless a triangle would lose a side or a group would become wider than `width`.
    fn unite_both(&mut self, first: [u32; 2], second: [u32; 2], width: f64) -> bool {
        let [first, second] = [first, second].map(|pair| pair.map(|vertex| self.root(vertex)));
        // The ends of an edge must stay two, whatever is united.
        let mixed = first.iter().any(|root| second.contains(root));
        let fits = !mixed && self.may_unite(first, width) && self.may_unite(second, width);
        if fits {
            self.unite(first);
            self.unite(second);
        }
        fits
    }

    fn may_unite(&mut self, [a, b]: [u32; 2], width: f64) -> bool {
        if a == b {
            return true;
        }
        let [p, q] = [&self.boxes[a as usize], &self.boxes[b as usize]];
        let fits = (0..3).all(|axis| p[1][axis].max(q[1][axis]) - p[0][axis].min(q[0][axis]) <= width);
        let fewer = self.around[a as usize].len() <= self.around[b as usize].len();
        let (few, other) = if fewer { (a, b) } else { (b, a) };
        let looks = self.around[few as usize].len();
        if !fits || looks > self.work {
            return false;
        }
        self.work -= looks;
        let reaches = |triangle: &u32| {
            self.triangles[*triangle as usize].iter().any(|&corner| self.root(corner) == other)
        };
        !self.around[few as usize].iter().any(reaches)
    }

    fn unite(&mut self, [a, b]: [u32; 2]) {
        if a == b {
            return;
        }
        let larger = self.sizes[a as usize] >= self.sizes[b as usize];
        let (root, other) = if larger { (a, b) } else { (b, a) };
        self.parents[other as usize] = root;
        let (root, other) = (root as usize, other as usize);
        self.sizes[root] += self.sizes[other];
        let mut less = std::mem::take(&mut self.around[other]);
        if less.len() > self.around[root].len() {
            std::mem::swap(&mut less, &mut self.around[root]);
        }
        self.around[root].append(&mut less);
        let [low, high] = self.boxes[other];
        let own = &mut self.boxes[root];
        *own = [own[0].inf(&low), own[1].sup(&high)];
    }

    /// The groups, if they close something and make no edge one of more triangles than before.
    fn finish(self) -> Option<Joined> {
        const UNKNOWN: u32 = u32::MAX;
        let mut smallest = vec![UNKNOWN; self.parents.len()];
        let roots: Vec<u32> = (0u32..)
            .take(self.parents.len())
            .map(|vertex| {
                let known = &mut smallest[self.root(vertex) as usize];
                *known = if *known == UNKNOWN { vertex } else { *known };
                *known
            })
            .collect();
        let changed = || roots.iter().zip(0u32..).filter(|&(&root, vertex)| root != vertex);
        let count = changed().count();
        if count == 0 {
            return None;
        }
        let before = MeshTopology::of(self.triangles);
        let joined: Vec<[u32; 3]> =
            self.triangles.iter().map(|corners| corners.map(|vertex| roots[vertex as usize])).collect();
        let after = MeshTopology::of(&joined);
        if after.boundary_edges >= before.boundary_edges
            || after.non_manifold_edges > before.non_manifold_edges
            || after.degenerate_triangles > before.degenerate_triangles
        {
            return None;
        }
        let gap = |(&root, vertex): (&u32, u32)| {
            (self.positions[vertex as usize] - self.positions[root as usize]).amax()
        };
        let largest = changed().map(gap).fold(0.0, f64::max);
        Some(Joined { roots, count, largest })
    }
}
