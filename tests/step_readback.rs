//! The writer's files as an independent reader sees them.

mod skins;

use glam::DVec3;
use lattice_brep::brep::*;
use lattice_brep::step::*;

fn written(caps: Caps, options: &StepOptions) -> (Model, Measure, Vec<u8>) {
    let turns = [(4, 0.1), (4, 0.1), (5, 0.3), (5, 0.301), (3, 0.0)];
    let (graph, skins) = skins::row(DVec3::new(5.0, -3.0, 1.0), DVec3::new(1.0, 0.3, -0.2), 4.0, 0.5, &turns);
    let model = assemble(&graph, &skins::shelved(&skins), &AssembleOptions { caps }).unwrap();
    let measure = measure(&model.solids[0]).unwrap();
    let mut out = vec![];
    write(&model, &Facts { measure, gap_mm: 0.0 }, options, &mut out).unwrap();
    (model, measure, out)
}

#[test]
fn the_reader_finds_what_was_written() {
    for schema in [Schema::Ap242, Schema::Ap214, Schema::Ap203] {
        for caps in [Caps::Flat, Caps::Sphere] {
            let name = "Größe 'x' \\ 🦀";
            let options = StepOptions { schema, product: name.into(), ..StepOptions::default() };
            let (model, measure, bytes) = written(caps, &options);
            let found = read_back(&bytes[..]).unwrap();
            assert_eq!(found.faults(), Vec::<String>::new(), "{schema:?} {caps:?}");
            assert_eq!(found.schema, [schema.identifier()]);
            assert_eq!(found.products, [name]);
            assert_eq!((found.length_unit.as_ref().unwrap().1, found.uncertainty), (1e-3, Some(1e-7)));
            assert_eq!(found.circles, if caps == Caps::Flat { 12 } else { 14 });
            let counts = Counts::of(&model.solids[0]);
            let s = &found.solids[0];
            assert_eq!((found.solids.len(), s.shells, s.bad_edges, s.euler), (1, 1, 0, 2));
            assert_eq!((s.faces, s.edges, s.vertices), (counts.faces, counts.edges, counts.vertices));
            assert_eq!((s.cylinders, s.splines, s.other_faces, s.node_groups), (6, 42, 0, 5));
            assert_eq!(s.planes + s.spheres, 2);
            if schema == Schema::Ap203 {
                assert_eq!(found.validation, Validation::default());
            } else {
                assert_eq!(found.validation.volume, Some(measure.volume));
                assert_eq!(found.validation.area, Some(measure.area));
                assert_eq!(found.validation.centroid, Some(measure.centroid.to_array()));
            }
        }
    }
}

#[test]
fn cones_are_counted_apart_from_cylinders() {
    let (graph, skins) = skins::tapered_row(DVec3::ZERO, DVec3::X, 4.0, &[0.5, 0.5, 0.7, 0.6], &[(4, 0.0), (3, 0.5)]);
    let model = assemble(&graph, &skins::shelved(&skins), &AssembleOptions { caps: Caps::Sphere }).unwrap();
    let measure = measure(&model.solids[0]).unwrap();
    let mut out = vec![];
    write(&model, &Facts { measure, gap_mm: 0.0 }, &StepOptions::default(), &mut out).unwrap();
    let found = read_back(&out[..]).unwrap();
    assert_eq!(found.faults(), Vec::<String>::new());
    let s = &found.solids[0];
    assert_eq!((s.cylinders, s.cones, s.spheres, s.splines, s.other_faces, s.bad_edges), (1, 2, 2, 14, 0, 0));
    assert_eq!(found.validation.volume, Some(measure.volume));
}

#[test]
fn an_open_shell_is_a_fault() {
    let (_, _, bytes) = written(Caps::Flat, &StepOptions::default());
    let text = String::from_utf8(bytes).unwrap();
    // The shell without its first face.
    let at = text.find("CLOSED_SHELL('',(").unwrap() + "CLOSED_SHELL('',(".len();
    let comma = at + text[at..].find(',').unwrap();
    let open = format!("{}{}", &text[..at], &text[comma + 1..]);
    let found = read_back(open.as_bytes()).unwrap();
    assert!(found.solids[0].bad_edges > 0);
    assert!(found.faults()[0].contains("not used exactly twice"));
}

#[test]
fn what_is_not_step_is_refused_in_words() {
    for (text, wanted) in [
        (&b"{\"nodes\": []}"[..], "not a STEP file: it begins with \"{\\\"nodes"),
        (b"", "not a STEP file: it begins with \"\""),
        (b"\x89PNG\r\n\x1a\n\0\0", "not a STEP file"),
        (b"ISO-10303-21;\nHEADER;\nENDSEC", "broken STEP file: "),
        (
            b"ISO-10303-21;\nHEADER;\nFILE_DESCRIPTION((''),'2;1');\nFILE_NAME('','',(''),(''),'','','');\nFILE_SCHEMA(('X'));\nENDSEC;\nDATA;\n#1=POINT(",
            "broken STEP file: ",
        ),
    ] {
        let error = read_back(text).unwrap_err().to_string();
        assert!(error.starts_with(wanted), "{error}");
    }
}

#[test]
fn a_file_without_solids_says_so() {
    let (_, _, bytes) = written(Caps::Flat, &StepOptions::default());
    let text = String::from_utf8(bytes).unwrap();
    let header = &text[..text.find("DATA;").unwrap() + 6];
    let found = read_back(format!("{header}ENDSEC;\nEND-ISO-10303-21;\n").as_bytes()).unwrap();
    assert_eq!(found.faults(), ["no solid in the file"]);
}
