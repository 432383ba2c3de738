//! Arbitrary bytes, read as a table of points.
#![no_main]

use libfuzzer_sys::fuzz_target;

fuzz_target!(|data: &[u8]| fuzz_targets::xyz(data));
