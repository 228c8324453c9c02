//! Readers of tracks and of labels with tracks on arbitrary bytes.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| starbreak_fuzz::timeline(bytes));
