//! Parameters sorted by the span that they lie in.

use crate::simd::MAX_LANES;

/// The parameters of one chunk, `D` numbers each, in groups.
pub(crate) struct Groups<const D: usize> {
    /// By parameter, and in the order of the groups.
    keys: Vec<usize>,
    sorted_keys: Vec<usize>,
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
        Self {
            keys: Vec::new(),
            sorted_keys: Vec::new(),
            order: Vec::new(),
            places: Vec::new(),
            sorted: [const { Vec::new() }; D],
        }
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
        self.order.resize(count, 0);
        self.sorted_keys.resize(count, 0);
        for sorted in &mut self.sorted {
            // What follows the last parameter fills up vectors, and is evaluated for nothing.
            sorted.resize(count + MAX_LANES, 0.0);
        }
        if key_count <= 4 * count {
            self.count_keys(key_count);
            for (index, &p) in params.iter().enumerate() {
                let slot = &mut self.places[self.keys[index]];
                let place = *slot;
                *slot += 1;
                self.put(place, index, numbers(p));
            }
        } else {
            let mut order: Vec<usize> = (0..count).collect();
            order.sort_unstable_by_key(|&index| (self.keys[index], index));
            for (place, &index) in order.iter().enumerate() {
                self.put(place, index, numbers(params[index]));
            }
        }
    }

    /// Writes a parameter to its place in the sorted order.
    #[inline(always)]
    fn put(&mut self, place: usize, index: usize, parameter: [f64; D]) {
        self.order[place] = u32::try_from(index).unwrap_or(u32::MAX);
        self.sorted_keys[place] = self.keys[index];
        for d in 0..D {
            self.sorted[d][place] = parameter[d];
        }
    }

    /// Prepares the counting sort.
    fn count_keys(&mut self, key_count: usize) {
        self.places.clear();
        self.places.resize(key_count, 0);
        for &key in &self.keys {
            self.places[key] += 1;
        }
        let mut place = 0;
        for slot in &mut self.places {
            place += std::mem::replace(slot, place);
        }
    }

    /// The groups, by increasing key.
    pub(crate) fn iter(&self) -> impl Iterator<Item = Group<'_, D>> {
        let mut start = 0;
        std::iter::from_fn(move || {
            let keys = self.sorted_keys.get(start..)?;
            let key = *keys.first()?;
            let length = keys.iter().take_while(|&&other| other == key).count();
            let group = Group {
                key,
                order: &self.order[start..][..length],
                parameters: std::array::from_fn(|d| &self.sorted[d][start..]),
            };
            start += length;
            Some(group)
        })
    }
}
