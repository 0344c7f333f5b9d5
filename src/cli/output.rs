//! Output that is whole or absent.

use lattice_brep::error::Error;
use std::fs::OpenOptions;
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};
use tempfile::NamedTempFile;

/// The temporary files that have not got their names.
static UNFINISHED: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

/// Exit code after Ctrl-C, as shells have it.
const INTERRUPTED: i32 = 130;

fn unfinished() -> MutexGuard<'static, Vec<PathBuf>> {
    UNFINISHED.lock().unwrap_or_else(PoisonError::into_inner)
}

/// On Ctrl-C, or when asked to end: remove what is unfinished, then end.
pub fn clean_up_on_interrupt() -> Result<(), Error> {
    let handler = || {
        // held until the end, so that no file begins or gets its name after this
        let mut files = unfinished();
        for path in files.drain(..) {
            let _ = std::fs::remove_file(path); // it may be gone already
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
    let (file, ()) = write_temporary(beside(path), fill)?;
    name_all(vec![(file, path.to_path_buf())]).map_err(|(_, e)| e)
}

fn write_temporary<T>(folder: &Path, fill: impl FnOnce(&mut (dyn Write + Send)) -> io::Result<T>) -> io::Result<(NamedTempFile, T)> {
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
        unfinished.push(file.path().to_path_buf());
        file
    };
    let mut out = BufWriter::new(file);
    let told = fill(&mut out)?;
    Ok((out.into_inner()?, told))
}

/// Give all temporary files their names, in this order; an interrupt waits. After a failure no file has its name.
fn name_all(files: Vec<(NamedTempFile, PathBuf)>) -> Result<(), (PathBuf, io::Error)> {
    let mut unfinished = unfinished();
    let mut named: Vec<PathBuf> = vec![];
    for (file, path) in files {
        let temporary = file.path().to_path_buf();
        if let Err(e) = file.persist(&path) {
            named.iter().for_each(|path| drop(std::fs::remove_file(path)));
            return Err((path, e.error));
        }
        unfinished.retain(|p| *p != temporary);
        named.push(path);
    }
    Ok(())
}

/// Refuse what is there and no file: a folder, a device, a pipe.
pub fn must_be_file(path: &Path) -> Result<(), Error> {
    if path.metadata().is_ok_and(|m| !m.is_file()) { Err(Error::io(path)(io::Error::other("is there already, and is no file"))) } else { Ok(()) }
}

/// Files that belong together: they get their names when all are whole, or never.
#[derive(Default)]
pub struct Together(Vec<(NamedTempFile, PathBuf)>);

impl Together {
    pub fn write<T>(&mut self, path: &Path, fill: impl FnOnce(&mut (dyn Write + Send)) -> io::Result<T>) -> Result<T, Error> {
        let (file, told) = write_temporary(beside(path), fill).map_err(Error::io(path))?;
        self.0.push((file, path.to_path_buf()));
        Ok(told)
    }

    /// These, then others.
    pub fn and(mut self, others: Together) -> Together {
        self.0.extend(others.0);
        self
    }

    /// The last one written gets its name last.
    pub fn finish(self) -> Result<(), Error> {
        name_all(self.0).map_err(|(path, e)| Error::io(path)(e))
    }
}

/// A reader that has seen enough (`| head`) is no failure.
fn write_stdout(fill: impl FnOnce(&mut (dyn Write + Send)) -> io::Result<()>) -> io::Result<()> {
    let mut out = BufWriter::new(io::stdout());
    match fill(&mut out).and_then(|()| out.flush()) {
        Err(e) if e.kind() == io::ErrorKind::BrokenPipe => Ok(()),
        other => other,
    }
}
