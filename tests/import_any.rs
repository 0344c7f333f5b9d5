//! Formats are found by content; input that means harm ends in a fault, with bounded memory, whatever its format.

mod imported;

use imported::{count, faults, read, read_beside};
use lattice_brep::graph::import::{Format, sniff};
use std::path::Path;
use std::process::Command;

/// All fixtures, with their formats.
const FILES: [(&str, &str, Format); 13] = [
    ("corner.csv", include_str!("examples/import/corner.csv"), Format::Csv),
    ("corner.obj", include_str!("examples/import/corner.obj"), Format::Obj),
    ("tet.node", include_str!("examples/import/tet.node"), Format::TetGen),
    ("tet.edge", include_str!("examples/import/tet.edge"), Format::TetGen),
    ("tet.ele", include_str!("examples/import/tet.ele"), Format::TetGen),
    ("two.msh", include_str!("examples/import/two.msh"), Format::Gmsh),
    ("four.msh", include_str!("examples/import/four.msh"), Format::Gmsh),
    ("lines.vtk", include_str!("examples/import/lines.vtk"), Format::Vtk),
    ("lines5.vtk", include_str!("examples/import/lines5.vtk"), Format::Vtk),
    ("beams.ltcx", include_str!("examples/import/beams.ltcx"), Format::Ltcx),
    ("frame.inp", include_str!("examples/import/frame.inp"), Format::Abaqus),
    ("bcc.json", include_str!("examples/bcc.json"), Format::Json),
    ("a.vtu", "<?xml version=\"1.0\"?>\n<!-- <graph> -->\n<VTKFile type=\"UnstructuredGrid\"/>", Format::Vtu),
];

#[test]
fn the_format_is_found_by_content_and_not_by_suffix() {
    for (name, text, format) in FILES {
        assert_eq!(sniff(text.as_bytes(), Path::new(name)), Some(format), "{name}");
        // TetGen's tables of numbers are like many others: they need their suffix
        if format != Format::TetGen {
            for other in ["none", "x.dat", "x.stl", "x.json", "x.3mf", "x.csv"] {
                assert_eq!(sniff(text.as_bytes(), Path::new(other)), Some(format), "{name} as {other}");
            }
        }
    }
    assert_eq!(sniff(b"PK\x03\x04rest", Path::new("a.json")), Some(Format::ThreeMf));
    assert_eq!(sniff(b"no lattice", Path::new("a.JSON")), Some(Format::Json), "its own reader says what is wrong");
    assert_eq!(sniff(b"no lattice", Path::new("a.txt")), None);
}

#[test]
fn content_of_no_format_is_named_where_possible() {
    let wanted = "wanted a lattice in one of the formats of docs/formats.md (JSON, 3MF, TetGen, Gmsh, VTK, LTCX, CSV, OBJ, Abaqus)";
    for (bytes, found) in [
        (&b""[..], "an empty file"),
        (b"ISO-10303-21;\nHEADER;", "a STEP file"),
        (b"solid part\nfacet normal", "an STL file: a surface, no struts"),
        (b"\x1f\x8b\x08rest", "a file packed by gzip: unpack it first"),
        (b"\xff\xfe{\0", "text in UTF-16: save it as UTF-8"),
        (b"\x00\x01\x02\xff", "content of no known format"),
    ] {
        let part = read("a.bin", bytes);
        assert_eq!((part.format, faults(&part)), (None, vec![format!("document: found {found}, {wanted}")]));
    }
}

#[test]
fn deep_json_is_refused() {
    for text in [format!("{{\"nodes\":{}", "[".repeat(1_000_000)), format!("{{\"nodes\":{}1{}", "[".repeat(200), "]".repeat(200)), "{\"a\":".repeat(1_000_000)]
    {
        let part = read("deep.json", &text);
        assert_eq!((part.format, count(&part)), (Some(Format::Json), (0, 0)));
        assert!(!part.faults.is_empty() && part.faults.iter().all(|f| f.to_string().len() < 300), "{:?}", part.faults);
    }
}

#[test]
fn a_file_of_nothing_but_faults_is_told_in_bounded_length() {
    let part = read("bad.csv", "0,0,0,1,0,0,1\n".to_owned() + &"x,0,0,1,1,1,1\n".repeat(50_000));
    assert_eq!(part.faults.len(), 10_001);
    assert_eq!(faults(&part)[10_000], "document: found 40000 more faults, wanted none");
    let part = read("bad.json", format!("{{\"nodes\":[{}0],\"struts\":[]}}", "0,".repeat(49_999)));
    assert_eq!((part.faults.len(), count(&part)), (10_001, (0, 0)));
    assert_eq!(faults(&part)[10_000], "document: found 40000 more faults, wanted none");
    let long = read("bad.csv", format!("0,0,0,1,0,0,1\n{},0,0,1,1,1,1\n", "\u{1b}]x".repeat(100_000)));
    let fault = &faults(&long)[0];
    assert!(fault.len() < 300 && !fault.contains('\u{1b}'), "{fault}");
}

#[test]
fn any_byte_changed_or_lost_is_a_fault_or_a_lattice_and_never_a_panic() {
    for (name, text, _) in FILES.iter().filter(|(_, text, _)| text.len() < 5000) {
        let beside = FILES.map(|(name, text, _)| (name.rsplit('.').next().unwrap(), text));
        for k in (0..text.len()).step_by(9) {
            for replaced in ["", "-", "9999999999", "\n", "\u{0}\"", "é"] {
                let broken = format!("{}{replaced}{}", &text[..k], &text[k + 1..]);
                let part = read_beside(name, &broken, &beside, &Default::default());
                // the checks of content must stand it too
                let _ = part.admit(Default::default());
            }
            read_beside(name, &text[..k], &beside, &Default::default());
        }
    }
}

#[test]
fn export_reads_files_as_users_have_them_and_writes_nothing_after_a_fault() {
    let folder = tempfile::tempdir().unwrap();
    let run = |name: &str, more: &[&str]| {
        let output = folder.path().join("out.step");
        let out =
            Command::new(env!("CARGO_BIN_EXE_lattice-brep")).arg("export").arg(folder.path().join(name)).arg("-o").arg(&output).args(more).output().unwrap();
        let written = output.exists();
        let _ = std::fs::remove_file(output);
        (out.status.code(), String::from_utf8(out.stderr).unwrap(), written)
    };
    for (name, text, _) in FILES {
        std::fs::write(folder.path().join(name), text).unwrap();
    }
    let (code, text, written) = run("tet.ele", &["--radius-rule", "0.05"]);
    assert!(code == Some(0) && written, "{text}");
    assert!(text.contains("1 solid, 3 struts, 4 nodes") && text.contains("no radius for 3 of 3 struts: 0.05 mm by --radius-rule"), "{text}");
    let (code, text, written) = run("tet.node", &[]);
    assert!(code == Some(2) && !written && text.contains("wanted `--radius-rule shortest/8`"), "{text}");
    let (code, text, _) = run("two.msh", &["--radius-rule", "shortest/0"]);
    assert!(code == Some(2) && text.contains("wanted `shortest/N` or a radius in mm"), "{text}");
    let (code, text, written) = run("bcc.json", &["--units", "in"]);
    assert!(code == Some(2) && !written && text.contains("--units: found a unit, wanted none: a JSON file states its own"), "{text}");
    let (code, text, written) = run("a.vtu", &[]);
    assert!(code == Some(2) && !written && text.contains("document: found no elements"), "{text}");
}

#[test]
fn a_name_comes_back_equal_from_the_step_file() {
    let folder = tempfile::tempdir().unwrap();
    let name = "a \"b\" 'c' \\ ../../etc/passwd größe 中 🦀";
    let text = serde_json::json!({"name": name, "nodes": [[0, 0, 0], [9, 0, 0]], "struts": [{"a": 0, "b": 1, "ra": 1, "rb": 1}]}).to_string();
    for (text, wanted) in [
        (&text, name),
        (&text.replace("etc", "\\u0001\\n"), &name.replace("etc", "\u{1}\n")),
        (&r#"{"name":"\n ","nodes":[[0,0,0],[9,0,0]],"struts":[{"a":0,"b":1,"ra":1,"rb":1}]}"#.to_owned(), "rod"),
    ] {
        let (input, output) = (folder.path().join("rod.json"), folder.path().join("rod.step"));
        std::fs::write(&input, text).unwrap();
        let out = Command::new(env!("CARGO_BIN_EXE_lattice-brep")).arg("export").arg(&input).arg("-o").arg(&output).output().unwrap();
        assert!(out.status.success(), "{}", String::from_utf8_lossy(&out.stderr));
        let bytes = std::fs::read(&output).unwrap();
        assert!(bytes.is_ascii());
        assert_eq!(lattice_brep::step::readback::read_back(&bytes[..]).unwrap().products, [wanted]);
    }
}
