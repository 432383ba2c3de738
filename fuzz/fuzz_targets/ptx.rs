//! Arbitrary bytes, read as PTX.
#![no_main]

use libfuzzer_sys::fuzz_target;

fuzz_target!(|data: &[u8]| fuzz_targets::ptx(data));
