//! The file's text: header, counts, names, determinism, injection. Reading back by an independent
//! crate is in `step_readback.rs`.

mod skins;

use glam::DVec3;
use lattice_brep::brep::*;
use lattice_brep::step::*;

fn model(caps: Caps) -> Model {
    let turns = [(4, 0.1), (4, 0.1), (5, 0.3), (5, 0.301), (3, 0.0)];
    let (graph, skins) = skins::row(DVec3::new(5.0, -3.0, 1.0), DVec3::new(1.0, 0.3, -0.2), 4.0, 0.5, &turns);
    let model = assemble(&graph, &skins::shelved(&skins), &AssembleOptions { caps }).unwrap();
    check_topology(&model).unwrap();
    model
}

fn single(caps: Caps) -> Model {
    let (graph, skins) = skins::row(DVec3::ZERO, DVec3::new(1.0, 2.0, 2.0), 6.0, 0.5, &[]);
    assemble(&graph, &skins::shelved(&skins), &AssembleOptions { caps }).unwrap()
}

/// Radii of a row: cones that grow and shrink, and a cylinder.
const RADII: [f64; 7] = [0.3, 0.5, 0.5, 1.4, 0.9, 0.8, 0.801];

fn tapered(caps: Caps) -> Model {
    let turns = [(4, 0.1), (4, 0.1), (5, 0.3), (5, 0.301), (3, 0.0)];
    let (graph, skins) = skins::tapered_row(DVec3::new(5.0, -3.0, 1.0), DVec3::new(1.0, 0.3, -0.2), 4.0, &RADII, &turns);
    assemble(&graph, &skins::shelved(&skins), &AssembleOptions { caps }).unwrap()
}

fn single_tapered(caps: Caps, radii: [f64; 2]) -> Model {
    let (graph, skins) = skins::tapered_row(DVec3::ZERO, DVec3::new(1.0, 2.0, 2.0), 6.0, &radii, &[]);
    assemble(&graph, &skins::shelved(&skins), &AssembleOptions { caps }).unwrap()
}

fn text(model: &Model, options: &StepOptions) -> String {
    let measure = measure::total(model.solids.iter().map(|s| measure(s).unwrap()));
    let facts = Facts { measure, gap_mm: quality(model, 9, &[]).gap_mm.value };
    let mut out = vec![];
    write(model, &facts, options, &mut out).unwrap();
    String::from_utf8(out).unwrap()
}

fn count(text: &str, entity: &str) -> usize {
    text.matches(&format!("={entity}(")).count()
}

#[test]
fn entities_are_counted_as_designed() {
    let text = text(&model(Caps::Flat), &StepOptions::default());
    assert_eq!(count(&text, "CYLINDRICAL_SURFACE"), 6);
    assert_eq!(count(&text, "CIRCLE"), 12);
    assert_eq!(count(&text, "PLANE"), 2);
    assert_eq!(count(&text, "ADVANCED_FACE"), 6 + 2 + 42);
    assert_eq!(count(&text, "MANIFOLD_SOLID_BREP"), 1);
    assert_eq!(text.matches("RATIONAL_B_SPLINE_SURFACE(").count(), 42);
    assert_eq!(2 * count(&text, "EDGE_CURVE"), count(&text, "ORIENTED_EDGE"));
    assert!(text.contains("ADVANCED_FACE('node_2/strut_1/1',"));
    assert!(text.contains("ADVANCED_FACE('strut_3',"));
    assert!(text.contains("ADVANCED_FACE('node_0/cap',"));
    assert!(text.contains("ADVANCED_FACE('node_6/cap',"));
}

/// The half-angle is above 0, in radians; the placement is at the rim from which the radius grows.
#[test]
fn tapered_struts_are_cones() {
    let all = text(&tapered(Caps::Flat), &StepOptions::default());
    assert_eq!((count(&all, "CYLINDRICAL_SURFACE"), count(&all, "CONICAL_SURFACE"), count(&all, "CIRCLE")), (1, 5, 12));
    for (radii, at, axis) in [([0.5, 0.8], "0.,0.,0.", ["0.333333333333", "0.666666666666"]), ([0.8, 0.5], "2.,4.,4.", ["-0.333333333333", "-0.666666666666"])]
    {
        let text = text(&single_tapered(Caps::Flat, radii), &StepOptions::default());
        let entity = |id: &str| text.lines().find_map(|l| l.strip_prefix(&format!("#{id}="))).unwrap().to_owned();
        let inner = |body: &str, kind: &str| body.strip_prefix(kind).unwrap().trim_end_matches(");").to_owned();
        let cone = text.lines().find_map(|l| l.split_once("=CONICAL_SURFACE('',#")).unwrap().1.trim_end_matches(");");
        let [placement, radius, angle] = cone.split(',').collect::<Vec<_>>().try_into().unwrap();
        assert_eq!(radius, "0.5");
        assert!((angle.parse::<f64>().unwrap() / 0.05f64.atan() - 1.0).abs() < 1e-14);
        let placement = inner(&entity(placement), "AXIS2_PLACEMENT_3D('',#");
        let [center, z, _] = placement.split(",#").collect::<Vec<_>>().try_into().unwrap();
        assert_eq!(inner(&entity(center), "CARTESIAN_POINT('',("), format!("{at})"));
        let z = inner(&entity(z), "DIRECTION('',(");
        assert!(z.starts_with(axis[0]) && z.contains(axis[1]), "{z}");
    }
}

#[test]
fn ids_are_unique_and_every_reference_exists() {
    for (schema, model) in
        [(Schema::Ap242, model(Caps::Sphere)), (Schema::Ap214, model(Caps::Flat)), (Schema::Ap203, tapered(Caps::Sphere)), (Schema::Ap242, tapered(Caps::Flat))]
    {
        let text = text(&model, &StepOptions { schema, ..StepOptions::default() });
        let mut defined = std::collections::HashSet::new();
        let id = |s: &str| s.chars().take_while(char::is_ascii_digit).collect::<String>();
        for line in text.lines().filter(|l| l.starts_with('#') && l.contains('=')) {
            assert!(defined.insert(id(&line[1..])), "defined twice: {line}");
        }
        let data = &text[text.find("DATA;").unwrap()..];
        for reference in data.split('#').skip(1) {
            assert!(defined.contains(&id(reference)), "#{} is not defined", id(reference));
        }
    }
}

#[test]
fn header_and_validation_properties() {
    let options = StepOptions { time_stamp: "2026-11-22T10:11:12".parse().unwrap(), ..StepOptions::default() };
    let text = text(&single(Caps::Flat), &options);
    assert!(text.starts_with("ISO-10303-21;\nHEADER;\nFILE_DESCRIPTION(('Lattice solid','CAx-IF Rec.Pracs."));
    assert!(text.contains("'2;1');\nFILE_NAME('lattice.step','2026-11-22T10:11:12',"));
    assert!(text.contains("FILE_SCHEMA(('AP242_MANAGED_MODEL_BASED_3D_ENGINEERING_MIM_LF { 1 0 10303 442 1 1 4 }'));"));
    assert!(text.contains("MEASURE_REPRESENTATION_ITEM('volume measure',VOLUME_MEASURE(4.71238898038469)"));
    assert!(text.contains("MEASURE_REPRESENTATION_ITEM('surface area measure',AREA_MEASURE(20.42035224833365"));
    assert!(text.contains("CARTESIAN_POINT('centre point',(1.,2.,2.))"));
    assert!(text.contains("LENGTH_MEASURE(1.E-7)") || text.contains("LENGTH_MEASURE(1.E-07)"));
    assert!(text.ends_with("ENDSEC;\nEND-ISO-10303-21;\n"));
    assert!(text.is_ascii());
}

#[test]
fn ap203_has_its_administration_and_no_newer_entity() {
    let text = text(&single(Caps::Flat), &StepOptions { schema: Schema::Ap203, ..StepOptions::default() });
    for entity in
        ["MECHANICAL_CONTEXT", "DESIGN_CONTEXT", "CC_DESIGN_APPROVAL", "CC_DESIGN_SECURITY_CLASSIFICATION", "APPROVAL_DATE_TIME", "PERSON_AND_ORGANIZATION"]
    {
        assert_eq!(count(&text, entity), 1, "{entity}");
    }
    assert_eq!(count(&text, "STYLED_ITEM") + count(&text, "MEASURE_REPRESENTATION_ITEM"), 0);
    assert!(text.contains("FILE_SCHEMA(('CONFIG_CONTROL_DESIGN'));"));
}

#[test]
fn bytes_do_not_depend_on_threads_or_runs() {
    let model = model(Caps::Sphere);
    let in_pool = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| text(&model, &StepOptions::default()))
    };
    let one = in_pool(1);
    assert!(one == in_pool(2) && one == in_pool(8) && one == in_pool(8));
}

#[test]
fn names_cannot_inject_entities() {
    let plain = text(&single(Caps::Flat), &StepOptions::default());
    let evil = "x');\n#9=EVIL('\\X2\\ü🦀";
    let options = StepOptions { product: evil.into(), author: evil.into(), organization: evil.into(), file_name: evil.into(), ..StepOptions::default() };
    let text = text(&single(Caps::Flat), &options);
    assert_eq!(text.lines().count(), plain.lines().count());
    assert!(text.is_ascii());
    assert!(text.contains(r"#4=PRODUCT('x'');\X2\000A\X0\#9=EVIL(''\\X2\\\X2\00FC\X0\\X4\0001F980\X0\',"));
}

#[test]
fn what_cannot_be_written_is_refused() {
    let good = single(Caps::Flat);
    let facts = Facts { measure: Measure::default(), gap_mm: 0.0 };
    let refused = |model: &Model, facts: &Facts, options: &StepOptions| write(model, facts, options, std::io::sink()).unwrap_err();
    let mut bad = good.clone();
    bad.solids[0].extra[0].x = f64::NAN;
    assert!(matches!(refused(&bad, &facts, &StepOptions::default()), StepError::NotFinite { solid: 0 }));
    let options = StepOptions { product: "\n".into(), ..StepOptions::default() };
    assert!(matches!(refused(&good, &facts, &options), StepError::NoProductName));
    let options = StepOptions { colour: [0.0, 2.0, 0.0], ..StepOptions::default() };
    assert!(matches!(refused(&good, &facts, &options), StepError::Colour(_)));
    let facts = Facts { gap_mm: f64::NAN, ..facts };
    assert!(matches!(refused(&good, &facts, &StepOptions::default()), StepError::FactsNotFinite));
}

/// Files for other programs, in the target's `tmp` folder: `cargo test --test step_write -- --ignored`.
#[test]
#[ignore = "writes files for other programs to judge"]
fn samples() {
    let folder = std::path::Path::new(env!("CARGO_TARGET_TMPDIR"));
    let rows =
        [("row_flat", model(Caps::Flat)), ("row_sphere", model(Caps::Sphere)), ("single_flat", single(Caps::Flat)), ("single_sphere", single(Caps::Sphere))];
    let cones = [
        ("cones_flat", tapered(Caps::Flat)),
        ("cones_sphere", tapered(Caps::Sphere)),
        ("cone_up", single_tapered(Caps::Flat, [0.5, 0.8])),
        ("cone_down", single_tapered(Caps::Sphere, [0.8, 0.5])),
        ("cone_steep", single_tapered(Caps::Sphere, [0.1, 6.0])),
        ("cone_flattest", single_tapered(Caps::Flat, [600.0, 0.001])),
        ("cone_slight", single_tapered(Caps::Sphere, [0.5, 0.5 + 1e-8])),
        ("cone_least", single_tapered(Caps::Sphere, [0.5, 0.5 + 1.2e-16])),
    ];
    for (name, model) in rows.into_iter().chain(cones) {
        for schema in [Schema::Ap242, Schema::Ap214, Schema::Ap203] {
            let options = StepOptions { schema, product: "Größe 'x'".into(), ..StepOptions::default() };
            std::fs::write(folder.join(format!("{name}_{schema:?}.step")), text(&model, &options)).unwrap();
        }
    }
}
