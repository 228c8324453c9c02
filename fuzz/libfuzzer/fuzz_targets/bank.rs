//! `BankFile::open` and its records on arbitrary bytes, their checksums set right.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| starbreak_fuzz::bank(bytes));
