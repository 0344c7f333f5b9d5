#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| -> libfuzzer_sys::Corpus { lattice_brep_fuzz::read("a.csv", lattice_brep_fuzz::Format::Csv, bytes) });
