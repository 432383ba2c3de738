//! Work on many things at once (the only file that knows `rayon`).

use rayon::prelude::*;

/// The results for all items, in their order.
pub(crate) fn map<I: Sync, T: Send>(items: &[I], f: impl Fn(&I) -> T + Sync + Send) -> Vec<T> {
    items.par_iter().map(f).collect()
}
