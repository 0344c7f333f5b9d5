//! Compressed STEP: a ZIP archive with the file as its only entry, as the CAx-IF recommended practice for STEP file compression (1.2) has it.

use std::io::{self, BufReader, Read, Seek, Write};
use std::path::Path;
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipArchive, ZipWriter};

/// Whether a path names a compressed file: it ends with `.stpZ`, in any case.
pub fn is_named(path: &Path) -> bool {
    path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("stpz"))
}

/// Write an archive of one file. Its bytes depend on the file's alone: there is no clock in it.
pub fn pack(name: &str, out: &mut (dyn Write + Send), fill: impl FnOnce(&mut (dyn Write + Send)) -> io::Result<()>) -> io::Result<()> {
    let mut archive = ZipWriter::new_stream(out);
    // sizes of 8 bytes: how much there is shows when it is written
    archive.start_file(name, SimpleFileOptions::default().compression_method(CompressionMethod::Deflated).large_file(true))?;
    fill(&mut archive)?;
    archive.finish()?;
    Ok(())
}

/// Hand a file's text to `read`, unpacked if it is an archive.
pub fn unpack<T>(mut file: impl Read + Seek, read: impl FnOnce(&mut dyn io::BufRead) -> T) -> io::Result<T> {
    let mut start = [0; 4];
    let is_archive = file.read_exact(&mut start).is_ok() && start == *b"PK\x03\x04";
    file.rewind()?;
    if !is_archive {
        return Ok(read(&mut BufReader::with_capacity(1 << 16, file)));
    }
    let mut archive = ZipArchive::new(file)?;
    let entry = archive.by_index(0)?;
    Ok(read(&mut BufReader::with_capacity(1 << 16, entry)))
}
