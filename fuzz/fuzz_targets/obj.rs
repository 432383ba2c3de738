//! Arbitrary bytes, read as OBJ.
#![no_main]

use libfuzzer_sys::fuzz_target;

fuzz_target!(|data: &[u8]| fuzz_targets::obj(data));
