//! Any file that is said to be a part of an export: it is refused, or its tiles can be read and joined if all are there.
#![no_main]

mod check_part;

libfuzzer_sys::fuzz_target!(|data: &[u8]| check_part::check(data));
