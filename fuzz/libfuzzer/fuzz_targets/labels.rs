//! Readers of labels and detections on arbitrary bytes.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| starbreak_fuzz::labels(bytes));
