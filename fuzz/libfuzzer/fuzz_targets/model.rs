//! Contracts, maps of labels and facts of ONNX models on arbitrary bytes.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| starbreak_fuzz::model(bytes));
