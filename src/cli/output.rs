//! Output that is whole or absent.

use lattice_brep::error::Error;
use std::fs::OpenOptions;
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// The temporary file that is being written.
static UNFINISHED: Mutex<Option<PathBuf>> = Mutex::new(None);

/// Exit code after Ctrl-C, as shells have it.
const INTERRUPTED: i32 = 130;

fn unfinished() -> MutexGuard<'static, Option<PathBuf>> {
    UNFINISHED.lock().unwrap_or_else(PoisonError::into_inner)
}

/// On Ctrl-C, or when asked to end: remove what is unfinished, then end.
pub fn clean_up_on_interrupt() -> Result<(), Error> {
    let handler = || {
        // held until the end, so that no file begins after this
        let mut file = unfinished();
        if let Some(path) = file.take() {
            let _ = std::fs::remove_file(path); // it may just have got its name
        }
        std::process::exit(INTERRUPTED);
    };
    ctrlc::set_handler(handler).map_err(|e| Error::Internal(format!("no handler for Ctrl-C: {e}")))
}

/// Write a file under a temporary name beside its target, then rename it; or, without a path, to standard output.
/// What is there and no file (a device, a pipe) is written to, not replaced.
pub fn write(path: Option<&Path>, fill: impl FnOnce(&mut (dyn Write + Send)) -> io::Result<()>) -> Result<(), Error> {
    match path {
        Some(path) if path.metadata().is_ok_and(|m| !m.is_file()) => write_into(path, fill).map_err(Error::io(path)),
        Some(path) => write_file(path, fill).map_err(Error::io(path)),
        None => write_stdout(fill).map_err(Error::io("standard output")),
    }
}

/// The folder of a path.
fn beside(path: &Path) -> &Path {
    path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// Where temporary files of a run that writes to this path may go: beside it, or where such files usually go if it is no file.
pub fn folder(path: &Path) -> PathBuf {
    if path.metadata().is_ok_and(|m| !m.is_file()) { std::env::temp_dir() } else { beside(path).to_path_buf() }
}

fn write_into(path: &Path, fill: impl FnOnce(&mut (dyn Write + Send)) -> io::Result<()>) -> io::Result<()> {
    let mut out = BufWriter::new(OpenOptions::new().write(true).open(path)?);
    fill(&mut out)?;
    out.flush()
}

fn write_file(path: &Path, fill: impl FnOnce(&mut (dyn Write + Send)) -> io::Result<()>) -> io::Result<()> {
    let folder = beside(path);
    let mut builder = tempfile::Builder::new();
    #[cfg(unix)]
    {
        // As for any new file: what the user's umask leaves of rw-rw-rw-, not the private mode of temporary files.
        use std::os::unix::fs::PermissionsExt;
        builder.permissions(std::fs::Permissions::from_mode(0o666));
    }
    let file = {
        let mut unfinished = unfinished();
        let file = builder.prefix(".lattice-brep-").tempfile_in(folder)?;
        *unfinished = Some(file.path().to_path_buf());
        file
    };
    let mut out = BufWriter::new(file);
    fill(&mut out)?;
    let file = out.into_inner()?;
    let mut unfinished = unfinished();
    file.persist(path)?;
    *unfinished = None;
    Ok(())
}

/// A reader that has seen enough (`| head`) is no failure.
fn write_stdout(fill: impl FnOnce(&mut (dyn Write + Send)) -> io::Result<()>) -> io::Result<()> {
    let mut out = BufWriter::new(io::stdout());
    match fill(&mut out).and_then(|()| out.flush()) {
        Err(e) if e.kind() == io::ErrorKind::BrokenPipe => Ok(()),
        other => other,
    }
}
