//! `decode_image` and `decode_array` on arbitrary bytes.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| starbreak_fuzz::image(bytes));
