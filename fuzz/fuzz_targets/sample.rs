//! Any bytes as a sample of elevations, in any format: read soundly or refused with a place.
#![no_main]

mod check_sample;

libfuzzer_sys::fuzz_target!(|data: &[u8]| check_sample::check(data));
