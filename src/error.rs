//! What can go wrong, and the one table of exit codes.

use schemars::JsonSchema;
use serde::Serialize;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

/// One fault of the input: where it is, what was found there, what was wanted.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, JsonSchema, thiserror::Error)]
#[error("{path}: found {found}, wanted {wanted}")]
pub struct Fault {
    /// Path into the input, such as `struts[17].ra`; `document` is the input as a whole.
    pub path: String,
    pub found: String,
    pub wanted: String,
    /// Two struts that come too close: smaller radii, or a common node, may mend it.
    #[serde(skip)]
    pub is_overlap: bool,
}

impl Fault {
    pub fn new(path: impl Into<String>, found: impl Into<String>, wanted: impl Into<String>) -> Self {
        Fault { path: path.into(), found: found.into(), wanted: wanted.into(), is_overlap: false }
    }
}

/// A note for the report: what was left out of the input, or changed in it, without refusing it.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, JsonSchema, thiserror::Error)]
#[error("{path}: {what}")]
pub struct Note {
    /// Path into the input, such as `nodes[7]`.
    pub path: String,
    /// What was found there and done about it.
    pub what: String,
}

impl Note {
    pub fn new(path: impl Into<String>, what: impl Into<String>) -> Self {
        Note { path: path.into(), what: what.into() }
    }
}

/// Everything the library can answer instead of a result.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The input is refused; all its faults.
    #[error("{}", listed("fault", "in the input", .0, usize::MAX))]
    BadInput(Vec<Fault>),
    /// The input is sound, yet no solid can be made of it; all the reasons.
    #[error("{}", listed("reason", "why this cannot be built", .reasons, usize::MAX))]
    CannotBuild { reasons: Vec<String> },
    /// A file could not be read or written.
    #[error("{}: {source}", path.display())]
    Io { path: PathBuf, source: std::io::Error },
    /// Our own failure: a check of our own work did not pass.
    #[error("internal failure: {0}")]
    Internal(String),
}

impl Error {
    /// For `map_err` on anything done to a file.
    pub fn io(path: impl AsRef<Path>) -> impl FnOnce(std::io::Error) -> Error {
        let path = path.as_ref().to_owned();
        move |source| Error::Io { path, source }
    }

    /// `Ok` when there is no fault.
    pub fn unless_empty(faults: Vec<Fault>) -> Result<(), Error> {
        if faults.is_empty() { Ok(()) } else { Err(Error::BadInput(faults)) }
    }

    /// The process exit code: the one table (0 is success).
    pub fn exit_code(&self) -> i32 {
        match self {
            Error::BadInput(_) => 2,
            Error::CannotBuild { .. } => 3,
            Error::Io { .. } | Error::Internal(_) => 1,
        }
    }

    /// As `Display`, but with at most so many lines of faults or reasons, and a count of the rest.
    pub fn brief(&self, at_most: usize) -> String {
        match self {
            Error::BadInput(faults) => listed("fault", "in the input", faults, at_most),
            Error::CannotBuild { reasons } => listed("reason", "why this cannot be built", reasons, at_most),
            Error::Io { .. } | Error::Internal(_) => self.to_string(),
        }
    }
}

/// A headline with the count, then one item a line.
fn listed<T: std::fmt::Display>(noun: &str, about: &str, items: &[T], at_most: usize) -> String {
    let plural = if items.len() == 1 { "" } else { "s" };
    let mut text = format!("{} {noun}{plural} {about}:", items.len());
    for item in items.iter().take(at_most) {
        let _ = write!(text, "\n  {item}");
    }
    if items.len() > at_most {
        let _ = write!(text, "\n  ... and {} more", items.len() - at_most);
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_table_of_exit_codes() {
        let io = std::io::Error::other("disk full");
        assert_eq!(Error::BadInput(vec![]).exit_code(), 2);
        assert_eq!(Error::CannotBuild { reasons: vec![] }.exit_code(), 3);
        assert_eq!(Error::io("out.step")(io).exit_code(), 1);
        assert_eq!(Error::Internal("edge used once".into()).exit_code(), 1);
    }

    #[test]
    fn all_faults_are_listed_one_a_line_and_brief_counts_the_rest() {
        let fault = |k: usize| Fault::new(format!("struts[{k}].ra"), "-1", "a radius > 0");
        let error = Error::BadInput((0..3).map(fault).collect());
        let all = "3 faults in the input:\n  struts[0].ra: found -1, wanted a radius > 0\n  \
                   struts[1].ra: found -1, wanted a radius > 0\n  struts[2].ra: found -1, wanted a radius > 0";
        assert_eq!(error.to_string(), all);
        assert_eq!(error.brief(1), "3 faults in the input:\n  struts[0].ra: found -1, wanted a radius > 0\n  ... and 2 more");
        assert_eq!(error.brief(3), all);
    }
}
