//! TetGen, Gmsh and VTK: lines and the edges of tetrahedra.

mod imported;

use imported::{count, faults, notes, read, read_beside, read_with, strut};
use lattice_brep::graph::import::{Format, ImportOptions, Imported, RadiusRule, Units};

const NODE: &str = include_str!("examples/import/tet.node");
const EDGE: &str = include_str!("examples/import/tet.edge");
const ELE: &str = include_str!("examples/import/tet.ele");
const TWO: &str = include_str!("examples/import/two.msh");
const FOUR: &str = include_str!("examples/import/four.msh");
const LINES: &str = include_str!("examples/import/lines.vtk");
const LINES_5: &str = include_str!("examples/import/lines5.vtk");

const EIGHTH: ImportOptions = ImportOptions { radius_rule: Some(RadiusRule::Shortest(8.0)), unit: None };

/// All struts as sorted pairs of rounded positions, so that files can be compared whatever their order.
fn shape(imported: &Imported) -> Vec<[[i64; 3]; 2]> {
    let round = |p: [f64; 3]| p.map(|x| (x * 1e6).round() as i64);
    let mut out: Vec<_> = (0..imported.input.struts.len())
        .map(|k| {
            let (p, q, _) = strut(imported, k);
            let mut ends = [round(p), round(q)];
            ends.sort_unstable();
            ends
        })
        .collect();
    out.sort_unstable();
    out
}

#[test]
fn tetgen_files_are_found_from_any_of_them() {
    let tets = read_beside("a.node", NODE, &[("ele", ELE)], &EIGHTH);
    assert_eq!((tets.format, count(&tets), faults(&tets)), (Some(Format::TetGen), (5, 9), vec![]), "two tetrahedra share three edges");
    assert_eq!(strut(&tets, 0), ([0.0; 3], [4.0, 0.0, 0.0], [0.25; 2]));
    assert_eq!(
        notes(&tets),
        [
            "document: 2 tetrahedra and 0 lines: 9 struts, each edge once",
            "document: no radius for 9 of 9 struts: 0.25 mm by --radius-rule, the shortest strut's 2 mm (.ele line 2) / 8",
            "document: nodes without a strut: 1 left out (first at .node line 8)",
        ]
    );
    assert_eq!(shape(&read_beside("b.ELE", ELE, &[("node", NODE)], &EIGHTH)), shape(&tets));
    // edges, where there are any, say which struts there are
    let edges = read_beside("c.node", NODE, &[("ele", ELE), ("edge", EDGE)], &EIGHTH);
    assert_eq!((count(&edges), faults(&edges)), ((4, 3), vec![]));
    assert_eq!(shape(&read_beside("d.edge", EDGE, &[("node", NODE)], &EIGHTH)), shape(&edges));
}

#[test]
fn tetgen_files_that_are_not_there_or_lie_are_refused() {
    let files = |name: &str, text: &str, beside: &[(&str, &str)]| faults(&read_beside(name, text, beside, &EIGHTH));
    assert_eq!(
        files("a.node", NODE, &[]),
        ["document: found no .edge or .ele file beside it, wanted a .node file, and a .edge or .ele file, with the same stem"]
    );
    assert_eq!(files("a.ele", ELE, &[]), ["document: found no .node file beside it, wanted a .node file, and a .edge or .ele file, with the same stem"]);
    let claimed = NODE.replace("6 3 1 1", "1000000000 3 0 0");
    assert_eq!(files("a.node", &claimed, &[("ele", ELE)]), [".node line 2: found a count of 1000000000, then 6 lines, wanted as many lines as the count says"]);
    assert_eq!(files("a.node", &NODE.replace("6 3 1 1", "6 2 1 1"), &[("ele", ELE)]), [".node line 1: found 2 dimensions, wanted [3] dimensions"]);
    assert_eq!(
        files("a.node", &NODE.replace("6 3 1 1", "many"), &[("ele", ELE)]),
        [".node line 2: found no count, wanted the first line of a .node file, with the number of items"]
    );
    assert_eq!(
        files("a.ele", &ELE.replace("2 3 4 5", "2 3 4 99"), &[("node", &NODE.replace("4 0 0", "4 nan 0").replace("5  3", "1  3"))]),
        [
            ".node line 4: found `nan` as y, wanted a finite number",
            ".node line 7: found a second node 1, wanted each number once",
            ".ele line 3: found `99`, wanted the number of one of the 5 nodes",
        ]
    );
}

#[test]
fn gmsh_versions_2_and_4_give_the_same_lattice() {
    let two = read_with("two.msh", TWO, &EIGHTH);
    assert_eq!((two.format, count(&two), faults(&two)), (Some(Format::Gmsh), (6, 10), vec![]));
    let four = read_with("four.msh", FOUR, &EIGHTH);
    assert_eq!((four.format, count(&four), faults(&four)), (Some(Format::Gmsh), (6, 10), vec![]));
    assert_eq!(shape(&two), shape(&four));
    for file in [&two, &four] {
        assert_eq!(
            notes(file)[..2],
            [
                "document: left out: 1 points, 1 triangles; only lines and the edges of tetrahedra are struts",
                "document: 2 tetrahedra and 1 lines: 10 struts, each edge once"
            ]
        );
    }
    let metres = ImportOptions { unit: Some(Units::M), ..EIGHTH };
    assert_eq!(strut(&read_with("two.msh", TWO, &metres), 0), ([0.0; 3], [4000.0, 0.0, 0.0], [250.0; 2]));
    assert!(faults(&read("two.msh", TWO))[0].contains("no radius for any of the 10 struts of this Gmsh file, wanted `--radius-rule shortest/8`"));
}

#[test]
fn gmsh_files_that_lie_or_cannot_be_read_are_refused() {
    let cases = [
        (TWO.replace("$Nodes\n6", "$Nodes\n1000000000"), "line 9: found a count of 1000000000 nodes, then 6, wanted as many as the count says"),
        (TWO.replace("$Elements\n5", "$Elements\n4000000000"), "line 18: found a count of 4000000000 elements, then 5, wanted as many as the count says"),
        (FOUR.replace("0 1 0 2\n", "0 1 0 2000000000\n"), "line 9: found a count of 2000000000 nodes, then 13, wanted as many as the count says"),
        (TWO.replace("2.2 0 8", "2.2 1 8"), "line 2: found a binary file, wanted ASCII: save with Mesh.Binary = 0"),
        (TWO.replace("2.2 0 8", "4 0 8"), "line 2: found version `4`, wanted version 2 or 4.1"),
        (TWO.replace("2 30 4 5\n", "2 31 4\n"), "line 22: found `31`, wanted the number of one of the 6 nodes"),
        (TWO.replace("30 0 3 0", "2 0 3 inf"), "line 12: found `inf` as z, wanted a finite number"),
        (TWO.replace("4 4 2 0 1 2", "4 four 2 0 1 2"), "line 22: found `four`, wanted the type of an element"),
        (
            "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n1\n1 0 0 0\n$EndNodes\n$Elements\n1\n1 3 0 1 1 1 1\n".into(),
            "document: found 1 quadrangles, wanted line elements or tetrahedra, whose edges become struts",
        ),
    ];
    for (text, wanted) in cases {
        let found = faults(&read_with("bad.msh", &text, &EIGHTH));
        assert!(found.contains(&wanted.to_owned()), "{wanted}: {found:#?}");
    }
}

#[test]
fn legacy_vtk_has_radii_of_cells_or_points() {
    let lines = read("lines.vtk", LINES);
    assert_eq!((lines.format, count(&lines), faults(&lines)), (Some(Format::Vtk), (5, 7), vec![]));
    assert_eq!(strut(&lines, 0), ([-8.0, 0.0, 0.0], [0.0; 3], [0.25; 2]), "a polyline: two struts with the cell's radius");
    assert_eq!(strut(&lines, 1), ([0.0; 3], [4.0, 0.0, 0.0], [0.25; 2]));
    assert_eq!(strut(&lines, 2).2, [0.5; 2]);
    assert_eq!(strut(&lines, 3).2, [1.0; 2], "edges of a tetrahedron: radii of the points");
    let lines = read("lines5.vtk", LINES_5);
    assert_eq!((count(&lines), faults(&lines)), ((3, 2), vec![]));
    assert_eq!(strut(&lines, 0), ([0.0; 3], [4.0, 0.0, 0.0], [0.5, 0.75]));
    assert_eq!(strut(&lines, 1).2, [0.75, 1.0]);
}

#[test]
fn legacy_vtk_that_lies_is_refused() {
    let cases = [
        (LINES.replace("POINTS 6", "POINTS 1000000000"), "line 8: found 3000000000 coordinates claimed, then 18 and `CELLS`, wanted as many as the count says"),
        (LINES.replace("POINTS 6", "POINTS 99999999999999999999"), "line 5: found `99999999999999999999`, wanted the number of points"),
        (
            LINES.replace("POINTS 6", "POINTS 18446744073709551615"),
            "line 8: found 18446744073709551615 coordinates claimed, then 18 and `CELLS`, wanted as many as the count says",
        ),
        (LINES.replace("3 5 0 1", "4e9 5 0 1"), "line 11: found a cell of 4000000000 points, then 11 values, wanted as many as the count says"),
        (LINES.replace("CELLS 3 12", "CELLS 5 12"), "line 11: found 5 cells claimed, then 3, wanted as many as the count says"),
        (LINES.replace("2 0 2\n", "2 0 6\n"), "cells[1]: found the points 0 6, wanted 2 point numbers below 6"),
        (LINES.replace("2 0 2\n", "2 0 -1\n"), "cells[1]: found the points 0 -1, wanted 2 point numbers below 6"),
        (LINES.replace("0.25 0.5 9", "0.25 nan 9"), "cells[1]: found NaN as radius, wanted a radius > 0"),
        (LINES.replace("0 0 2  3 3 3", "0 0 nan  3 3 3"), "points[3]: found 0 0 NaN, wanted three finite numbers"),
        (LINES.replace("ASCII", "BINARY"), "line 3: found a binary file, wanted ASCII; or save as .vtu, which may be binary"),
        (LINES.replace("UNSTRUCTURED_GRID", "STRUCTURED_POINTS"), "line 4: found `STRUCTURED_POINTS`, wanted UNSTRUCTURED_GRID or POLYDATA"),
        (LINES_5.replace("0 3\nCONN", "0 9\nCONN"), "cells[1]: found an end at 10, wanted between 1 and 4"),
    ];
    for (text, wanted) in cases {
        let found = faults(&read("bad.vtk", &text));
        assert!(found.contains(&wanted.to_owned()), "{wanted}: {found:#?}");
    }
}

fn base64(bytes: &[u8]) -> String {
    const DIGITS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut out = String::new();
    for group in bytes.chunks(3) {
        let bits = u32::from_be_bytes([0, group[0], *group.get(1).unwrap_or(&0), *group.get(2).unwrap_or(&0)]);
        for k in 0..4 {
            out.push(if k <= group.len() { DIGITS[(bits >> (18 - 6 * k) & 63) as usize] as char } else { '=' });
        }
    }
    out
}

/// Three arrays of two struts and one tetrahedron: positions (f32), connectivity (i64), offsets (i32); types (u8); radii (f64).
fn arrays() -> [(&'static str, Vec<u8>); 5] {
    let points = [0f32, 0., 0., 4., 0., 0., 0., 3., 0., 0., 0., 2., 3., 3., 3.];
    [
        ("Float32", points.iter().flat_map(|x| x.to_le_bytes()).collect()),
        ("Int64", [0i64, 4, 3, 4, 0, 1, 2, 3].iter().flat_map(|x| x.to_le_bytes()).collect()),
        ("Int32", [2i32, 4, 8].iter().flat_map(|x| x.to_le_bytes()).collect()),
        ("UInt8", vec![3, 3, 10]),
        ("Float64", [0.5f64, 0.25, 0.125, 0.5, 1.0].iter().flat_map(|x| x.to_le_bytes()).collect()),
    ]
}

/// A VTU file whose five arrays are written by `array`: (tag's format attributes, content).
fn vtu(attributes: &str, mut array: impl FnMut(&[u8]) -> (String, String), end: &str) -> String {
    let names = [r#"Name="Points" NumberOfComponents="3""#, r#"Name="connectivity""#, r#"Name="offsets""#, r#"Name="types""#, r#"Name="Radius""#];
    let text: Vec<String> = arrays()
        .into_iter()
        .zip(names)
        .map(|((kind, bytes), name)| {
            let (format, content) = array(&bytes);
            format!(r#"<DataArray type="{kind}" {name} {format}>{content}</DataArray>"#)
        })
        .collect();
    format!(
        r#"<?xml version="1.0"?><VTKFile type="UnstructuredGrid" version="1.0" byte_order="LittleEndian" {attributes}><UnstructuredGrid><FieldData/><Piece NumberOfPoints="5" NumberOfCells="3">
<Points>{}</Points><Cells>{}{}{}</Cells><PointData Scalars="Radius">{}</PointData></Piece></UnstructuredGrid>{end}</VTKFile>"#,
        text[0], text[1], text[2], text[3], text[4]
    )
}

fn packed(bytes: &[u8]) -> Vec<u8> {
    use std::io::Write;
    let mut zip = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::best());
    zip.write_all(bytes).unwrap();
    zip.finish().unwrap()
}

/// Count of bytes, as array headers have it.
fn length(bytes: &[u8]) -> [u8; 4] {
    (bytes.len() as u32).to_le_bytes()
}

#[test]
fn vtu_arrays_may_be_base64_appended_raw_or_packed() {
    let inline = vtu("", |b| (r#"format="binary""#.into(), base64(&[&length(b), b].concat())), "");
    let long =
        vtu(r#"header_type="UInt64""#, |b| (r#"format="binary""#.into(), format!("\n  {}\n", base64(&[&(b.len() as u64).to_le_bytes(), b].concat()))), "");
    // header and data each with their own padding, two blocks
    let zlib = vtu(
        r#"compressor="vtkZLibDataCompressor""#,
        |b| {
            let (one, two) = b.split_at(b.len() / 2);
            let blocks = [packed(one), packed(two)];
            let header = [[2, 0, 0, 0], length(one), length(two), length(&blocks[0]), length(&blocks[1])].concat();
            (r#"format="binary""#.into(), base64(&header) + &base64(&blocks.concat()))
        },
        "",
    );
    let mut data = String::new();
    let appended = vtu(
        "",
        |b| {
            let offset = data.len();
            data += &base64(&[&length(b), b].concat());
            (format!(r#"format="appended" offset="{offset}""#), String::new())
        },
        "@",
    );
    let appended = appended.replace('@', &format!(r#"<AppendedData encoding="base64"> _{data}</AppendedData>"#));
    let mut data: Vec<u8> = Vec::new();
    let raw = vtu(
        "",
        |b| {
            let offset = data.len();
            data.extend([&length(b), b].concat());
            (format!(r#"format="appended" offset="{offset}""#), String::new())
        },
        "@",
    );
    let (before, after) = raw.split_once('@').unwrap();
    let raw = [before.as_bytes(), br#"<AppendedData encoding="raw">_"#, &data, b"</AppendedData>", after.as_bytes()].concat();
    for (what, bytes) in
        [("inline", inline.as_bytes()), ("long", long.as_bytes()), ("zlib", zlib.as_bytes()), ("appended", appended.as_bytes()), ("raw", &raw[..])]
    {
        let part = read("a.vtu", bytes);
        assert_eq!((part.format, count(&part), faults(&part)), (Some(Format::Vtu), (5, 8), vec![]), "{what}");
        assert_eq!(strut(&part, 0), ([0.0; 3], [3.0; 3], [0.5, 1.0]), "{what}");
        assert_eq!(strut(&part, 1), ([0.0, 0.0, 2.0], [3.0; 3], [0.5, 1.0]), "{what}");
        assert_eq!(strut(&part, 2), ([0.0; 3], [4.0, 0.0, 0.0], [0.5, 0.25]), "{what}");
    }
    // any one byte changed: a fault or a lattice, never a panic
    for k in (0..raw.len()).step_by(5) {
        let mut broken = raw.clone();
        broken[k] ^= 0x15;
        read("broken.vtu", &broken);
    }
}

#[test]
fn vtp_lines_are_read_as_text() {
    let text = r#"<VTKFile type="PolyData"><PolyData><Piece><Points><DataArray type="Float64" NumberOfComponents="3" format="ascii">0 0 0 1 0 0 1 2 0
<InformationKey name="L2_NORM_RANGE" location="vtkDataArray" length="2"><Value index="0">0</Value><Value index="1">2.2</Value></InformationKey></DataArray></Points>
<Verts><DataArray type="Int64" Name="connectivity" format="ascii">0</DataArray><DataArray type="Int64" Name="offsets" format="ascii">1</DataArray></Verts>
<Lines><DataArray type="Int64" Name="connectivity" format="ascii">0 1 2</DataArray><DataArray type="Int64" Name="offsets" format="ascii">3</DataArray></Lines>
<CellData><DataArray type="Float64" Name="radius" format="ascii">9 0.125</DataArray></CellData></Piece></PolyData></VTKFile>"#;
    let part = read("a.vtp", text);
    assert_eq!((count(&part), faults(&part)), ((3, 2), vec![]));
    assert_eq!((strut(&part, 0).2, strut(&part, 1).2), ([0.125; 2], [0.125; 2]));
    let part = read("a.vtp", text.replace("9 0.125", "9"));
    assert_eq!(faults(&part)[0], "Piece[0].cell radii: found 1 values, wanted 2");
}

/// Found by fuzzing: in a second piece the first point's number was added to one that is out of range before that was looked at.
#[test]
fn point_numbers_beyond_all_integers_are_faults_in_any_piece() {
    let piece = |numbers: &str| {
        format!(
            r#"<Piece><Points><DataArray type="Float64" NumberOfComponents="3" format="ascii">0 0 0 1 0 0</DataArray></Points>
<Lines><DataArray type="Int64" Name="connectivity" format="ascii">{numbers}</DataArray><DataArray type="Int64" Name="offsets" format="ascii">2</DataArray></Lines>
<PointData><DataArray type="Float64" Name="radius" format="ascii">0.1 0.1</DataArray></PointData></Piece>"#
        )
    };
    let text = |second: &str| format!(r#"<VTKFile type="PolyData"><PolyData>{}{}</PolyData></VTKFile>"#, piece("0 1"), piece(second));
    assert_eq!(count(&read("a.vtp", text("0 1"))), (4, 2));
    for number in ["2", "4294967295", "1e300", "-1", "0.5", "nan"] {
        let found = faults(&read("a.vtp", text(&format!("0 {number}"))));
        assert!(found.iter().any(|f| f.starts_with("Piece[1].cells[0]: found the points 0 ")), "{number}: {found:?}");
    }
}

#[test]
fn vtu_files_that_lie_are_refused() {
    let claimed = vtu("", |b| (r#"format="binary""#.into(), base64(&[&[255u8; 4], b].concat())), "");
    assert_eq!(faults(&read("a.vtu", &claimed)), ["Piece[0].Points.Points: found fewer bytes than its header says, wanted as many as the header says"]);
    let blocks = vtu(r#"header_type="UInt64" compressor="vtkZLibDataCompressor""#, |b| (r#"format="binary""#.into(), base64(&[&[255u8; 8], b].concat())), "");
    assert_eq!(faults(&read("a.vtu", &blocks)), ["Piece[0].Points.Points: found fewer bytes than its header says, wanted as many as the header says"]);
    let zeros = packed(&vec![0; 64 << 20]);
    let bomb = vtu(
        r#"compressor="vtkZLibDataCompressor""#,
        |_| (r#"format="binary""#.into(), base64(&[[1, 0, 0, 0], [0, 0, 0, 4], [0, 0, 0, 4], length(&zeros)].concat()) + &base64(&zeros)),
        "",
    );
    assert!(faults(&read("a.vtu", &bomb))[0].ends_with("wanted a file that is not a zip bomb"));
    for (bad, wanted) in [
        (
            vtu(r#"compressor="vtkLZ4DataCompressor""#, |_| Default::default(), ""),
            "VTKFile.compressor: found `vtkLZ4DataCompressor`, wanted vtkZLibDataCompressor or none",
        ),
        (
            vtu("", |_| Default::default(), "").replace("\"UnstructuredGrid\"", "\"ImageData\""),
            "VTKFile.type: found `ImageData`, wanted UnstructuredGrid or PolyData",
        ),
        (vtu("", |_| (r#"format="ascii""#.into(), "1 2 x".into()), ""), "Piece[0].Points.Points: found `x`, wanted a number"),
        (
            vtu("", |_| (r#"format="appended" offset="9""#.into(), String::new()), ""),
            "Piece[0].Points.Points: found no AppendedData, wanted the appendix that the array is in",
        ),
    ] {
        assert_eq!(faults(&read("a.vtu", &bad)), [wanted]);
    }
}
