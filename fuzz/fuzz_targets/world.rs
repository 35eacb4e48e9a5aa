//! Anything that a client may send as a document: every problem is told, or it can be written, read again and evaluated.
#![no_main]

mod check_world;

libfuzzer_sys::fuzz_target!(|data: &[u8]| check_world::check(data));
