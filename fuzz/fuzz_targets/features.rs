//! Anything that a client may send as features: every problem is told, or they can be written, read again and evaluated.
#![no_main]

mod check_features;

libfuzzer_sys::fuzz_target!(|data: &[u8]| check_features::check(data));
