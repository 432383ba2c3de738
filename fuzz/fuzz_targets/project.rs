//! Points projected onto the shapes of arbitrary NURBS JSON.
#![no_main]

use libfuzzer_sys::fuzz_target;

fuzz_target!(|data: &[u8]| fuzz_targets::project(data));
