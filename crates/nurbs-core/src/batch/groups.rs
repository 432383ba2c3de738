//! Parameters sorted by the span that they lie in.

use crate::KnotVector;
use crate::simd::MAX_LANES;

/// The parameters of one chunk, `D` numbers each, in groups.
pub(crate) struct Groups<const D: usize> {
    /// By parameter.
    keys: Vec<u32>,
    /// By key: how many parameters have it, then the next free place for one of them.
    places: Vec<u32>,
    /// Keys and indices of the parameters, where there are too many keys to count them all.
    pairs: Vec<(u32, u32)>,
    /// Key and place of the first parameter of each group; one more entry for the end.
    starts: Vec<(u32, u32)>,
    /// Where each sorted parameter came from.
    order: Vec<u32>,
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
            places: Vec::new(),
            pairs: Vec::new(),
            starts: Vec::new(),
            order: Vec::new(),
            sorted: [const { Vec::new() }; D],
        }
    }
}

/// An index of a parameter or a control point.
#[expect(
    clippy::cast_possible_truncation,
    reason = "chunks are short, and larger nets are not evaluated in lanes"
)]
#[inline(always)]
fn narrow(index: usize) -> u32 {
    index as u32
}

impl<const D: usize> Groups<D> {
    /// Takes a chunk of parameters, wrapped, and groups them by their spans.
    pub(crate) fn fill(&mut self, knots: [&KnotVector; D], params: &[[f64; D]]) {
        let count = params.len();
        self.keys.clear();
        self.keys.resize(count, 0);
        for d in 0..D {
            self.add_spans(knots[d], params.iter().map(|p| p[d]));
        }
        self.order.resize(count, 0);
        self.starts.clear();
        let key_count = knots.iter().map(|k| k.basis_count()).product();
        if key_count <= 4 * count {
            self.sort_by_counting(key_count);
        } else {
            self.sort_pairs();
        }
        self.starts.push((0, narrow(count)));
        for sorted in &mut self.sorted {
            // What follows the last parameter fills up vectors, and is evaluated for nothing.
            sorted.resize(count + MAX_LANES, 0.0);
        }
        for (place, &index) in self.order.iter().enumerate() {
            let parameter = params[index as usize];
            for d in 0..D {
                self.sorted[d][place] = parameter[d];
            }
        }
    }

    /// Appends the spans of one direction to the keys, as the next digit of a number.
    fn add_spans(&mut self, knots: &KnotVector, params: impl Iterator<Item = f64> + Clone) {
        let base = narrow(knots.basis_count());
        let mut searches = 0;
        for (key, t) in self.keys.iter_mut().zip(params.clone()) {
            let span = knots.span_without_search(t);
            *key = *key * base + narrow(span.unwrap_or_default());
            searches += usize::from(span.is_none());
        }
        if searches == 0 {
            return;
        }
        // Rare, and apart from the others, which a call between them would slow down.
        for (key, t) in self.keys.iter_mut().zip(params) {
            if knots.span_without_search(t).is_none() {
                *key += narrow(knots.span(t));
            }
        }
    }

    fn sort_by_counting(&mut self, key_count: usize) {
        self.places.clear();
        self.places.resize(key_count, 0);
        for &key in &self.keys {
            self.places[key as usize] += 1;
        }
        self.start_groups();
        for (&key, index) in self.keys.iter().zip(0..) {
            let place = &mut self.places[key as usize];
            self.order[*place as usize] = index;
            *place += 1;
        }
    }

    fn sort_pairs(&mut self) {
        self.pairs.clear();
        self.pairs.extend(self.keys.iter().copied().zip(0..));
        self.pairs.sort_unstable();
        for ((order, &(key, index)), place) in self.order.iter_mut().zip(&self.pairs).zip(0..) {
            *order = index;
            if self.starts.last().is_none_or(|&(last, _)| last != key) {
                self.starts.push((key, place));
            }
        }
    }

    /// From the number of parameters with each key to where they start.
    fn start_groups(&mut self) {
        let mut place = 0;
        for (slot, key) in self.places.iter_mut().zip(0..) {
            let count = std::mem::replace(slot, place);
            if count > 0 {
                self.starts.push((key, place));
                place += count;
            }
        }
    }

    /// The groups, by increasing key.
    pub(crate) fn iter(&self) -> impl Iterator<Item = Group<'_, D>> {
        self.starts.windows(2).map(|pair| {
            let ((key, start), (_, end)) = (pair[0], pair[1]);
            let start = start as usize;
            Group {
                key: key as usize,
                order: &self.order[start..end as usize],
                parameters: std::array::from_fn(|d| &self.sorted[d][start..]),
            }
        })
    }
}
