//! Any request that writes nothing: it is answered, and refused with a reason if it is.
#![no_main]

mod check_request;

// Starting takes longer than any request may.
libfuzzer_sys::fuzz_target!(init: check_request::start(), |data: &[u8]| {
    check_request::check(data);
});
