//! 3MF beam lattices: radii, caps, balls, clip meshes, components, transforms, units; and archives that mean harm.

mod imported;

use imported::{count, faults, notes, read, read_with, strut};
use lattice_brep::graph::import::{Format, ImportOptions, RadiusRule, Units};
use std::io::{Cursor, Write};
use zip::write::SimpleFileOptions;

const RELS: &str = r#"<?xml version="1.0" encoding="UTF-8"?><Relationships xmlns="http://schemas.openxmlformats.org/package/2006/relationships">
<Relationship Target="/3D/3dmodel.model" Id="rel0" Type="http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"/></Relationships>"#;

fn archive(files: &[(&str, &[u8])]) -> Vec<u8> {
    let mut zip = zip::ZipWriter::new(Cursor::new(Vec::new()));
    for (name, bytes) in files {
        zip.start_file(*name, SimpleFileOptions::default().compression_method(zip::CompressionMethod::Deflated)).unwrap();
        zip.write_all(bytes).unwrap();
    }
    zip.finish().unwrap().into_inner()
}

fn package(model: &str) -> Vec<u8> {
    archive(&[("_rels/.rels", RELS.as_bytes()), ("3D/3dmodel.model", model.as_bytes())])
}

/// A model with these resources and this build; the beam lattice has the prefix `b`.
fn model(resources: &str, build: &str) -> String {
    format!(
        r#"<?xml version="1.0" encoding="utf-8"?><model unit="millimeter" xmlns="http://schemas.microsoft.com/3dmanufacturing/core/2015/02"
 xmlns:b="http://schemas.microsoft.com/3dmanufacturing/beamlattice/2017/02" xmlns:bb="http://schemas.microsoft.com/3dmanufacturing/beamlattice/balls/2020/07"
 xmlns:t="http://schemas.autodesk.com/dmg/beamlatticetag/2017/02" xmlns:p="http://schemas.microsoft.com/3dmanufacturing/production/2015/06"
 requiredextensions="b"><resources>{resources}</resources><build>{build}</build></model>"#
    )
}

const VERTICES: &str = r#"<vertices><vertex x="0" y="0" z="0"/><vertex x="10 " y="0" z="0"/><vertex x="0" y=" 10" z="0"/><vertex x="0" y="0" z="10"/><vertex x="99" y="99" z="99"/></vertices>"#;

/// An object of three beams; the last vertex has none.
fn object(lattice: &str, beams: &str) -> String {
    format!(
        r#"<object id="1" name="Corner" type="model"><mesh>{VERTICES}<triangles><triangle v1="0" v2="1" v3="2"/></triangles><b:beamlattice {lattice}><b:beams>{beams}</b:beams></b:beamlattice></mesh></object>"#
    )
}

const BEAMS: &str = r#"<b:beam v1="0" v2="1"/><b:beam v1="0" v2="2" r1="0.5"/><b:beam v1="3" v2="0" r1="0.75" r2="1.25" cap1="butt" cap2="hemisphere"/>"#;

fn corner() -> String {
    object(r#"radius="1.5" minlength="0.0001""#, BEAMS)
}

const ITEM: &str = r#"<item objectid="1"/>"#;

#[test]
fn radii_come_from_the_beam_or_the_lattice_and_everything_left_out_is_noted() {
    let part = read("corner.3mf", package(&model(&corner(), ITEM)));
    assert_eq!((part.format, count(&part), faults(&part)), (Some(Format::ThreeMf), (4, 3), vec![]));
    assert_eq!(part.input.name.as_deref(), Some("Corner"));
    assert_eq!(strut(&part, 0), ([0.0; 3], [10.0, 0.0, 0.0], [1.5, 1.5]));
    assert_eq!(strut(&part, 1), ([0.0; 3], [0.0, 10.0, 0.0], [0.5, 0.5]));
    assert_eq!(strut(&part, 2), ([0.0, 0.0, 10.0], [0.0; 3], [0.75, 1.25]));
    assert_eq!(
        notes(&part),
        [
            "object[1]: a surface of 1 triangles: left out",
            "object[1]: cap modes of beam ends: 1 butt, 1 hemisphere, 4 sphere; free ends are closed as --caps says",
        ]
    );
}

#[test]
fn units_prefixes_and_displacement_meshes_make_no_difference() {
    let units = [("micron", 1e-3), ("millimeter", 1.0), ("centimeter", 10.0), ("inch", 25.4), ("foot", 304.8), ("meter", 1000.0)];
    for (unit, mm) in units {
        let part = read("u.3mf", package(&model(&corner(), ITEM).replace("millimeter", unit)));
        assert_eq!((strut(&part, 0).1[0], strut(&part, 0).2[0]), (10.0 * mm, 1.5 * mm), "{unit}");
    }
    // the core namespace with a prefix, the lattice without one, the mesh a displacement mesh
    let renamed = r#"<c:model xmlns:c="http://schemas.microsoft.com/3dmanufacturing/core/2015/02" xmlns:zz="http://schemas.3mf.io/3dmanufacturing/displacement/2023/10"
 xmlns="http://schemas.microsoft.com/3dmanufacturing/beamlattice/2017/02"><c:resources><c:object id="1"><zz:displacementmesh><zz:vertices><zz:vertex x="0" y="0" z="0"/><zz:vertex x="4" y="0" z="0 "/></zz:vertices>
 <beamlattice clippingmode="none" minlength="0.0001 " radius="0 " cap="hemisphere"><beams><beam v1="0 " v2="1" r1="0.500000 "/></beams></beamlattice></zz:displacementmesh></c:object></c:resources>
 <c:build><c:item objectid="1"/></c:build></c:model>"#;
    let part = read("d.3mf", package(renamed));
    assert_eq!((count(&part), faults(&part)), ((2, 1), vec![]));
    assert_eq!(strut(&part, 0), ([0.0; 3], [4.0, 0.0, 0.0], [0.5, 0.5]));
    // elements of other namespaces are not beams
    let foreign = model(&object(r#"radius="1""#, &format!(r#"{BEAMS}<t:beam v1="77" v2="88"/>"#)), ITEM);
    assert_eq!((count(&read("t.3mf", package(&foreign))), faults(&read("t.3mf", package(&foreign)))), ((4, 3), vec![]));
}

#[test]
fn items_and_components_are_moved_turned_and_scaled() {
    let tree = r#"<object id="2"><components><component objectid="1" transform="0 1 0 -1 0 0 0 0 1 100 0 0"/><component objectid="1"/></components></object>"#;
    let build = r#"<item objectid="2" transform="2 0 0 0 2 0 0 0 2 0 0 7"/><item objectid="1" transform="1 0 0 0 1 0 0 0 -1 0 500 0"/>"#;
    let part = read("tree.3mf", package(&model(&(corner() + tree), build)));
    assert_eq!((count(&part), faults(&part)), ((12, 9), vec![]));
    // turned by 90° about z and moved by the component, then doubled and lifted by the item
    assert_eq!(strut(&part, 0), ([200.0, 0.0, 7.0], [200.0, 20.0, 7.0], [3.0, 3.0]));
    assert_eq!(strut(&part, 3), ([0.0, 0.0, 7.0], [20.0, 0.0, 7.0], [3.0, 3.0]));
    assert_eq!(strut(&part, 8), ([0.0, 500.0, -10.0], [0.0, 500.0, 0.0], [0.75, 1.25]), "mirrored");
    assert!(notes(&part).contains(&"object[1]: 3 instances in the build".to_owned()));
}

#[test]
fn a_transform_that_makes_struts_oval_is_refused_and_one_printed_with_few_digits_is_not() {
    let build = r#"<item objectid="1" transform="2 0 0 0 1 0 0 0 1 0 0 0"/><item objectid="1" transform="1 0 0 0.1 1 0 0 0 1 0 0 0"/><item objectid="1" transform="0 0 0 0 0 0 0 0 0 0 0 0"/><item objectid="1" transform="1 2 3"/>"#;
    let found = faults(&read("oval.3mf", package(&model(&corner(), build))));
    assert_eq!(found.len(), 4, "{found:#?}");
    assert_eq!(
        found[1],
        "build.item[0].transform: found a transform that changes shapes (lengths of the axes 2, 1, 1), wanted rotation, mirror, one scale: a round strut must stay round"
    );
    assert!(found[2].starts_with("build.item[1].transform: ") && found[3].starts_with("build.item[2].transform: "));
    assert_eq!(found[0], "build.item[3].transform: found `1 2 3`, wanted 12 finite numbers");
    let turned = r#"<item objectid="1" transform="0.70711 0.70711 0 -0.70711 0.70711 0 0 0 1 0 0 0"/>"#;
    let part = read("turned.3mf", package(&model(&corner(), turned)));
    assert_eq!(faults(&part), Vec::<String>::new());
    assert!((strut(&part, 0).2[0] - 1.5).abs() < 1e-5);
}

#[test]
fn clip_meshes_of_old_and_new_files_and_balls_are_noted() {
    let object = |attributes: &str| object(attributes, &format!(r#"{BEAMS}</b:beams><bb:balls><bb:ball vindex="0" r="3"/></bb:balls><b:beams>"#));
    for old_or_new in ["clipping", "clippingmode"] {
        let attributes = format!(r#"radius="1" {old_or_new}="inside" clippingmesh="7" representationmesh="8" bb:ballmode="mixed" bb:ballradius="2""#);
        let part = read("clip.3mf", package(&model(&object(&attributes), ITEM)));
        assert_eq!(faults(&part), Vec::<String>::new());
        let notes = notes(&part);
        for what in ["clipped inside by object 7: ignored, struts keep their whole length", "representation mesh 8: ignored", "balls (1): ignored"] {
            assert!(notes.contains(&format!("object[1]: {what}")), "{what}: {notes:#?}");
        }
    }
}

#[test]
fn beams_shorter_than_the_minimum_are_left_out() {
    let short = model(&object(r#"radius="1" minlength="10.5""#, r#"<b:beam v1="0" v2="1"/><b:beam v1="1" v2="2"/>"#), ITEM);
    let part = read("short.3mf", package(&short));
    assert_eq!(count(&part), (2, 1));
    assert!(notes(&part).contains(&"object[1]: 1 beams shorter than minlength 10.5: left out, as the format asks".to_owned()));
}

#[test]
fn a_default_radius_of_zero_asks_for_a_rule_where_a_beam_has_none() {
    let part = || package(&model(&object(r#"radius="0""#, BEAMS), ITEM));
    let found = faults(&read("zero.3mf", part()));
    assert!(
        found.len() == 1 && found[0].starts_with("object[1].beams[0]: found no radius for 1 of 3 struts of this 3MF file, wanted `--radius-rule"),
        "{found:?}"
    );
    let options = ImportOptions { radius_rule: Some(RadiusRule::Shortest(10.0)), unit: None };
    let radii: Vec<_> = (0..3).map(|k| strut(&read_with("zero.3mf", part(), &options), k).2).collect();
    assert_eq!(radii, [[1.0, 1.0], [0.5, 0.5], [0.75, 1.25]]);
    let unit = ImportOptions { radius_rule: None, unit: Some(Units::In) };
    assert_eq!(faults(&read_with("u.3mf", package(&model(&corner(), ITEM)), &unit)), ["--units: found a unit, wanted none: a 3MF file states its own"]);
}

#[test]
fn objects_of_other_model_files_are_found_by_path() {
    let root = model("", r#"<item objectid="1" p:path="/3D/Objects/a.model"/>"#);
    let part = read(
        "split.3mf",
        archive(&[("_rels/.rels", RELS.as_bytes()), ("3D/3dmodel.model", root.as_bytes()), ("3D/Objects/a.model", model(&corner(), "").as_bytes())]),
    );
    assert_eq!((count(&part), faults(&part)), ((4, 3), vec![]));
    let bad = model(&object(r#"radius="1""#, r#"<b:beam v1="0" v2="9"/>"#), "");
    let part = read("split.3mf", archive(&[("_rels/.rels", RELS.as_bytes()), ("3D/3dmodel.model", root.as_bytes()), ("3D/Objects/a.model", bad.as_bytes())]));
    assert_eq!(faults(&part), ["3D/Objects/a.model: object[1].beams[0].v2: found 9, wanted a vertex index below 5"]);
}

#[test]
fn every_bad_value_is_told_with_its_path() {
    let beams =
        r#"<b:beam v1="0" v2="5"/><b:beam v1="-1" v2="1"/><b:beam v2="1"/><b:beam v1="0" v2="1" r1="-2"/><b:beam v1="0" v2="1" r1="nan" r2="x&quot;y&#x9;"/>"#;
    let bad = model(
        &object(r#"radius="1e999""#, beams).replace(r#"x="99""#, r#"x="inf""#).replace(r#"y="99""#, ""),
        r#"<item objectid="1"/><item objectid="7"/><item/>"#,
    );
    assert_eq!(
        faults(&read("bad.3mf", package(&bad.replace("millimeter", "furlong")))),
        [
            "model.unit: found `furlong`, wanted one of micron, millimeter, centimeter, inch, foot, meter",
            "object[1].vertices[4].x: found `inf`, wanted a finite number",
            "object[1].vertices[4].y: found nothing, wanted a finite number",
            "object[1].beamlattice.radius: found `1e999`, wanted a number, at least 0",
            "object[1].beams[1].v1: found `-1`, wanted the index of a vertex",
            "object[1].beams[2].v1: found nothing, wanted the index of a vertex",
            "object[1].beams[3].r1: found `-2`, wanted a radius > 0",
            "object[1].beams[4].r1: found `nan`, wanted a radius > 0",
            "object[1].beams[4].r2: found `x\"y`, wanted a radius > 0",
            "object[1].beams[0].v2: found 5, wanted a vertex index below 5",
            "build.item[2].objectid: found nothing, wanted the id of an object",
            "build.item[1].objectid: found 7, wanted the id of an object",
        ]
    );
    let bare = r#"<object id="1"><mesh><vertices/><triangles/></mesh></object>"#;
    assert_eq!(
        faults(&read("bare.3mf", package(&model(bare, ITEM)))),
        ["build: found 1 items without a beam lattice (0 objects with one), wanted an item whose object has a <beamlattice>"]
    );
}

#[test]
fn content_faults_name_the_beam() {
    let twice = model(&object(r#"radius="1""#, r#"<b:beam v1="0" v2="1"/><b:beam v1="1" v2="0" r1="2"/><b:beam v1="2" v2="2"/>"#), ITEM);
    let Err(error) = read("twice.3mf", package(&twice)).admit(Default::default()) else { panic!("refused") };
    let text = error.to_string();
    assert!(text.contains("struts[1] (object[1].beams[1]): found the same nodes 0 and 1 as struts[0]"), "{text}");
    assert!(text.contains("struts[2] (object[1].beams[2]): found both ends at nodes[2]"), "{text}");
}

#[test]
fn names_keep_their_quotes_controls_and_letters() {
    let title = r#"<metadata name="Title">a &quot;b&quot; \ c' &amp; &#233;é &#x4e2d;/../x</metadata>"#;
    let named = model(&corner(), ITEM).replace("<resources>", &format!("{title}<resources>"));
    assert_eq!(read("n.3mf", package(&named)).input.name.as_deref(), Some("a \"b\" \\ c' & éé 中/../x"));
}

#[test]
fn zip_bombs_end_early() {
    let zeros = archive(&[("_rels/.rels", RELS.as_bytes()), ("3D/3dmodel.model", &vec![b' '; 64 << 20])]);
    assert!(zeros.len() < 100_000);
    let found = faults(&read("bomb.3mf", zeros));
    assert!(
        found.len() == 1 && found[0].starts_with("3D/3dmodel.model: found more than ") && found[0].ends_with("wanted a file that is not a zip bomb"),
        "{found:?}"
    );
}

#[test]
fn components_that_multiply_or_ring_end_early() {
    let level = |id: u32, of: u32| format!(r#"<object id="{id}"><components>{}</components></object>"#, format!(r#"<component objectid="{of}"/>"#).repeat(10));
    let laughs: String = (2..12).map(|id| level(id, id - 1)).collect();
    let found = faults(&read("laughs.3mf", package(&model(&(corner() + &laughs), r#"<item objectid="11"/>"#))));
    assert!(found.iter().any(|f| f == "build: found more than 100000 instances, wanted at most 100000"), "{found:?}");
    let ring = r#"<object id="2"><components><component objectid="3"/></components></object><object id="3"><components><component objectid="2"/></components></object>"#;
    let found = faults(&read("ring.3mf", package(&model(ring, r#"<item objectid="2"/>"#))));
    assert!(found.len() == 1 && found[0].contains("components nested more than 17 deep, wanted at most 16"), "{found:?}");
}

#[test]
fn dtds_entities_and_broken_xml_are_refused() {
    let dtd = r#"<!DOCTYPE model [<!ENTITY a "aaaaaaaaaa"><!ENTITY b "&a;&a;&a;&a;">]>"#;
    let cases = [
        (model(&corner(), ITEM).replace("<model", &format!("{dtd}<model")), "a DTD (<!DOCTYPE), wanted XML without DTD and entities"),
        (model(&corner(), ITEM).replace("\"Corner\"", "\"&b;\""), "wanted well-formed attributes, without entities of their own"),
        (
            model(&corner(), ITEM).replace("<resources>", "<metadata name=\"Title\">&b;</metadata><resources>"),
            "an entity, wanted text without entities of its own",
        ),
        (model(&corner(), ITEM).replace("</build></model>", ""), "found the end of the text, wanted an end of <build>"),
        (model(&corner(), ITEM).replace("</mesh>", "</mush>"), "wanted well-formed XML"),
        (model(&corner(), ITEM).replace("v1=\"0\"", "v1=0"), "wanted well-formed attributes"),
        (model(&corner(), ITEM).replace("encoding=\"utf-8\"", "encoding=\"utf-16\""), "found encoding utf-16, wanted UTF-8"),
        ("<a>".repeat(10_000), "found elements nested 65 deep, wanted at most 64"),
    ];
    for (text, wanted) in cases {
        let found = faults(&read("x.3mf", package(&text)));
        assert!(found.len() == 1 && found[0].starts_with("line ") && found[0].contains(wanted), "{wanted}: {found:?}");
    }
}

#[test]
fn archives_that_lie_or_lack_the_model_are_refused() {
    let whole = package(&model(&corner(), ITEM));
    let cut = &whole[..whole.len() / 2];
    assert!(faults(&read("cut.3mf", cut))[0].contains("wanted a zip archive with a 3MF model"));
    assert_eq!(
        faults(&read("none.3mf", archive(&[("other.txt", b"x")]))),
        ["3D/3dmodel.model: found no such file, wanted a file of the archive, stored or deflated, not encrypted"]
    );
    // a path that leaves the archive is only a name that is not there
    let escape = RELS.replace("/3D/3dmodel.model", "../../../etc/passwd");
    let found = faults(&read("escape.3mf", archive(&[("_rels/.rels", escape.as_bytes())])));
    assert_eq!(found, ["../../../etc/passwd: found no such file, wanted a file of the archive, stored or deflated, not encrypted"]);
    // 65,535 files claimed
    let mut lie = whole.clone();
    let end = lie.len() - 22;
    lie[end + 8..end + 12].fill(0xff);
    assert!(!faults(&read("lie.3mf", &lie)).is_empty() || count(&read("lie.3mf", &lie)) == (4, 3));
    // any one byte changed: a fault or a lattice, never a panic
    for k in (0..whole.len()).step_by(7) {
        let mut broken = whole.clone();
        broken[k] ^= 0x55;
        read("broken.3mf", &broken);
    }
}
