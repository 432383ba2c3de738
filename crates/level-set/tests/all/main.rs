//! All integration tests of `level-set` in one binary: linking once is most of what building them costs.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "tests may panic")]

mod contours;
mod evolve;
mod surface;

/// A disc or another region as an image: the share of each pixel that lies inside, by `n × n` samples of it.
fn coverage(width: usize, height: usize, n: usize, inside: impl Fn(f64, f64) -> bool) -> Vec<f64> {
    let share = |pixel: usize| {
        let (column, row) = (pixel % width, pixel / width);
        let within = |sample: &usize| {
            let step = |k: usize| (k as f64 + 0.5) / n as f64;
            let (x, y) =
                (column as f64 + step(sample % n), (height - 1 - row) as f64 + 1.0 - step(sample / n));
            inside(x, y)
        };
        // What lies far from the contour is not sampled in full.
        let corners = [0, n - 1, n * (n - 1), n * n - 1].iter().filter(|sample| within(sample)).count();
        if corners % 4 == 0 {
            return (corners / 4) as f64;
        }
        (0..n * n).filter(within).count() as f64 / (n * n) as f64
    };
    (0..width * height).map(share).collect()
}
