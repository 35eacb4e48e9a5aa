//! Anything that a client may send as a programme: it is refused with an error, or it can be printed, read again and evaluated everywhere.
#![no_main]

mod check_programme;

libfuzzer_sys::fuzz_target!(|data: &[u8]| check_programme::check(data));
