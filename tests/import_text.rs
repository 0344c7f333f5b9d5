//! CSV pairs and OBJ lines.

mod imported;

use imported::{count, faults, lengths, notes, read, read_with, strut};
use lattice_brep::graph::check::Overlaps;
use lattice_brep::graph::import::{Format, ImportOptions, RadiusRule, Units};

const CSV: &str = include_str!("examples/import/corner.csv");
const OBJ: &str = include_str!("examples/import/corner.obj");
const LTCX: &str = include_str!("examples/import/beams.ltcx");
const INP: &str = include_str!("examples/import/frame.inp");

fn rule(radius_rule: RadiusRule) -> ImportOptions {
    ImportOptions { radius_rule: Some(radius_rule), unit: None }
}

#[test]
fn csv_pairs_are_joined_at_their_ends_and_that_is_noted() {
    let corner = read("corner.csv", CSV);
    assert_eq!(corner.format, Some(Format::Csv));
    assert_eq!((count(&corner), faults(&corner)), ((5, 4), vec![]));
    assert_eq!(strut(&corner, 0), ([0.0; 3], [10.0, 0.0, 0.0], [1.0, 1.0]));
    assert_eq!(strut(&corner, 1).2, [1.0, 0.5]);
    assert_eq!(strut(&corner, 2).0, [0.0; 3], "joined to the first");
    assert_eq!(strut(&corner, 3), ([10.0, 0.0, 0.0], [10.0, 8.0, 3.0], [0.75, 1.0]));
    assert_eq!(notes(&corner), ["document: 8 ends are 5 nodes: ends in one place are joined (at most 1e-7 mm apart)"]);
}

/// The box of these ends has a diagonal of 0 in doubles: cell numbers beyond all integers must not overflow.
#[test]
fn ends_nearer_than_doubles_can_measure_do_not_overflow() {
    let part = read("tiny.csv", "0,0,0,1e-200,0,0,1\n");
    assert_eq!((count(&part), part.format), ((2, 1), Some(Format::Csv)));
    assert!(part.admit(Overlaps::Refuse).is_err());
}

#[test]
fn csv_may_be_parted_by_semicolons_tabs_or_blanks_with_or_without_names() {
    for text in ["0;0;0;1;0;0;.1\r\n", "\u{feff}0\t0\t0\t1\t0\t0\t.1", "a b c d e f r\n0  0 0   1 0 0 +1e-1\n\n"] {
        let lattice = read("some.txt", text);
        assert_eq!((lattice.format, faults(&lattice)), (Some(Format::Csv), vec![]), "{text:?}");
        assert_eq!(strut(&lattice, 0), ([0.0; 3], [1.0, 0.0, 0.0], [0.1, 0.1]), "{text:?}");
    }
}

#[test]
fn every_bad_line_of_csv_is_told_and_the_rest_is_still_checked() {
    let text = "x,y,z,x,y,z,r\n0,0,0,1,0,0,-1\n1,2,3\n0,0,nan,1,0,inf,1\n0,0,0,1,1,1e999,1\n0,0,0,0,1,0,x\u{7}\"y,2\n0,5,0,0,5,0,1\n";
    assert_eq!(
        faults(&read("bad.csv", text)),
        [
            "line 2: found `-1` as radius, wanted a radius > 0",
            "line 3: found 3 values, wanted 6 to 8: x0,y0,z0,x1,y1,z1[,r0[,r1]]",
            "line 4: found `nan` as z, wanted a finite number",
            "line 4: found `inf` as z, wanted a finite number",
            "line 5: found `1e999` as z, wanted a finite number",
            "line 6: found `x\\u{7}\"y` as radius, wanted a radius > 0",
        ]
    );
    // content: by the checks of the graph, with the line added
    let Err(error) = read("bad.csv", text).admit(Default::default()) else { panic!("refused") };
    assert!(error.to_string().contains("\n  struts[0] (line 7): found both ends at nodes[0], wanted two different nodes"), "{error}");
    assert_eq!(faults(&read("d.csv", "x,y,z,x,y,z,Diameter\n0,0,0,1,0,0,1\n")), ["line 1: found a column named `Diameter`, wanted radii, not diameters"]);
    assert_eq!(faults(&read("comma.csv", "0,5;0;0;1;0;0;1\n0;0;0;1;0;0;1\n")), ["line 1: found `0,5` as x, wanted a finite number"]);
}

#[test]
fn without_radii_a_rule_is_asked_for_and_used() {
    let text = "0,0,0,2,0,0\n0,0,0,0,3,0,0.5\n0,0,0,0,0,4\n";
    let wanted = "wanted `--radius-rule shortest/8` (an eighth of the shortest strut) or a radius in mm, such as `--radius-rule 0.5`";
    assert_eq!(faults(&read("a.csv", text)), [format!("line 1: found no radius for 2 of 3 struts of this CSV file, {wanted}")]);
    let shortest = read_with("a.csv", text, &rule(RadiusRule::Shortest(8.0)));
    assert_eq!((0..3).map(|k| strut(&shortest, k).2).collect::<Vec<_>>(), [[0.25; 2], [0.5; 2], [0.25; 2]]);
    assert!(notes(&shortest).contains(&"document: no radius for 2 of 3 struts: 0.25 mm by --radius-rule, the shortest strut's 2 mm (line 1) / 8".to_owned()));
    // a rule's length is in mm whatever the file's unit
    let inches = read_with("a.csv", text, &ImportOptions { radius_rule: Some(RadiusRule::Length(0.5)), unit: Some(Units::In) });
    assert_eq!(lengths(&inches)[0], 50.8);
    assert_eq!((strut(&inches, 0).2, strut(&inches, 1).2), ([0.5; 2], [12.7; 2]));
    let given = read_with("a.csv", "0,0,0,2,0,0,1\n", &rule(RadiusRule::Length(0.5)));
    assert_eq!(notes(&given), ["--radius-rule: not used: the file gives every radius"]);
}

#[test]
fn radius_rules_are_read_exactly() {
    assert_eq!("shortest/8".parse(), Ok(RadiusRule::Shortest(8.0)));
    assert_eq!("0.1".parse(), Ok(RadiusRule::Length(0.1)));
    for bad in ["shortest", "shortest/0", "shortest/-1", "-1", "0", "nan", "inf", "", "longest/2", "1mm"] {
        let error = bad.parse::<RadiusRule>().unwrap_err();
        assert!(error.contains("wanted `shortest/N`"), "{bad}: {error}");
    }
}

#[test]
fn obj_polylines_become_struts() {
    let corner = read_with("corner.obj", OBJ, &rule(RadiusRule::Length(0.5)));
    assert_eq!((corner.format, count(&corner), faults(&corner)), (Some(Format::Obj), (5, 4), vec![]));
    assert_eq!(corner.input.name.as_deref(), Some("corner \"of\" struts"));
    assert_eq!(strut(&corner, 0), ([10.0, 8.0, 3.0], [10.0, 0.0, 0.0], [0.5, 0.5]));
    assert_eq!(strut(&corner, 3), ([0.0; 3], [0.0, 0.0, 10.0], [0.5, 0.5]), "indices from the end");
    assert_eq!(
        notes(&corner),
        [
            "document: 1 faces, points, curves and surfaces: left out, only `l` records are struts",
            "document: 6 ends are 5 nodes: ends in one place are joined (equal in all digits)",
            "document: no radius for 4 of 4 struts: 0.5 mm by --radius-rule",
        ]
    );
}

#[test]
fn bad_obj_lines_are_told() {
    let text = "v 0 0 0\nv 1 0\nv 2 0 x\nl 1 9\nl 0 1\nl 1 -4\nl 1\nl 1 99999999999999999999\n";
    assert_eq!(
        faults(&read("bad.obj", text)),
        [
            "line 2: found nothing as z, wanted a finite number",
            "line 3: found `x` as z, wanted a finite number",
            "line 4: found `9`, wanted the number of one of the 3 vertices",
            "line 5: found `0`, wanted the number of one of the 3 vertices",
            "line 6: found `-4`, wanted the number of one of the 3 vertices",
            "line 7: found a line of 1 vertices, wanted two or more",
            "line 8: found `99999999999999999999`, wanted the number of one of the 3 vertices",
        ]
    );
}

#[test]
fn ltcx_radii_stand_on_the_nodes() {
    let part = read("beams.ltcx", LTCX);
    assert_eq!((part.format, count(&part), faults(&part)), (Some(Format::Ltcx), (3, 2), vec![]));
    assert_eq!(strut(&part, 0), ([0.0; 3], [50.8, 0.0, 0.0], [12.7, 6.35]));
    assert_eq!(strut(&part, 1).2, [12.7, 12.7]);
    assert_eq!(notes(&part), ["document: nodes without a strut: 1 left out (first at node[3])"]);
    let bad = LTCX
        .replace("\"in\"", "\"mile\"")
        .replace("rad=\"0.25\"", "rad=\"-1\"")
        .replace("n2=\"11\"", "n2=\"99\"")
        .replace("x=\"9\"", "x=\"NaN\"")
        .replace("id=\"12\"", "id=\"10\"");
    assert_eq!(
        faults(&read("bad.ltcx", bad)),
        [
            "units: found `mile`, wanted one of mm, cm, m, in, ft, um",
            "node[1]: found `-1` as radius, wanted a radius > 0",
            "node[2]: found a second node 10, wanted each number once",
            "node[3]: found `NaN` as x, wanted a finite number",
            "beam[0]: found `99`, wanted the number of one of the 3 nodes",
            "beam[1]: found `12`, wanted the number of one of the 3 nodes",
        ]
    );
}

#[test]
fn abaqus_beams_have_the_sections_of_their_sets() {
    let part = read("frame.inp", INP);
    assert_eq!((part.format, faults(&part)), (Some(Format::Abaqus), vec![]));
    assert_eq!(count(&part), (6, 6));
    assert_eq!(strut(&part, 0), ([0.0; 3], [10.0, 0.0, 0.0], [1.25; 2]));
    assert_eq!(strut(&part, 1), ([0.0; 3], [0.0, 10.0, 0.0], [0.5; 2]), "B32 with its middle on the line");
    assert_eq!(strut(&part, 2), ([0.0; 3], [1.0, 0.0, 5.0], [0.5; 2]), "B32 with its middle off it");
    assert_eq!(strut(&part, 3), ([1.0, 0.0, 5.0], [0.0, 0.0, 10.0], [0.5; 2]));
    assert_eq!(strut(&part, 4), ([10.0, 0.0, 0.0], [10.0, 10.0, 0.0], [1.0; 2]), "a truss: the area of a circle");
    assert_eq!(
        notes(&part)[..2],
        [
            "document: 1 elements of three nodes are straight: their middle nodes are left out",
            "document: elements of type C3D8 are left out: only beams and trusses are struts"
        ]
    );
}

/// Sets of sets multiply: 230 kB took 600 MB.
#[test]
fn abaqus_sets_of_sets_are_bounded() {
    let mut text = "*Node\n1,0,0,0\n2,1,0,0\n*Element, type=B31, elset=a\n".to_owned();
    (0..20_000).for_each(|k| text += &format!("{k},1,2\n"));
    (0..2_000).for_each(|k| text += &format!("*Elset, elset=s{k}\na\n"));
    let told = faults(&read("sets.inp", text));
    assert!(told.iter().any(|f| f.ends_with("found more than 10000000 members of element sets, wanted at most 10000000")), "{told:?}");
}

#[test]
fn abaqus_files_that_make_or_move_nodes_are_refused() {
    let cases = [
        (
            INP.replace("*Instance, name=PART-1-1, part=PART-1", "*Instance, name=PART-1-1, part=PART-1\n1., 0., 0."),
            "line 41: found an instance that is moved, wanted a part where it stands",
        ),
        (INP.replace("*End Instance", "*End Instance\n*Instance, name=B, part=PART-1"), "line 42: found a second instance, wanted one instance of one part"),
        (
            INP.replace("*Element, type=B31, elset=Thick", "*NGEN\n1, 3\n*Element, type=B31, elset=Thick"),
            "line 13: found *NGEN, wanted nodes and elements in full, in one system",
        ),
        (INP.replace("*Node, nset=all", "*Node, input=other.inp"), "line 5: found *node in another file, wanted everything in one file"),
        (
            INP.replace("elset=thick, material=m, section=CIRC", "elset=thick, material=m, section=PIPE"),
            "line 31: found SECTION=PIPE, wanted SECTION=CIRC: struts are round and full",
        ),
        (INP.replace("1.25\n", "-1.25\n"), "line 32: found `-1.25` as radius, wanted a radius > 0"),
        (INP.replace("10, 2, 7\n", "10, 2, 70\n"), "line 20: found `70`, wanted the number of one of the 7 nodes"),
        (INP.replace("2, 10.,  0.,  0.", "2, 10.,  1e400,  0."), "line 7: found `1e400` as y, wanted a finite number"),
        ("*Node\n1,0,0,0\n*Element, type=S4\n1,1,1,1,1\n".into(), "document: found elements of type S4, wanted elements of type B31, B32 or T3D2"),
    ];
    for (text, wanted) in cases {
        let found = faults(&read("bad.inp", &text));
        assert!(found.contains(&wanted.to_owned()), "{wanted}: {found:#?}");
    }
    let bare = INP.replace("*Beam Section, elset=thick, material=m, section=CIRC\n1.25\n", "");
    assert!(faults(&read("bare.inp", bare))[0].starts_with("line 14: found no radius for 1 of 6 struts of this Abaqus file, wanted `--radius-rule"));
}
