//! Wavefront OBJ: `v x y z` and polylines `l i j k ...`; indices from 1, or from the end if negative. No radii.

use super::draft::Draft;
use super::{join, text};
use std::borrow::Cow;

/// A line starts with a keyword of the format and a value that fits.
pub fn is_like(head: &str) -> bool {
    head.lines().any(|l| {
        let mut words = l.split_whitespace();
        match words.next() {
            Some("v") => words.next().is_some_and(|x| x.parse::<f64>().is_ok()),
            Some("mtllib") => true,
            _ => false,
        }
    })
}

pub fn read(bytes: &[u8], draft: &mut Draft) {
    // a node may be named before it is given: lines wait until all nodes are known
    let mut polylines: Vec<(u32, Cow<str>, u32)> = Vec::new();
    let mut faces = 0;
    for (at, line) in text::lines(bytes) {
        let line = line.split('#').next().map(str::to_owned).map(Cow::Owned).unwrap_or(line);
        let mut words = line.split_whitespace();
        let place = Draft::line(at);
        match words.next() {
            Some("v") => {
                let position = text::point(draft, place, [words.next(), words.next(), words.next()]);
                draft.node(place, position);
            }
            Some("l") => polylines.push((at, line.clone(), draft.node_count())),
            Some("f" | "p" | "curv" | "surf") => faces += 1,
            Some("o") if draft.name.is_none() => draft.name = Some(words.collect::<Vec<_>>().join(" ")).filter(|n| !n.is_empty()),
            _ => {}
        }
        if draft.is_full() {
            return;
        }
    }
    for (at, line, before) in &polylines {
        let place = Draft::line(*at);
        let mut last = None;
        let mut count = 0;
        for word in line.split_whitespace().skip(1) {
            count += 1;
            // `l 1/1 2/2`: the part behind the slash is a texture coordinate
            let index = word.split('/').next().and_then(|w| w.parse::<i64>().ok());
            let index = index.map(|i| if i < 0 { i64::from(*before) + i } else { i - 1 });
            let node = index.and_then(|i| u32::try_from(i).ok()).filter(|n| *n < draft.node_count());
            match node {
                None => draft.fault(place, text::quoted(Some(word)), format!("the number of one of the {} vertices", draft.node_count())),
                Some(node) => {
                    if let Some(last) = last {
                        draft.strut(place, [last, node], None);
                    }
                }
            }
            last = node;
        }
        if count < 2 {
            draft.fault(place, format_args!("a line of {count} vertices"), "two or more");
        }
    }
    if faces > 0 {
        draft.note("document", format!("{faces} faces, points, curves and surfaces: left out, only `l` records are struts"));
    }
    join::ends(draft);
}
