//! Output that is whole or absent.

use lattice_brep::error::Error;
use std::fs::OpenOptions;
use std::io::{self, BufWriter, Write};
use std::path::Path;

/// Write a file under a temporary name beside its target, then rename it; or, without a path, to standard output.
/// What is there and no file (a device, a pipe) is written to, not replaced.
pub fn write(path: Option<&Path>, fill: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> Result<(), Error> {
    match path {
        Some(path) if path.metadata().is_ok_and(|m| !m.is_file()) => write_into(path, fill).map_err(Error::io(path)),
        Some(path) => write_file(path, fill).map_err(Error::io(path)),
        None => write_stdout(fill).map_err(Error::io("standard output")),
    }
}

fn write_into(path: &Path, fill: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> io::Result<()> {
    let mut out = BufWriter::new(OpenOptions::new().write(true).open(path)?);
    fill(&mut out)?;
    out.flush()
}

fn write_file(path: &Path, fill: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> io::Result<()> {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let mut builder = tempfile::Builder::new();
    #[cfg(unix)]
    {
        // As for any new file: what the user's umask leaves of rw-rw-rw-, not the private mode of temporary files.
        use std::os::unix::fs::PermissionsExt;
        builder.permissions(std::fs::Permissions::from_mode(0o666));
    }
    let mut out = BufWriter::new(builder.prefix(".lattice-brep-").tempfile_in(folder)?);
    fill(&mut out)?;
    out.into_inner()?.persist(path)?;
    Ok(())
}

/// A reader that has seen enough (`| head`) is no failure.
fn write_stdout(fill: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> io::Result<()> {
    let mut out = BufWriter::new(io::stdout().lock());
    match fill(&mut out).and_then(|()| out.flush()) {
        Err(e) if e.kind() == io::ErrorKind::BrokenPipe => Ok(()),
        other => other,
    }
}
