//! Arbitrary bytes, read as NURBS JSON.
#![no_main]

use libfuzzer_sys::fuzz_target;

fuzz_target!(|data: &[u8]| fuzz_targets::json(data));
