//! A message of a camera of arbitrary bytes.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| starbreak_fuzz::message(bytes));
