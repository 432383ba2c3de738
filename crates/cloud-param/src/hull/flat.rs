//! Hulls of points in a plane.

use super::predicates::Scaled;

/// The corners of the convex hull of points in the plane of three of them, in order, by Andrew's monotone chain.
pub(super) fn polygon(scaled: &Scaled, corners: [u32; 3]) -> Vec<u32> {
    // A projection along an axis that leaves the triangle an area is one-to-one on its plane.
    let axis = (0..3).find(|&axis| scaled.turn(axis, corners) != 0.0).unwrap_or(2);
    let key = |i: u32| {
        let p = &scaled.points[i as usize];
        [p[(axis + 1) % 3] + 0.0, p[(axis + 2) % 3] + 0.0]
    };
    let mut order: Vec<u32> = scaled.points.iter().zip(0u32..).map(|(_, i)| i).collect();
    order.sort_unstable_by(|&i, &j| {
        let ([a, b], [c, d]) = (key(i), key(j));
        a.total_cmp(&c).then(b.total_cmp(&d)).then(i.cmp(&j))
    });
    order.dedup_by(|i, j| key(*i) == key(*j));
    let chain = |indices: &mut dyn Iterator<Item = u32>| {
        let mut chain: Vec<u32> = Vec::new();
        for i in indices {
            while let [.., a, b] = chain[..] {
                if scaled.turn(axis, [a, b, i]) > 0.0 {
                    break;
                }
                chain.pop();
            }
            chain.push(i);
        }
        chain.pop();
        chain
    };
    let mut hull = chain(&mut order.iter().copied());
    hull.extend(chain(&mut order.iter().rev().copied()));
    hull
}
