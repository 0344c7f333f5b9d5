//! The import rule of `docs/architecture.md`: data flows one way. The table there is read, so page and code cannot part.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

/// Files of `src/` that belong to no layer: they only list the modules.
const LISTS: [&str; 2] = ["lib", "main"];

fn root() -> PathBuf {
    PathBuf::from(std::env::var("CARGO_MANIFEST_DIR").expect("cargo sets it"))
}

/// What each layer may name, from the table of the page.
fn table() -> BTreeMap<String, BTreeSet<String>> {
    let page = fs::read_to_string(root().join("docs/architecture.md")).unwrap();
    let ticked = |cell: &str| -> BTreeSet<String> { cell.split('`').skip(1).step_by(2).map(str::to_owned).collect() };
    let mut rows = page.lines().skip_while(|l| !l.starts_with("| layer |")).skip(2).take_while(|l| l.starts_with('|'));
    let mut out = BTreeMap::new();
    for row in &mut rows {
        let cells: Vec<&str> = row.trim_matches('|').split('|').collect();
        assert_eq!(cells.len(), 4, "a row of the table: {row}");
        let [layer] = ticked(cells[0]).into_iter().collect::<Vec<_>>().try_into().expect("one layer a row");
        out.insert(layer, ticked(cells[2]));
    }
    out
}

/// All Rust files of `src/`, with the layer each belongs to: the first part of its path.
fn sources() -> Vec<(String, PathBuf)> {
    fn walk(folder: &Path, out: &mut Vec<PathBuf>) {
        let mut entries: Vec<PathBuf> = fs::read_dir(folder).unwrap().map(|e| e.unwrap().path()).collect();
        entries.sort();
        for path in entries {
            if path.is_dir() {
                walk(&path, out);
            } else if path.extension().is_some_and(|e| e == "rs") {
                out.push(path);
            }
        }
    }
    let src = root().join("src");
    let mut files = Vec::new();
    walk(&src, &mut files);
    let layer = |path: &Path| {
        let first = path.strip_prefix(&src).unwrap().iter().next().unwrap().to_str().unwrap().to_owned();
        first.trim_end_matches(".rs").to_owned()
    };
    files.into_iter().map(|path| (layer(&path), path)).collect()
}

/// The code without comments and without the contents of strings.
fn code(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    let mut rest = text;
    while let Some(c) = rest.chars().next() {
        let skipped = if rest.starts_with("//") {
            rest.find('\n').unwrap_or(rest.len())
        } else if rest.starts_with("/*") {
            rest.find("*/").map_or(rest.len(), |end| end + 2)
        } else if rest.starts_with("'\"'") {
            3
        } else if c == '"' {
            let mut end = 1;
            while end < rest.len() && rest.as_bytes()[end] != b'"' {
                end += if rest.as_bytes()[end] == b'\\' { 2 } else { 1 };
            }
            (end + 1).min(rest.len())
        } else {
            out.push(c);
            c.len_utf8()
        };
        rest = &rest[skipped..];
    }
    out
}

/// The first name of each path that starts with `start` (`crate::`), also in `use crate::{a::b, c}`.
fn named(code: &str, start: &str) -> BTreeSet<String> {
    let mut out = BTreeSet::new();
    let name = |text: &str| text.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect::<String>();
    for (at, _) in code.match_indices(start) {
        // `$crate::` and `xcrate::` are something else
        if code[..at].ends_with(|c: char| c.is_alphanumeric() || c == '_' || c == '$') {
            continue;
        }
        let rest = &code[at + start.len()..];
        let Some(group) = rest.strip_prefix('{') else {
            out.insert(name(rest));
            continue;
        };
        let mut depth = 0;
        let mut item = String::new();
        for c in group.chars() {
            match c {
                '{' => depth += 1,
                '}' if depth == 0 => break,
                '}' => depth -= 1,
                ',' if depth == 0 => {
                    out.insert(name(item.trim()));
                    item.clear();
                    continue;
                }
                _ => {}
            }
            item.push(c);
        }
        out.insert(name(item.trim()));
    }
    out.remove("");
    out
}

/// What a file names against the rule: `allowed` and its own layer apart.
fn faults(layer: &str, allowed: &BTreeSet<String>, layers: &BTreeSet<String>, text: &str) -> Vec<String> {
    let code = code(text);
    let mut names = named(&code, "crate::");
    names.extend(named(&code, "lattice_brep::"));
    // `super::super::x` from a file of a layer leaves the layer
    names.extend(named(&code, "super::super::").into_iter().filter(|n| layers.contains(n)));
    names.into_iter().filter(|n| n != layer && !allowed.contains(n)).map(|n| format!("`{layer}` names `{n}`")).collect()
}

#[test]
fn no_import_against_the_flow() {
    let table = table();
    let layers: BTreeSet<String> = table.keys().cloned().collect();
    let mut found = Vec::new();
    for (layer, path) in sources() {
        if LISTS.contains(&layer.as_str()) {
            continue;
        }
        let Some(allowed) = table.get(&layer) else {
            found.push(format!("{}: `{layer}` is not in the table", path.display()));
            continue;
        };
        let text = fs::read_to_string(&path).unwrap();
        found.extend(faults(&layer, allowed, &layers, &text).into_iter().map(|f| format!("{}: {f}", path.display())));
    }
    assert!(found.is_empty(), "against docs/architecture.md:\n{}", found.join("\n"));
}

#[test]
fn the_table_has_no_ring_and_no_row_without_code() {
    let table = table();
    let present: BTreeSet<String> = sources().into_iter().map(|s| s.0).collect();
    for (layer, allowed) in &table {
        assert!(present.contains(layer), "`{layer}` is in the table, not in src/");
        assert!(allowed.iter().all(|n| table.contains_key(n)), "`{layer}` may name something that is not in the table");
    }
    // take away layers that name nothing that is left; a ring would stay
    let mut left = table.clone();
    while let Some(free) = left.iter().find(|(_, may)| may.iter().all(|n| !left.contains_key(n))).map(|(l, _)| l.clone()) {
        left.remove(&free);
    }
    assert!(left.is_empty(), "these layers name each other in a ring: {:?}", left.keys());
}

#[test]
fn the_rule_sees_every_way_to_name_a_layer() {
    let layers: BTreeSet<String> = ["graph", "math", "node", "patch", "step"].map(str::to_owned).into();
    let may: BTreeSet<String> = ["graph", "math"].map(str::to_owned).into();
    let broken = |text: &str| faults("node", &may, &layers, text);
    for clean in [
        "use crate::graph::Graph;",
        "use crate::{graph::{self, Strut}, math::nurbs};",
        "// use crate::patch;\n/* crate::step */",
        "let x = \"crate::patch\";",
        "crate::node::star::angle(a, b)",
        "super::super::cut()",
    ] {
        assert!(broken(clean).is_empty(), "{clean}: {:?}", broken(clean));
    }
    for text in [
        "use crate::patch::Skin;",
        "use crate::{graph::Graph, patch};",
        "let x = crate::patch::fit(film);",
        "use super::super::patch;",
        "let c = '\"'; use crate::patch; let d = '\"';",
        "pub(crate) fn f() { crate::patch::fit() }",
    ] {
        assert_eq!(broken(text), ["`node` names `patch`"], "{text}");
    }
}
