//! Parameters sorted by the span that they lie in.

use crate::simd::MAX_LANES;

/// The parameters of one chunk, `D` numbers each, in groups.
pub(crate) struct Groups<const D: usize> {
    keys: Vec<usize>,
    /// Where each sorted parameter came from.
    order: Vec<u32>,
    /// For the counting sort: the next free place of each key.
    places: Vec<usize>,
    sorted: [Vec<f64>; D],
}

/// Sorted parameters that share their spans.
pub(crate) struct Group<'a, const D: usize> {
    /// What the parameters of the group have in common.
    pub(crate) key: usize,
    /// Index of each parameter in the chunk.
    pub(crate) order: &'a [u32],
    /// The parameters, from the first one of this group on; at least [`MAX_LANES`] more follow it.
    pub(crate) parameters: [&'a [f64]; D],
}

impl<const D: usize> Default for Groups<D> {
    fn default() -> Self {
        Self { keys: Vec::new(), order: Vec::new(), places: Vec::new(), sorted: [const { Vec::new() }; D] }
    }
}

impl<const D: usize> Groups<D> {
    /// Takes a chunk. `numbers` is a parameter as it is to be evaluated (wrapped), `key`
    /// what its group has in common, below `key_count`.
    pub(crate) fn fill<P: Copy>(
        &mut self,
        key_count: usize,
        params: &[P],
        numbers: impl Fn(P) -> [f64; D],
        key: impl Fn([f64; D]) -> usize,
    ) {
        let count = params.len();
        self.keys.clear();
        self.keys.extend(params.iter().map(|&p| key(numbers(p))));
        self.order.clear();
        self.order.extend((0..).zip(&self.keys).map(|(index, _): (u32, _)| index));
        if key_count <= 4 * count {
            self.sort_by_counting(key_count);
        } else {
            self.order.sort_unstable_by_key(|&index| (self.keys[index as usize], index));
        }
        for sorted in &mut self.sorted {
            // What follows the last parameter fills up vectors, and is evaluated for nothing.
            sorted.resize(count + MAX_LANES, 0.0);
        }
        for (place, &index) in self.order.iter().enumerate() {
            let parameter = numbers(params[index as usize]);
            for d in 0..D {
                self.sorted[d][place] = parameter[d];
            }
        }
    }

    fn sort_by_counting(&mut self, key_count: usize) {
        self.places.clear();
        self.places.resize(key_count, 0);
        for &key in &self.keys {
            self.places[key] += 1;
        }
        let mut place = 0;
        for slot in &mut self.places {
            place += std::mem::replace(slot, place);
        }
        for (index, &key) in (0..).zip(&self.keys) {
            self.order[self.places[key]] = index;
            self.places[key] += 1;
        }
    }

    /// The groups, by increasing key.
    pub(crate) fn iter(&self) -> impl Iterator<Item = Group<'_, D>> {
        let mut start = 0;
        std::iter::from_fn(move || {
            let key = self.keys[*self.order.get(start)? as usize];
            let rest = &self.order[start..];
            let length = rest.iter().take_while(|&&index| self.keys[index as usize] == key).count();
            let group = Group {
                key,
                order: &rest[..length],
                parameters: std::array::from_fn(|d| &self.sorted[d][start..]),
            };
            start += length;
            Some(group)
        })
    }
}
