//! All integration tests of `inspection` in one binary: linking once is most of what building them costs.

mod merging;
mod proof;
mod shapes;
