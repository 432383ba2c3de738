//! Connected parts of a cloud.

use nalgebra::Vector3;
use std::collections::BTreeMap;

/// For each point the number of the part it belongs to, the largest first, and the sizes of the parts.
///
/// Points are joined when the cubes of side `reach` that they lie in touch.
pub(crate) fn components(points: &[Vector3<f64>], reach: f64) -> (Vec<usize>, Vec<usize>) {
    let mut cells: BTreeMap<[i64; 3], Vec<usize>> = BTreeMap::new();
    #[expect(clippy::cast_possible_truncation, reason = "cells of finite points; extreme ones saturate")]
    let cell = |p: &Vector3<f64>| [0, 1, 2].map(|k| (p[k] / reach).floor() as i64);
    for (i, p) in points.iter().enumerate() {
        cells.entry(cell(p)).or_default().push(i);
    }
    let mut part = vec![usize::MAX; points.len()];
    let mut sizes = Vec::new();
    for start in cells.keys() {
        if part[cells[start][0]] != usize::MAX {
            continue;
        }
        let number = sizes.len();
        let (mut stack, mut size) = (vec![*start], 0);
        for &i in &cells[start] {
            part[i] = number;
        }
        while let Some(at) = stack.pop() {
            size += cells[&at].len();
            for k in 0..27i64 {
                let near = [
                    at[0].saturating_add(k % 3 - 1),
                    at[1].saturating_add(k / 3 % 3 - 1),
                    at[2].saturating_add(k / 9 - 1),
                ];
                if let Some(members) = cells.get(&near).filter(|m| part[m[0]] == usize::MAX) {
                    for &i in members {
                        part[i] = number;
                    }
                    stack.push(near);
                }
            }
        }
        sizes.push(size);
    }
    let mut order: Vec<usize> = (0..sizes.len()).collect();
    order.sort_by_key(|&k| std::cmp::Reverse(sizes[k]));
    let mut rank = vec![0; sizes.len()];
    for (place, &k) in order.iter().enumerate() {
        rank[k] = place;
    }
    (part.into_iter().map(|k| rank[k]).collect(), order.into_iter().map(|k| sizes[k]).collect())
}
