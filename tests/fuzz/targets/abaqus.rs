#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| -> libfuzzer_sys::Corpus { lattice_brep_fuzz::read("a.inp", lattice_brep_fuzz::Format::Abaqus, bytes) });
