//! Any request that writes nothing: it is answered, and refused with a reason if it is.
#![no_main]

mod check_request;

libfuzzer_sys::fuzz_target!(|data: &[u8]| check_request::check(data));
