#![allow(clippy::unwrap_used, reason = "tests may panic")]

use super::*;
use nurbs_core::{BsplineSurface, KnotVector};

/// A small generator: the same numbers in every run.
struct Random(u64);

impl Random {
    fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }

    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }
}

/// One patch over the unit square, of heights by chance, with weights between `1 / range` and `range`.
fn noise([p, q]: [usize; 2], height: f64, range: f64) -> BsplineSurface {
    let mut random = Random(11 + p as u64);
    let knots = [p, q].map(|degree| KnotVector::uniform_clamped(degree, degree + 1).unwrap());
    let points: Vec<_> = (0..(p + 1) * (q + 1))
        .map(|k| {
            let (i, j) = (k / (q + 1), k % (q + 1));
            Vector3::new(i as f64 / p as f64, j as f64 / q as f64, random.between(-height, height))
        })
        .collect();
    let weights =
        (range > 1.0).then(|| points.iter().map(|_| range.powf(random.between(-1.0, 1.0))).collect());
    let [u, v] = knots;
    BsplineSurface::new(u, v, points, weights).unwrap()
}

/// One patch over the unit square whose inner control points are up.
fn bump(height: f64) -> BsplineSurface {
    let knots = KnotVector::uniform_clamped(3, 4).unwrap();
    let points = (0..16).map(|k| {
        let (i, j) = (k / 4, k % 4);
        let inner = (1..3).contains(&i) && (1..3).contains(&j);
        Vector3::new(f64::from(i) / 3.0, f64::from(j) / 3.0, if inner { height } else { 0.0 })
    });
    BsplineSurface::new(knots.clone(), knots, points.collect(), None).unwrap()
}

/// Divided patches: of high degree, steep, of unequal weights.
fn patches() -> Vec<PatchSet<4>> {
    let surfaces = [
        noise([9, 9], 0.4, 1.0),
        noise([15, 3], 0.4, 1.0),
        bump(60.0),
        noise([3, 3], 0.3, 1e3),
        noise([9, 5], 0.3, 10.0),
    ];
    surfaces.iter().map(|surface| PatchSet::new(std::iter::once(surface))).collect()
}

/// The ends of the tree, with their numbers.
fn leaves(tiles: &Tiles) -> impl Iterator<Item = (u32, &Node)> {
    (0..).zip(&tiles.nodes).filter(|(_, node)| node.next == 0)
}

#[test]
fn tiles_cover_a_patch_once() {
    for set in patches() {
        assert!(set.is_tiled(0));
        let tiles = set.tiles();
        let area =
            |node: &Node| (0..2).map(|d| f64::from(node.high[d]) - f64::from(node.low[d])).product::<f64>();
        assert_eq!(leaves(tiles).map(|(_, node)| area(node)).sum::<f64>(), 1.0);
        assert!(tiles.leaves.len() > 30 && tiles.leaves.len() <= 600, "{}", tiles.leaves.len());
        assert!(tiles.memory() < 1200 * tiles.leaves.len());
    }
}

#[test]
fn boxes_and_ranges_hold_what_is_on_a_tile() {
    let mut random = Random(5);
    for set in patches() {
        let (tiles, patch) = (set.tiles(), &set.patches[0]);
        for (node, tile) in leaves(tiles) {
            let leaf = tiles.leaf(node);
            let region = tile.region();
            let sides = [0, 1].map(|d| region.high[d] - region.low[d]);
            for _ in 0..4 {
                let place = [random.unit(), random.unit()];
                let derivatives = |place: [f64; 2]| {
                    let [s, t] = region.place(place);
                    let jet = set.jet(patch, s, t);
                    let [a, b] = sides;
                    [
                        jet.point - Vector3::from(tile.centre),
                        jet.du * a,
                        jet.dv * b,
                        jet.duu * (a * a),
                        jet.duv * (a * b),
                        jet.dvv * (b * b),
                    ]
                };
                let here = derivatives(place);
                assert!(tile.distance(&(here[0] + Vector3::from(tile.centre))) < 1e-12 * patch.radius);
                // Third derivatives by differences of second ones.
                let h = 1e-4;
                let inner = place.map(|s| s.clamp(2.0 * h, 1.0 - 2.0 * h));
                let third = |d: usize, k: usize| {
                    let [mut to, mut from] = [inner; 2];
                    to[d] += h;
                    from[d] -= h;
                    (derivatives(to)[k] - derivatives(from)[k]) / (2.0 * h)
                };
                let thirds = [third(0, 3), third(1, 3), third(0, 5), third(1, 5)];
                for c in 0..3 {
                    let most = leaf.spans[c].iter().fold(0.0f64, |all, span| all.max(f64::from(span[1])));
                    for (k, value) in here.iter().chain(&thirds).enumerate() {
                        let [middle, half] = leaf.spans[c][k].map(f64::from);
                        let allowed =
                            if k < 6 { 1e-12 * patch.radius } else { 1e-5 * most + 1e-6 * patch.radius };
                        assert!(
                            (value[c] - middle).abs() <= half + allowed,
                            "{k} {c}: {} off {middle} by more than {half}",
                            value[c]
                        );
                    }
                }
            }
        }
    }
}

#[test]
fn reduced_nets_are_off_by_what_is_said() {
    let mut random = Random(6);
    let mut reduced = 0;
    for set in patches() {
        let (tiles, patch) = (set.tiles(), &set.patches[0]);
        let layout = Layout::reduced(patch.rational);
        for (node, tile) in leaves(tiles) {
            let Some((net, centre)) = tiles.net(node, layout.length()) else { continue };
            reduced += 1;
            let net: Vec<f64> = net.iter().map(|&value| f64::from(value)).collect();
            let region = tile.region();
            let sides = [0, 1].map(|d| region.high[d] - region.low[d]);
            // As seen from a query, on a part of the tile.
            let y = Vector3::from(centre) + Vector3::new(0.3, -0.2, 0.5) * patch.radius;
            let part = Region { high: [0, 1].map(|d| region.low[d] + 0.5 * sides[d]), ..region };
            let (bounds, _) = tiles.reduction(node, &part, &y);
            for _ in 0..4 {
                let place = [random.unit(), random.unit()];
                let [s, t] = part.place(place);
                let exact = set.homogeneous_jet(patch, s, t);
                let found = layout.jet(&net, region.local([s, t]));
                for k in 0..6 {
                    let order = [[0, 0], [1, 0], [0, 1], [2, 0], [1, 1], [0, 2]][k];
                    let scale = (0.5 * sides[0]).powi(order[0]) * (0.5 * sides[1]).powi(order[1]);
                    let half = 0.5f64.powi(order[0] + order[1]);
                    let (w, v) = (exact[k][3] * scale, found[k][3] * half);
                    let floor = 1e-13 * patch.max_weight_sq.sqrt();
                    assert!((w - v).abs() <= bounds[1][k] + floor, "{k}: {w} {v} {:?}", bounds[1]);
                    for c in 0..3 {
                        let own = exact[k][c] * scale - w * y[c];
                        let other = found[k][c] * half + v * (centre[c] - y[c]);
                        assert!(
                            (own - other).abs() <= bounds[0][k] + floor * patch.radius,
                            "{k} {c}: {own} {other} {:?}",
                            bounds[0]
                        );
                    }
                }
            }
        }
    }
    assert!(reduced > 100, "{reduced}");
}

#[test]
fn ordinary_patches_are_left_alone() {
    for surface in [noise([3, 3], 0.3, 1.0), noise([3, 3], 0.3, 3.0), bump(1.0)] {
        let set = PatchSet::<1>::new(std::iter::once(&surface));
        assert!(!set.is_tiled(0) && set.tiles().memory() == 0);
    }
}
