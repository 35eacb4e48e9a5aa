//! Any configuration: every problem is told, or all values are in their ranges.
#![no_main]

mod check_config;

libfuzzer_sys::fuzz_target!(|data: &[u8]| check_config::check(data));
