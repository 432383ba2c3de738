//! Arbitrary bytes, read as PTX.
#![no_main]

use libfuzzer_sys::fuzz_target;
use pc_io::Format;

fuzz_target!(|data: &[u8]| pc_io_fuzz::read_as(data, Format::Ptx));
