//! Numbers that look random and are the same in every run.

use nalgebra::Vector3;

/// A generator (splitmix64): streams of neighbouring seeds are independent.
#[derive(Clone, Debug)]
pub(super) struct Random(u64);

impl Random {
    pub(super) fn new(seed: u64) -> Self {
        Self(seed.wrapping_mul(0xd134_2543_de82_ef95).wrapping_add(0x9e37_79b9_7f4a_7c15))
    }

    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// In [−½, ½).
    pub(super) fn centred(&mut self) -> f64 {
        (self.next() >> 11) as f64 / (1u64 << 53) as f64 - 0.5
    }

    /// In `0..count`; `count` is not 0.
    pub(super) fn below(&mut self, count: usize) -> usize {
        #[expect(clippy::cast_possible_truncation, reason = "below a count that is one")]
        let index = (self.next() % count as u64) as usize;
        index
    }

    /// A unit vector, evenly over the sphere.
    pub(super) fn direction(&mut self) -> Vector3<f64> {
        let z = 2.0 * self.centred();
        let (sin, cos) = (std::f64::consts::TAU * self.centred()).sin_cos();
        let r = (1.0 - z * z).sqrt();
        Vector3::new(r * cos, r * sin, z)
    }

    /// `count` different entries of a list, all of it if it is no longer.
    pub(super) fn subset<T: Copy>(&mut self, list: &[T], count: usize) -> Vec<T> {
        if list.len() <= count {
            return list.to_vec();
        }
        let mut chosen: Vec<usize> = Vec::with_capacity(count);
        while chosen.len() < count {
            let index = self.below(list.len());
            if !chosen.contains(&index) {
                chosen.push(index);
            }
        }
        chosen.into_iter().map(|index| list[index]).collect()
    }
}
