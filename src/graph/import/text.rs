//! Lines, numbers and messages of the text formats.

use super::draft::{Draft, Place};
use super::limits;
use std::borrow::Cow;
use std::fmt::Display;

/// The lines with their numbers from 1, without line ends. Bytes that are not UTF-8 become U+FFFD, which no number holds.
pub fn lines(bytes: &[u8]) -> impl Iterator<Item = (u32, Cow<'_, str>)> {
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    let line = |l: &'_ [u8]| -> usize { l.len() - usize::from(l.ends_with(b"\r")) };
    bytes.split(|&b| b == b'\n').zip(1u32..).map(move |(l, k)| (k, String::from_utf8_lossy(&l[..line(l)])))
}

/// The first bytes as text, cut at the last line end, to find the format by.
pub fn head(bytes: &[u8]) -> Cow<'_, str> {
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    let head = &bytes[..bytes.len().min(limits::SNIFFED)];
    let whole = match head.iter().rposition(|&b| b == b'\n') {
        Some(end) if head.len() < bytes.len() => &head[..end],
        _ => head,
    };
    String::from_utf8_lossy(whole)
}

/// A piece of the source as it can be shown: control characters escaped, at most `limits::SHOWN` characters.
pub fn shown(piece: &str) -> String {
    let mut escaped: String =
        piece.chars().take(limits::SHOWN).flat_map(|c| if c == '"' || c == '\'' { vec![c] } else { c.escape_debug().collect() }).collect();
    if piece.chars().nth(limits::SHOWN).is_some() {
        escaped += "...";
    }
    escaped
}

/// A finite number, blanks around it allowed.
pub fn number(piece: &str) -> Option<f64> {
    piece.trim().parse().ok().filter(|x: &f64| x.is_finite())
}

/// What unreadable content is, as far as a look at its first bytes tells.
pub fn looks_like(bytes: &[u8]) -> &'static str {
    const KNOWN: [(&[u8], &str); 7] = [
        (b"ISO-10303-21", "a STEP file"),
        (b"solid ", "an STL file: a surface, no struts"),
        (b"ply", "a PLY file"),
        (b"\x1f\x8b", "a file packed by gzip: unpack it first"),
        (b"\xff\xfe", "text in UTF-16: save it as UTF-8"),
        (b"\xfe\xff", "text in UTF-16: save it as UTF-8"),
        (b"PK", "a zip archive that holds no 3MF model"),
    ];
    if bytes.is_empty() {
        return "an empty file";
    }
    KNOWN.iter().find(|(start, _)| bytes.starts_with(start)).map_or("content of no known format", |(_, what)| what)
}

/// Three lengths of the source as a point; `None` with a fault for each that is not a finite number.
pub fn point<'t>(draft: &mut Draft, place: Place, pieces: impl IntoIterator<Item = Option<&'t str>>) -> Option<[f64; 3]> {
    let mut out = [0.0; 3];
    let mut sound = true;
    for ((x, piece), axis) in out.iter_mut().zip(pieces).zip(["x", "y", "z"]) {
        match piece.and_then(number) {
            Some(value) => *x = value,
            None => {
                sound = false;
                draft.fault(place, format_args!("{} as {axis}", quoted(piece)), "a finite number");
            }
        }
    }
    sound.then_some(out)
}

/// The piece in quotes as it can be shown, or `nothing`.
pub fn quoted(piece: Option<&str>) -> impl Display {
    match piece {
        Some(piece) if !piece.trim().is_empty() => format!("`{}`", shown(piece.trim())),
        _ => "nothing".to_owned(),
    }
}

/// Radii at both ends from what the source gives: none, one for both, or two. `Err` where a fault was told.
pub fn radii(draft: &mut Draft, place: Place, ra: Option<&str>, rb: Option<&str>) -> Result<Option<[f64; 2]>, ()> {
    let mut radius = |piece: &str| {
        let read = number(piece).filter(|r| *r > 0.0);
        if read.is_none() {
            draft.fault(place, format_args!("{} as radius", quoted(Some(piece))), "a radius > 0");
        }
        read.ok_or(())
    };
    match (ra.map(&mut radius), rb.map(&mut radius)) {
        (None, None) => Ok(None),
        (Some(ra), None) => ra.map(|r| Some([r; 2])),
        (ra, Some(rb)) => Ok(Some([ra.unwrap_or(rb)?, rb?])),
    }
}
