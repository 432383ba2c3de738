//! Subsets of clouds.

use nalgebra::Vector3;

use super::random::Random;

/// Up to `count` indices in random order, in which no place is preferred for being densely scanned.
///
/// A point stays with a probability inversely proportional to the number of points in its cell of the given side. Cells
/// with fewer points than most count as most do, so that scattered outliers gain nothing.
pub(crate) fn thin(points: &[Vector3<f64>], cell: f64, count: usize, random: &mut Random) -> Vec<usize> {
    let mut indices: Vec<usize> = (0..points.len()).collect();
    let considered = (20 * count).min(points.len());
    random.shuffle_front(&mut indices, considered);
    indices.truncate(considered);
    let origin = points.first().copied().unwrap_or_default();
    let key = |index: usize| ((points[index] - origin) / cell).map(f64::floor).into();
    let mut keys: Vec<[f64; 3]> = indices.iter().map(|&index| key(index)).collect();
    keys.sort_unstable_by(lexicographic);
    let mut cells: Vec<([f64; 3], usize)> = Vec::new();
    for key in keys {
        match cells.last_mut() {
            Some((last, members)) if *last == key => *members += 1,
            _ => cells.push((key, 1)),
        }
    }
    // Over the points, not over the cells: lonely outliers may have most of the cells. And above the median, since they may
    // be half of the points.
    let mut members: Vec<usize> = cells.iter().map(|cell| cell.1).collect();
    members.sort_unstable();
    let mut seen = 0;
    let usual = members.iter().find(|&&m| {
        seen += m;
        100 * seen >= 65 * indices.len()
    });
    let usual = usual.copied().unwrap_or(1);
    let population = |index: usize| {
        let found = cells.binary_search_by(|(other, _)| lexicographic(other, &key(index)));
        found.map_or(1, |at| cells[at].1)
    };
    let mut kept: Vec<usize> =
        indices.iter().copied().filter(|&i| random.unit() * population(i) as f64 <= usual as f64).collect();
    kept.truncate(count);
    kept
}

fn lexicographic(a: &[f64; 3], b: &[f64; 3]) -> std::cmp::Ordering {
    a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])).then(a[2].total_cmp(&b[2]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dense_places_are_thinned_and_lonely_points_are_not_favoured() {
        let mut random = Random::new(3);
        // Left half with ten times the density of the right half, and a few points all around.
        let mut points: Vec<_> = (0..11_000)
            .map(|i| Vector3::new(if i % 11 == 0 { 1.0 } else { 0.0 } + random.unit(), random.unit(), 0.0))
            .collect();
        points
            .extend((0..500).map(|_| Vector3::new(random.unit(), random.unit(), 1.0 + random.unit()) * 3.0));
        let kept = thin(&points, 0.1, 100_000, &mut random);
        let lonely = kept.iter().filter(|&&i| points[i].z > 0.0).count();
        let right = kept.iter().filter(|&&i| points[i].z == 0.0 && points[i].x > 1.0).count();
        let left = kept.len() - lonely - right;
        assert!(lonely <= 500 && (900..=1000).contains(&right), "{lonely} {right}");
        assert!(left < 10_000, "{left}");
        let mut sorted = kept.clone();
        sorted.sort_unstable();
        sorted.dedup();
        assert_eq!(sorted.len(), kept.len());
        assert!(thin(&[], 0.1, 10, &mut random).is_empty());
    }
}
