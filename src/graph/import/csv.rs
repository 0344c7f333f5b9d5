//! CSV pairs: a strut a line, `x0,y0,z0,x1,y1,z1[,r0[,r1]]`; one radius is that of both ends.
//!
//! Fields are parted by commas, semicolons, tabs or blanks, whichever the first line of numbers has. A first line of names is
//! passed over, lines that start with `#` too.

use super::draft::Draft;
use super::{join, text};
use std::borrow::Cow;

/// A line within the first few has six numbers or more.
pub fn is_like(head: &str) -> bool {
    let mut data = head.lines().map(str::trim).filter(|l| !l.is_empty() && !l.starts_with('#'));
    let is_pair = |l: &str| {
        let fields: Vec<&str> = fields(l, separator(l)).collect();
        (6..=8).contains(&fields.len()) && fields.iter().all(|f| f.trim().parse::<f64>().is_ok())
    };
    data.next().is_some_and(is_pair) || data.next().is_some_and(is_pair)
}

fn separator(line: &str) -> char {
    [';', ',', '\t'].into_iter().find(|&c| line.contains(c)).unwrap_or(' ')
}

fn fields(line: &str, separator: char) -> impl Iterator<Item = &str> {
    // blanks in a row are one separator, commas in a row are empty fields
    line.split(separator).filter(move |f| separator != ' ' || !f.is_empty()).map(|f| f.trim().trim_matches('"'))
}

pub fn read(bytes: &[u8], draft: &mut Draft) {
    let is_data = |(_, l): &(u32, Cow<str>)| !l.trim().is_empty() && !l.trim_start().starts_with('#');
    let mut is_first = true;
    for (at, line) in text::lines(bytes).filter(is_data) {
        let place = Draft::line(at);
        let fields: Vec<&str> = fields(line.trim(), separator(line.trim())).take(10).collect();
        let is_header = is_first && fields.iter().all(|f| f.parse::<f64>().is_err());
        is_first = false;
        if is_header {
            if let Some(name) = fields.iter().skip(6).find(|f| f.to_ascii_lowercase().starts_with('d')) {
                draft.fault(place, format_args!("a column named {}", text::quoted(Some(name))), "radii, not diameters");
            }
            continue;
        }
        if !(6..=8).contains(&fields.len()) {
            let count = if fields.len() > 9 { "more than 9".to_owned() } else { fields.len().to_string() };
            draft.fault(place, format_args!("{count} values"), "6 to 8: x0,y0,z0,x1,y1,z1[,r0[,r1]]");
            continue;
        }
        let p = text::point(draft, place, fields[..3].iter().copied().map(Some));
        let q = text::point(draft, place, fields[3..6].iter().copied().map(Some));
        // an empty field is a radius that is not given
        let given: Vec<&str> = fields[6..].iter().copied().filter(|f| !f.is_empty()).collect();
        let radii = text::radii(draft, place, given.first().copied(), given.get(1).copied());
        let ends = [draft.node(place, p), draft.node(place, q)];
        if let Ok(radii) = radii {
            draft.strut(place, ends, radii);
        }
        if draft.is_full() {
            break;
        }
    }
    join::ends(draft);
}
