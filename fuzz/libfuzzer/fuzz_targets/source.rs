//! `Source::open` on a folder with arbitrary labels or an arbitrary index.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| starbreak_fuzz::source(bytes));
