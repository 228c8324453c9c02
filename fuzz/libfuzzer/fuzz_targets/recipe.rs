//! `Recipe::parse` and `Recipe::set` on arbitrary text.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| starbreak_fuzz::recipe(bytes));
