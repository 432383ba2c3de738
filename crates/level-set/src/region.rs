//! Regions of a grid: components, holes, and nodes that may change sides without a change of topology.
//!
//! Inside nodes are neighbours along edges of the grid, outside nodes diagonally as well (4 and 8 neighbours in the plane, 6 and 26 in
//! space), so that inside and outside never cross. Contours agree with this when they are traced with
//! [`Saddles::Separate`](distance_field::Saddles::Separate).

/// All nodes next to one, the diagonal ones included.
fn around<const D: usize>(counts: &[usize; D], node: usize, mut visit: impl FnMut(usize, usize)) {
    let mut at = [0; D];
    let mut rest = node;
    for k in (0..D).rev() {
        at[k] = rest % counts[k];
        rest /= counts[k];
    }
    for offset in 0..3usize.pow(u32::try_from(D).unwrap_or(3)) {
        let (mut rest, mut other, mut steps) = (offset, Some(0), 0);
        for k in 0..D {
            let index = (at[k] + rest % 3).checked_sub(1).filter(|&index| index < counts[k]);
            other = other.zip(index).map(|(sum, index)| sum * counts[k] + index);
            steps += usize::from(rest % 3 != 1);
            rest /= 3;
        }
        if let Some(other) = other.filter(|_| steps > 0) {
            visit(other, steps);
        }
    }
}

/// Numbers of components: of the inside, and of the outside that does not reach the border (holes, or cavities in space).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub struct Topology {
    /// Components of the inside.
    pub components: usize,
    /// Components of the outside that are enclosed.
    pub holes: usize,
}

/// The topology of the nodes with negative values.
#[must_use]
pub fn topology<const D: usize>(counts: &[usize; D], values: &[f64]) -> Topology {
    let mut is_seen = vec![false; values.len()];
    let mut out = Topology::default();
    let mut stack = Vec::new();
    for first in 0..values.len() {
        if is_seen[first] {
            continue;
        }
        let is_inside = values[first] < 0.0;
        let mut reaches_border = false;
        is_seen[first] = true;
        stack.push(first);
        while let Some(node) = stack.pop() {
            let mut neighbours = 0;
            around(counts, node, |other, steps| {
                neighbours += 1;
                let joined = (values[other] < 0.0) == is_inside && (steps == 1 || !is_inside);
                if joined && !is_seen[other] {
                    is_seen[other] = true;
                    stack.push(other);
                }
            });
            reaches_border |= neighbours + 1 < 3usize.pow(u32::try_from(D).unwrap_or(3));
        }
        if is_inside {
            out.components += 1;
        } else if !reaches_border {
            out.holes += 1;
        }
    }
    out
}

/// Whether a node can change sides without a change of topology (a simple point; Bertrand & Malandain, *A new characterization of
/// three-dimensional simple points*, 1994): one component of the inside and one of the outside touch it. `is_inside` tells the sides of the
/// nodes of a grid in the plane or in space.
#[must_use]
pub fn is_simple<const D: usize>(
    counts: &[usize; D],
    node: usize,
    is_inside: impl Fn(usize) -> bool,
) -> bool {
    // The 3^D block around the node, beyond the border outside.
    let side = 3usize.pow(u32::try_from(D).unwrap_or(3));
    let mut block = [false; 27];
    let mut at = [0; D];
    let mut rest = node;
    for k in (0..D).rev() {
        at[k] = rest % counts[k];
        rest /= counts[k];
    }
    for (place, inside) in block.iter_mut().enumerate().take(side) {
        let (mut rest, mut other) = (place, Some(0));
        for k in 0..D {
            let index = (at[k] + rest % 3).checked_sub(1).filter(|&index| index < counts[k]);
            other = other.zip(index).map(|(sum, index)| sum * counts[k] + index);
            rest /= 3;
        }
        *inside = other.is_some_and(&is_inside);
    }
    let steps = |place: usize| {
        let (mut rest, mut steps) = (place, 0);
        for _ in 0..D {
            steps += usize::from(rest % 3 != 1);
            rest /= 3;
        }
        steps
    };
    // Distances of two places along each axis: whether they are neighbours along an edge, and whether at all.
    let apart = |a: usize, b: usize| {
        let (mut a, mut b, mut sum, mut most) = (a, b, 0, 0);
        for _ in 0..D {
            let step = (a % 3).abs_diff(b % 3);
            (sum, most) = (sum + step, most.max(step));
            (a, b) = (a / 3, b / 3);
        }
        (sum == 1, most == 1)
    };
    let touching = |inside: bool| {
        // The inside is looked at up to 18 neighbours in space, 8 in the plane.
        let counts_for = |place: usize| {
            let steps = steps(place);
            steps > 0 && block[place] == inside && (!inside || steps <= 2)
        };
        let mut is_seen = [false; 27];
        let mut parts = 0;
        for first in 0..side {
            let touches = counts_for(first) && (!inside || steps(first) == 1);
            if !touches || is_seen[first] {
                continue;
            }
            parts += 1;
            is_seen[first] = true;
            let mut stack = [0usize; 27];
            let mut height = 1;
            stack[0] = first;
            while height > 0 {
                height -= 1;
                let place = stack[height];
                for other in 0..side {
                    let (along, any) = apart(place, other);
                    let joined = if inside { along } else { any };
                    if joined && !is_seen[other] && counts_for(other) {
                        is_seen[other] = true;
                        stack[height] = other;
                        height += 1;
                    }
                }
            }
        }
        parts
    };
    touching(true) == 1 && touching(false) == 1
}

#[cfg(test)]
mod tests {
    use super::*;

    fn values(rows: &[&str]) -> (Vec<f64>, [usize; 2]) {
        let values = rows.iter().flat_map(|row| row.bytes().map(|b| if b == b'#' { -1.0 } else { 1.0 }));
        (values.collect(), [rows.len(), rows[0].len()])
    }

    #[test]
    fn components_and_holes_are_counted() {
        let (grid, counts) = values(&["..........", ".###..#...", ".#.#...#..", ".###......", "......####"]);
        // The two nodes that touch at a corner are apart.
        assert_eq!(topology(&counts, &grid), Topology { components: 4, holes: 1 });
        // Diagonally the outside gets out.
        let (grid, counts) = values(&[".....", "..##.", ".#.#.", ".###.", "....."]);
        assert_eq!(topology(&counts, &grid), Topology { components: 1, holes: 0 });
        let shell = |node: usize| {
            let at = [node / 25, node / 5 % 5, node % 5];
            let far = at.iter().map(|k| k.abs_diff(2)).max();
            if far == Some(1) { -1.0 } else { 1.0 }
        };
        let cube: Vec<f64> = (0..125).map(shell).collect();
        assert_eq!(topology(&[5; 3], &cube), Topology { components: 1, holes: 1 });
    }

    /// A node is simple if and only if its change leaves the numbers of components and of holes of all blocks as they are: over all 256
    /// blocks of the plane.
    #[test]
    fn simple_points_of_the_plane_are_those_that_keep_the_topology() {
        for bits in 0..256usize {
            let mut values = vec![1.0; 81];
            for (bit, place) in [0, 1, 2, 3, 5, 6, 7, 8].into_iter().enumerate() {
                if bits >> bit & 1 == 1 {
                    values[(3 + place / 3) * 9 + 3 + place % 3] = -1.0;
                }
            }
            let simple = is_simple(&[9, 9], 40, |node| values[node] < 0.0);
            let before = topology(&[9, 9], &values);
            values[40] = -1.0;
            let after = topology(&[9, 9], &values);
            // A change that joins two and closes one hole keeps the numbers' difference, but neither number.
            assert_eq!(simple, before == after, "{bits:08b}: {before:?} {after:?}");
        }
    }

    #[test]
    fn simple_points_of_space() {
        let line = |nodes: &'static [usize]| move |node: usize| nodes.contains(&node);
        // 3 × 3 × 3, the middle being 13. The end of a line is simple, its middle is not, nor is a node alone.
        assert!(is_simple(&[3; 3], 13, line(&[12])));
        assert!(!is_simple(&[3; 3], 13, line(&[12, 14])));
        assert!(!is_simple(&[3; 3], 13, line(&[])));
        // Filling a tunnel is not: all but the two faces across.
        assert!(!is_simple(&[3; 3], 13, |node| node != 4 && node != 22));
        assert!(is_simple(&[3; 3], 13, |node| node / 9 == 0));
    }
}
