//! The equation `|∇u| = 1/v` at one node, from the values of its neighbours.

/// The least solution of `Σ (c_k (u − b_k))² = f²` over the axes that lie below it, the upwind difference along each axis being
/// `c_k (u − b_k)`; `b` and `c` have an entry per axis, `b` infinite where there is no neighbour.
pub(super) fn solve<const D: usize>(mut b: [f64; D], mut c: [f64; D], slowness: f64) -> f64 {
    // Axes by their values; three at most.
    for i in 1..D {
        let mut j = i;
        while j > 0 && b[j - 1] > b[j] {
            b.swap(j - 1, j);
            c.swap(j - 1, j);
            j -= 1;
        }
    }
    let mut best = f64::INFINITY;
    // Sums of c², c² (b − b₀) and c² (b − b₀)²: differences keep their digits.
    let (mut cc, mut cb, mut bb) = (0.0, 0.0, 0.0);
    for k in 0..D {
        if b[k] >= best || b[k] == f64::INFINITY {
            break;
        }
        let (square, offset) = (c[k] * c[k], b[k] - b[0]);
        cc += square;
        cb += square * offset;
        bb += square * offset * offset;
        let discriminant = cb * cb - cc * (bb - slowness * slowness);
        if discriminant < 0.0 {
            break;
        }
        best = b[0] + (cb + discriminant.sqrt()) / cc;
    }
    best
}

#[cfg(test)]
mod tests {
    use super::solve;

    #[test]
    fn planes_are_solved_exactly() {
        // u = .6 x + .8 y with spacing 1: from the neighbours at −x and −y.
        assert!((solve([-0.6, -0.8], [1.0, 1.0], 1.0)).abs() < 1e-15);
        // With unequal spacings, in space.
        let n = [2.0f64 / 7.0, 3.0 / 7.0, 6.0 / 7.0];
        let h = [0.5, 0.25, 2.0];
        let b = [0, 1, 2].map(|k| -n[k] * h[k]);
        assert!(solve(b, h.map(f64::recip), 1.0).abs() < 1e-15);
    }

    #[test]
    fn one_neighbour_and_none() {
        assert_eq!(solve([2.0, f64::INFINITY], [4.0, 1.0], 1.0), 2.25);
        assert_eq!(solve([0.0, 5.0], [1.0, 1.0], 1.0), 1.0);
        assert_eq!(solve([f64::INFINITY; 3], [1.0; 3], 1.0), f64::INFINITY);
    }
}
