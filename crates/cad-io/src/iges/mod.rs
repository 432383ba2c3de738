//! IGES files (5.3, fixed format ASCII).
//!
//! A file is lines of 80 columns in five sections ([`records`]). The directory ([`directory`]) has one entry for each
//! entity, with a pointer to its parameter data ([`file`]), which are free format values ([`tokens`]). Entities name each
//! other by their directory numbers; what no other entity names is a face, a solid or a curve of the model ([`read`]).

mod analytic;
mod chart;
mod conic;
mod curves;
mod directory;
mod fault;
mod file;
mod global;
mod motion;
mod power;
mod read;
mod records;
mod revolution;
mod ruled;
mod solids;
mod surfaces;
mod tokens;
mod trims;
mod write;

pub use read::{read_iges, read_iges_file};
pub use records::is_iges;
pub use write::to_iges;
