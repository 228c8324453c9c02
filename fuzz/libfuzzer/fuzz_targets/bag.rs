//! A bag of arbitrary bytes through `starbreak_runs::bag`.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| starbreak_fuzz::bag(bytes));
